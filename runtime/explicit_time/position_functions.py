"""The narrow functions of the position that a run encloses over each step, as entries of its table.

They are looked at where the machine stands: reduced coordinates are expanded to all of them.
"""

from typing import TYPE_CHECKING

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.array_types import Vector
from runtime.core.jit import addresses
from runtime.explicit_time.function_scan import FunctionArrays
from runtime.explicit_time.interval_evaluation import enclose
from runtime.explicit_time.position_step_check import ROWS, find_resolved_part
from runtime.integrate.problem import TableEntries
from runtime.mechanism.module_tables import Description

if TYPE_CHECKING:
    from runtime.mechanism.reduced_kernels import Reduced

_EVERYWHERE = 1e3  # safety: times the typical size; where a value's range is taken


def position_entries(
    description: Description, p: Vector, sizes: Vector, times: tuple[float, float],
    reduced: "Reduced | None" = None,
) -> TableEntries:  # fmt: skip
    """Entries of the table of a run with parameters `p`, in all coordinates or reduced ones.

    `sizes` are typical sizes of all coordinates, (n,), `times` the start and the end, s.
    """
    watched, rows = description.position_functions
    declared, n = len(description.parameters), len(sizes)
    functions = FunctionArrays(rows, watched, {"q": declared})
    for k, row in enumerate(rows):
        if row[0] == "q":  # in `box`, its bounds
            functions.code[k, 2] = functions.code[k, 1] + n
    far = _EVERYWHERE * sizes
    box = np.concatenate([p[:declared], -far, far])
    work = np.zeros((ROWS, len(rows)))
    low, high = np.zeros((2, len(rows)))
    arrays = functions.code, functions.numbers, box, functions.knots, functions.pieces
    enclose(*arrays, *times, low, high, work[0])
    ranges = (high - low)[functions.watched]
    scales = np.where(np.isfinite(ranges), ranges, 1.0)  # as that of most pure functions
    angles = np.zeros(0, np.int64) if reduced is None else reduced.angles
    check, *expand = addresses([find_resolved_part, *([] if reduced is None else [reduced.expand])])
    slots = ft.TABLE.slots
    numbers = {
        ft.POSITION_ROWS: len(rows), ft.WATCHED_ROWS: len(watched), ft.POSITION_BOX: len(box),
        ft.ALL_COORDINATES: n, ft.EXPANDED: len(expand), ft.EXPANDED_ANGLES: len(angles),
        slots["resolved_part"]: int(check), slots["expand"]: int(expand[0]) if expand else 0,
    }  # fmt: skip
    return TableEntries(
        numbers,
        {
            "position_code": functions.code, "position_numbers": functions.numbers,
            "position_box": box, "position_watched": functions.watched,
            "position_scales": scales, "position_work": work,
            "position_motion": np.zeros((n, 4)), "position_ends": np.zeros((4, n)),
            "position_angles": np.ascontiguousarray(angles),
            "position_turns": np.zeros(len(angles)),
        },
    )  # fmt: skip
