"""The table by which compiled searches reach a machine's constraints, and its first readers.

It is laid out as that of a run (`runtime.core.function_table_slots`), but is called `search` and
has no attributes: ``context.x`` would read a run's slot. In scaled coordinates a position is
z = (q / scale, t speed), of shape (n + 1,).
"""

from runtime.core.arrays import Integers, Vector, f8, i8, integers, none, vector, view
from runtime.core.function_table_layout import TableLayout
from runtime.core.jit import compiled, inner
from runtime.core.kernel_abi import constraints_of, jacobian_of, velocity_rhs_of

TABLE = TableLayout()

COORDINATES = TABLE.number("coordinates")  # n
UNKNOWNS = TABLE.number("unknowns")  # n + 1, with time
CONSTRAINT_COUNT = TABLE.number("constraint_count")  # m
ROWS = TABLE.number("rows")  # of these, that follow from no others
DENSE_ROWS = TABLE.number("dense_rows")  # as many as rows, of a large machine none
NONZEROS = TABLE.number("nonzeros")  # of Φ_q
ENTRIES = TABLE.number("entries")  # nnz + m, with Φ_t
PARAMETER_COUNT = TABLE.number("parameter_count")

parameters_of = TABLE.floats("parameters", PARAMETER_COUNT, allotted=False)
scale_of = TABLE.floats("scale", COORDINATES, allotted=False)
independent_of = TABLE.integers("independent", ROWS, allotted=False)
entry_rows_of = TABLE.integers("entry_rows", ENTRIES, allotted=False)
entry_columns_of = TABLE.integers("entry_columns", ENTRIES, allotted=False)
lengths_of = TABLE.floats("lengths", ROWS)  # of the rows, by which they are divided
shortest_of = TABLE.floats("shortest", ROWS)  # least lengths, of rows that may vanish
row_order_of = TABLE.integers("row_order", ROWS)  # of pivots: which row is where
row_place_of = TABLE.integers("row_place", ROWS)  # where each row is
column_order_of = TABLE.integers("column_order", UNKNOWNS)
column_place_of = TABLE.integers("column_place", UNKNOWNS)
speed_of = TABLE.floats("speed", (1, None))  # the unit of time is its inverse
# Work arrays.
position_of = TABLE.floats("position", COORDINATES)
phi_of = TABLE.floats("phi", CONSTRAINT_COUNT)
values_of = TABLE.floats("values", ENTRIES)
ahead_of = TABLE.floats("ahead", ENTRIES)
behind_of = TABLE.floats("behind", ENTRIES)
displaced_of = TABLE.floats("displaced", UNKNOWNS)
step_of = TABLE.floats("step", UNKNOWNS)
origin_of = TABLE.floats("origin", UNKNOWNS)
residuals_of = TABLE.floats("residuals", ROWS)
sums_of = TABLE.floats("sums", UNKNOWNS, DENSE_ROWS)  # uᵀ J' of left vectors, flat


@inner
def write_position(search: Integers, z: Vector) -> float:
    """Write q at z into the array that kernels read; the instant, s."""
    q, scale = position_of(search), scale_of(search)
    for j in range(q.size):
        q[j] = z[j] * scale[j]
    return float(z[q.size] / speed_of(search)[0])


@inner
def jacobian_entries(search: Integers, z: Vector, values: Vector) -> None:
    """Fill `values`, (nnz + m,), with the Jacobian by z: Φ_q, columns scaled, then Φ_t / speed."""
    t = write_position(search, z)
    m, nonzeros, speed = search[CONSTRAINT_COUNT], search[NONZEROS], speed_of(search)[0]
    q, p = position_of(search), parameters_of(search)
    scale, columns = scale_of(search), entry_columns_of(search)
    rate = view(values, nonzeros, m)
    jacobian_of(search)(t, q, p, view(values, 0, nonzeros))
    for e in range(nonzeros):
        values[e] *= scale[columns[e]]
    rate[:] = 0.0
    velocity_rhs_of(search)(t, q, p, rate)
    for i in range(m):
        rate[i] /= -speed


@inner
def unit_residuals(search: Integers, z: Vector, residuals: Vector) -> None:
    """Fill `residuals`, (rows,), with Φ at z over the rows' lengths, in the order of places."""
    t = write_position(search, z)
    phi = phi_of(search)
    phi[:] = 0.0
    constraints_of(search)(t, position_of(search), parameters_of(search), phi)
    lengths, place = lengths_of(search), row_place_of(search)
    independent = independent_of(search)
    for i in range(independent.size):
        residuals[place[i]] = phi[independent[i]] / lengths[i]


@compiled(none(integers, f8, vector))
def set_units(search: Integers, speed: float, z: Vector) -> None:
    """Set the unit of time, 1 / `speed` s, and the lengths of the rows of Φ_q, at z."""
    speed_of(search)[0] = speed
    values, lengths, rows = values_of(search), lengths_of(search), entry_rows_of(search)
    jacobian_entries(search, z, values)
    lengths[:] = 0.0
    for e in range(search[NONZEROS]):
        if rows[e] < lengths.size:
            lengths[rows[e]] += values[e] ** 2
    for i in range(lengths.size):
        lengths[i] = max(lengths[i] ** 0.5, shortest_of(search)[i])
        lengths[i] = lengths[i] if lengths[i] > 0.0 else 1.0


@compiled(none(integers, vector, vector))
def unit_jacobian_entries(search: Integers, z: Vector, out: Vector) -> None:
    """Fill `out`, (nnz + m,), with the Jacobian of the unit rows at z; 0 in rows set aside."""
    rows, lengths = entry_rows_of(search), lengths_of(search)
    jacobian_entries(search, z, out)
    for e in range(rows.size):
        out[e] = out[e] / lengths[rows[e]] if rows[e] < lengths.size else 0.0


@compiled(i8(integers, vector, vector, f8))
def is_root(search: Integers, z: Vector, entries: Vector, within: float) -> int:
    """Whether unit rows vanish at z, and the Jacobian, which fills `values`, has these entries."""
    values, residuals = values_of(search), residuals_of(search)
    unit_residuals(search, z, residuals)
    jacobian_entries(search, z, values)
    for i in range(residuals.size):
        if not abs(residuals[i]) <= within:
            return 0
    for e in range(values.size):
        if not abs(values[e] - entries[e]) <= within:
            return 0
    return 1
