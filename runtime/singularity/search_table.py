"""The table by which compiled searches reach a machine's constraints, and its first readers.

One array of integers holds addresses of kernels and of arrays, and a few numbers, as in
`runtime.core.function_table`. In scaled coordinates a position is z = (q / scale, t speed),
of shape (n + 1,).
"""

from typing import Any, NamedTuple

import numpy as np

from runtime.core.array_types import Integers, Kernel, Vector, f8, integers, none, vector
from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.jit import addresses, compiled, inner
from runtime.core.kernel_abi import constraints_of, jacobian_of, velocity_rhs_of
from runtime.core.table_layout import TableLayout

SEARCH_TABLE = TableLayout()
_KERNEL_SLOTS = [SEARCH_TABLE.slots[name] for name in ("constraints", "jacobian", "velocity_rhs")]

# Numbers, then addresses of arrays.
COORDINATES = SEARCH_TABLE.number("coordinates")
ALL_ROWS = SEARCH_TABLE.number("all_rows")
ROWS = SEARCH_TABLE.number("rows")
NONZEROS = SEARCH_TABLE.number("nonzeros")
PARAMETERS = SEARCH_TABLE.number("parameters")
VALUES_OF_PARAMETERS = SEARCH_TABLE.number("values_of_parameters")
SCALE = SEARCH_TABLE.number("scale")
INDEPENDENT = SEARCH_TABLE.number("independent")
ENTRY_ROWS = SEARCH_TABLE.number("entry_rows")
ENTRY_COLUMNS = SEARCH_TABLE.number("entry_columns")
LENGTHS = SEARCH_TABLE.number("lengths")
POSITION = SEARCH_TABLE.number("position")
PHI = SEARCH_TABLE.number("phi")
VALUES = SEARCH_TABLE.number("values")
AHEAD = SEARCH_TABLE.number("ahead")
BEHIND = SEARCH_TABLE.number("behind")
ASIDE = SEARCH_TABLE.number("aside")
STEP = SEARCH_TABLE.number("step")
GAPS = SEARCH_TABLE.number("gaps")
ROW_ORDER = SEARCH_TABLE.number("row_order")
ROW_PLACE = SEARCH_TABLE.number("row_place")
COLUMN_ORDER = SEARCH_TABLE.number("column_order")
COLUMN_PLACE = SEARCH_TABLE.number("column_place")
ORIGIN = SEARCH_TABLE.number("origin")


class Layout(NamedTuple):
    """A table, and the arrays whose addresses it holds."""

    table: Integers
    arrays: dict[int, Any]


def lay_out(
    kernels: tuple[Kernel, Kernel, Kernel],
    p: Vector,
    scale: Vector,
    independent: Integers,
    m: int,
    places: tuple[Integers, Integers],
) -> Layout:
    """The table of a machine's constraints; arguments as in `ScaledConstraints`."""
    table = np.zeros(SEARCH_TABLE.size, np.int64)
    table[_KERNEL_SLOTS] = addresses(kernels)
    rows, wide, size = independent.size, scale.size + 1, places[0].size
    table[COORDINATES], table[ALL_ROWS], table[ROWS] = scale.size, m, rows
    table[NONZEROS], table[PARAMETERS] = size - m, p.size
    arrays: dict[int, Any] = {
        VALUES_OF_PARAMETERS: np.ascontiguousarray(p, dtype=np.float64),
        SCALE: np.ascontiguousarray(scale, dtype=np.float64),
        INDEPENDENT: np.ascontiguousarray(independent, dtype=np.int64),
        ENTRY_ROWS: np.ascontiguousarray(places[0], dtype=np.int64),
        ENTRY_COLUMNS: np.ascontiguousarray(places[1], dtype=np.int64),
        POSITION: np.zeros(scale.size),
        PHI: np.zeros(m),
        **{slot: np.zeros(size) for slot in (VALUES, AHEAD, BEHIND)},
        **{slot: np.ones(rows) for slot in (LENGTHS, GAPS)},
        **{slot: np.zeros(wide) for slot in (ASIDE, STEP, ORIGIN)},
        **{slot: np.arange(rows) for slot in (ROW_ORDER, ROW_PLACE)},
        **{slot: np.arange(wide) for slot in (COLUMN_ORDER, COLUMN_PLACE)},
    }
    for slot, array in arrays.items():
        table[slot] = array.ctypes.data
    return Layout(table, arrays)


@inner
def write_position(table: Integers, z: Vector) -> None:
    """Write q at z into the array that kernels read."""
    n = table[COORDINATES]
    q, scale = floats_at(table, POSITION, n), floats_at(table, SCALE, n)
    for j in range(n):
        q[j] = z[j] * scale[j]


@inner
def jacobian_entries(table: Integers, speed: float, z: Vector, values: Vector) -> None:
    """Fill `values`, (nnz + m,), with the Jacobian by z: Φ_q, columns scaled, then Φ_t / speed."""
    n, m, nonzeros = table[COORDINATES], table[ALL_ROWS], table[NONZEROS]
    write_position(table, z)
    q, scale = floats_at(table, POSITION, n), floats_at(table, SCALE, n)
    p = floats_at(table, VALUES_OF_PARAMETERS, table[PARAMETERS])
    columns = integers_at(table, ENTRY_COLUMNS, nonzeros)
    rate = view(values, nonzeros, m)
    t = z[n] / speed
    jacobian_of(table)(t, q, p, view(values, 0, nonzeros))
    for e in range(nonzeros):
        values[e] *= scale[columns[e]]
    for i in range(m):
        rate[i] = 0.0
    velocity_rhs_of(table)(t, q, p, rate)
    for i in range(m):
        rate[i] /= -speed


@inner
def unit_residuals(table: Integers, speed: float, z: Vector, gaps: Vector) -> None:
    """Fill `gaps`, (rows,), with Φ at z over the rows' lengths, in the order of their places."""
    n, m = table[COORDINATES], table[ALL_ROWS]
    write_position(table, z)
    phi = floats_at(table, PHI, m)
    for i in range(m):
        phi[i] = 0.0
    p = floats_at(table, VALUES_OF_PARAMETERS, table[PARAMETERS])
    constraints_of(table)(z[n] / speed, floats_at(table, POSITION, n), p, phi)
    independent = integers_at(table, INDEPENDENT, table[ROWS])
    lengths = floats_at(table, LENGTHS, table[ROWS])
    row_place = integers_at(table, ROW_PLACE, table[ROWS])
    for i in range(table[ROWS]):
        gaps[row_place[i]] = phi[independent[i]] / lengths[i]


@compiled(none(integers, f8, vector))
def measure_rows(table: Integers, speed: float, z: Vector) -> None:
    """Measure the lengths of the rows of Φ_q at z, by which all rows are divided from now on."""
    nonzeros, rows = table[NONZEROS], table[ROWS]
    values = floats_at(table, VALUES, nonzeros + table[ALL_ROWS])
    lengths = floats_at(table, LENGTHS, rows)
    places = integers_at(table, ENTRY_ROWS, nonzeros)
    jacobian_entries(table, speed, z, values)
    for i in range(rows):
        lengths[i] = 0.0
    for e in range(nonzeros):
        if places[e] < rows:
            lengths[places[e]] += values[e] ** 2
    for i in range(rows):
        lengths[i] = lengths[i] ** 0.5 if lengths[i] > 0.0 else 1.0


@compiled(none(integers, f8, vector, vector))
def unit_jacobian_entries(table: Integers, speed: float, z: Vector, out: Vector) -> None:
    """Fill `out`, (nnz + m,), with the Jacobian of the unit rows at z; 0 in rows set aside."""
    size, rows = table[NONZEROS] + table[ALL_ROWS], table[ROWS]
    places = integers_at(table, ENTRY_ROWS, size)
    lengths = floats_at(table, LENGTHS, rows)
    jacobian_entries(table, speed, z, out)
    for e in range(size):
        out[e] = out[e] / lengths[places[e]] if places[e] < rows else 0.0
