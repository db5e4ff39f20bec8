"""The change of method in a run, between two steps."""

from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from runtime.core.workspace import PARTITION
from runtime.integrate.wiring import METHOD_SLOTS, function_table, method

if TYPE_CHECKING:
    from runtime.integrate.run import _Run

_FORESIGHT = 0.1  # of the coordinates' sizes: what is nearer matters to the finest tolerances
_MOST_PATIENCE = 1024  # times the first, before a method is changed


def fill_method(r: Any, parts: ModuleType) -> None:
    """Write into a run's record the numbers of the method that is the module `parts`."""
    r["order"], r["last"] = parts.ORDER, parts.LAST
    r["stage_calls"], r["dense_calls"] = parts.STAGE_CALLS, parts.DENSE_CALLS
    r["dense_rows"] = parts.DENSE_ROWS
    r["exponent"], r["beta"] = 1.0 / (parts.ERROR_ORDER + 1), parts.BETA
    r["foresight"] = getattr(parts, "FORESIGHT", _FORESIGHT)
    r["safety"], r["shrink"], r["grow"] = parts.SAFETY, parts.SHRINK, parts.GROW


def change_method(run: "_Run") -> None:
    """Go on with the method that suits: the state and its derivative are all that it needs.

    Each change doubles the number of steps that have to speak for the next one.
    """
    from runtime.integrate.implicit.stiffness_switching import (
        successor,  # most runs need none of its functions
    )

    r = run.r
    free = run.rows[PARTITION, 0] == 0.0
    freedoms = int(np.count_nonzero(free)) if run.m else run.n
    name = successor(run.methods[-1][1], freedoms, run.options.rtol)
    run.methods.append((float(r["t"]), name))
    r["patience"] = min(2 * r["patience"], _MOST_PATIENCE)
    adopt(run, name)


def adopt(run: "_Run", name: str) -> None:
    """Take the next steps with the method `name`, for which nothing is to be remembered."""
    r, parts = run.r, method(name)
    fill_method(r, parts)
    run.crossings.follow(parts)
    run.table[METHOD_SLOTS] = function_table(name)
    run.wiring.arrays["notes"][:] = 0
    parts.restart(run.table, r["t"], r["h"])
