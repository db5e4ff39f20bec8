"""The table by which compiled code reaches a machine whose start is assembled and measured.

As that of a run it begins with the kernels, so that it stands for them. `context.x` is an array.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from runtime.core.arrays import Integers, f8, i8, integers, vector
from runtime.core.function_table_layout import TableLayout
from runtime.core.kernel_abi import KERNELS
from runtime.linalg.least_norm import SPARSE_FROM

if TYPE_CHECKING:
    from runtime.mechanism.mechanism import Mechanism

START = TableLayout(attributes=True)

_N = START.number("start_coordinates")
_M = START.number("start_constraints")
_ROWS = START.number("dense_start_rows")  # m and n of a machine with dense matrices; else 0
_COLUMNS = START.number("dense_start_columns")
_NONZEROS = START.number("start_nonzeros")  # of Φ_q
_PARAMETERS = START.number("declared_parameters")

LEAD = START.size  # slot of what leads Newton's method from afar; 0: nothing does
LEADING = i8(integers, f8, vector, vector)  # context t p q; 0
lead_of = START.function("lead", LEADING)

# What the tables of a machine say of its coordinates and constraints.
START.integers("slope_rows slope_columns", _NONZEROS, allotted=False)
START.integers("of_length", _N, allotted=False)  # 1 of coordinates that are lengths
START.integers("scaled_by_length", _N, allotted=False)  # of those measured in the machine's length
START.integers("every", _N, allotted=False)  # 1 of every coordinate
START.floats("typical", _N, allotted=False)  # changes of the coordinates that are no lengths
START.matrix("turns", (2, None), _N, allotted=False)  # to two positions with all angles turned
START.floats("neutral", _N, allotted=False)  # the position without start values
START.integers("in_metres", _PARAMETERS, allotted=False)  # 1 of parameters in m

# What is free to move, 1, and how much it weighs.
START.integers("free_q free_v", _N)
START.floats("move_weight", _N)

# Room: Φ_q at a position and in another pose, what enters each constraint, typical changes.
START.floats("slopes other_slopes", _NONZEROS)
START.floats("pose change_scale", _N)
START.floats("phi row_scale steepest", _M)
START.integers("marks", _M)

# Room in which joints are closed.
START.floats("gaps", _M)
START.floats("origin moved move_step move_right", _N)
START.matrix("scaled_rows", _ROWS, _COLUMNS)
START.matrix("lower", _ROWS, _ROWS)
START.matrix("normal", _COLUMNS, _COLUMNS)


class StartTable(NamedTuple):
    """A table, and the arrays by name that must live as long as it."""

    table: Integers
    arrays: dict[str, Any]


def start_table(mechanism: "Mechanism") -> StartTable:
    """A new table of a machine."""
    shape, table = mechanism.shape, np.zeros(START.size, np.int64)
    table[: len(KERNELS)] = mechanism.kernel_table
    n, m = len(shape["neutral"]), len(mechanism.description.constraints)
    dense = n < SPARSE_FROM
    table[[_N, _M, _ROWS, _COLUMNS]] = n, m, m * dense, n * dense
    table[_NONZEROS], table[_PARAMETERS] = len(shape["slope_rows"]), len(shape["in_metres"])
    arrays = START.allot(table)
    for name, array in shape.items():
        arrays[name] = array
        table[START.slots[name]] = array.ctypes.data
    return StartTable(table, arrays)
