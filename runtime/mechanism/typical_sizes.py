"""Typical lengths of a machine, its constraints' sizes and its mobilities, in compiled code.

A length is typical by how angles enter lengths: by the arms of Φ_q. A `context` is the table by
which compiled code reaches a machine whose start is assembled and measured: as that of a run it
begins with the kernels, so that it stands for them; `context.x` is an array.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from runtime.core.arrays import Context, Integers, Vector, f8, i8, integers, none, vector
from runtime.core.function_table_layout import TableLayout
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import KERNELS, constraints_of, jacobian_of
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
_TURNING = START.number("bodies_in_space")

LEAD = START.size  # slot of what leads Newton's method from afar; 0: nothing does
LEADING = i8(integers, f8, vector, vector)  # context t p q; 0
lead_of = START.function("lead", LEADING)

# What the tables of a machine say of its coordinates and constraints.
START.integers("slope_rows slope_columns", _NONZEROS, allotted=False)
START.integers("of_length", _N, allotted=False)  # 1 of coordinates that are lengths
START.integers("scaled_by_length", _N, allotted=False)  # of those measured in the machine's length
START.integers("every", _N, allotted=False)  # 1 of every coordinate
START.integers("counted", _N, allotted=False)  # of what joints count: its row, from 1 on; else 0
START.floats("typical", _N, allotted=False)  # changes of the coordinates that are no lengths
START.matrix("turns", (2, None), _N, allotted=False)  # to two positions with all angles turned
START.integers("turning", _TURNING, allotted=False)  # columns of e0 of bodies in space
START.floats("neutral", _N, allotted=False)  # the position without start values
START.integers("in_metres", _PARAMETERS, allotted=False)  # 1 of parameters in m

# What is free to move, 1, and how much it weighs.
START.integers("free_q free_v", _N)
START.floats("move_weight", _N)
START.floats("ease_q ease_v", _N)  # how easily they change, beside typical sizes

# Room: Φ_q at a position and in another pose, what enters each constraint, typical changes.
START.floats("slopes other_slopes", _NONZEROS)
START.floats("pose change_scale speed_scale", _N)
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
    table[_TURNING] = len(shape["turning"])
    arrays = START.allot(table)
    for name, array in shape.items():
        arrays[name] = array
        table[START.slots[name]] = array.ctypes.data
    return StartTable(table, arrays)


# measured: part of the largest distance from the origin; a machine counts as no smaller
_LEAST_PART = 0.01
_ROUNDING = 1e-9  # accuracy: of the longest length known; a length below this part is rounding
_FAR = 1e3  # safety: scaled slopes above this, or all below its inverse, determine the row's size
# safety: of the longest arm in other poses; if all arms are shorter, they vanish in this pose
_VANISHED = 1e-3
# safety: largest ratio of two mobilities, with typical sizes; corrections have their squares as
# weights, whose ratio then is that of a pivot to a weak one
_WIDEST = 3e4
_ROUNDED_MASS = 1e-24  # accuracy: of the largest mass, beside typical sizes; less is no mass
_NEGLIGIBLE = 1e-6  # accuracy: a slope of a length, or an arm beside the longest, that is none
_LENGTH, _ENTERED = 2, 1  # code: of what enters a constraint


@inner
def mark_rows(context: Context, slopes: Vector, marks: Integers) -> None:
    """Write whether anything enters each constraint at Φ_q, and whether a length does."""
    marks[:] = 0
    for e in range(slopes.size):
        if slopes[e] != 0.0:
            marks[context.slope_rows[e]] |= _ENTERED
            if context.of_length[context.slope_columns[e]] != 0:
                marks[context.slope_rows[e]] |= _LENGTH


@inner
def longest_arm(context: Context, slopes: Vector, marks: Integers) -> float:
    """The longest arm by which an angle enters a length, m; 0 where none does, or no number."""
    mark_rows(context, slopes, marks)
    longest = 0.0
    for e in range(slopes.size):
        if (
            marks[context.slope_rows[e]] != _ENTERED
            and context.of_length[context.slope_columns[e]] == 0
        ):
            if np.isnan(slopes[e]):
                return np.nan
            longest = max(longest, abs(slopes[e]))
    return longest


@inner
def extent(context: Context, q: Vector) -> float:
    """The largest distance from the origin along an axis, m."""
    largest = 0.0
    for k in range(q.size):
        if context.of_length[k] != 0:
            largest = max(largest, abs(q[k]))
    return largest


@inner
def turn(context: Context, k: int, q: Vector, pose: Vector) -> None:
    """Write q with all angles turned; Euler parameters keep the length 1."""
    for j in range(q.size):
        pose[j] = q[j] + context.turns[k, j]
    for b in range(context.turning.size):
        first, square = context.turning[b], 0.0
        for j in range(first, first + 4):
            square += pose[j] ** 2
        for j in range(first, first + 4):
            pose[j] /= np.sqrt(square)


@inner
def find_reach(context: Context, t: float, q: Vector, p: Vector) -> float:
    """The longest arm at q, m; with angles turned, where all vanish there. Φ_q stays.

    A contact at α = π/2 leaves nothing of an arm but the rounding of cos α.
    """
    jacobian_of(context)(t, q, p, context.slopes)
    here, far = longest_arm(context, context.slopes, context.marks), extent(context, q)
    if far > 0.0 and here > _VANISHED * far:
        return here
    there = 0.0
    for k in range(2):
        turn(context, k, q, context.pose)
        jacobian_of(context)(t, context.pose, p, context.other_slopes)
        arm = longest_arm(context, context.other_slopes, context.marks)
        if np.isfinite(arm):
            there = max(there, arm)
    return here if here > _VANISHED * there else there


@inner
def write_scale(context: Context, size: float, scale: Vector) -> None:
    """Typical changes of coordinates: `size` for lengths, 1 for angles, a state's own."""
    for k in range(scale.size):
        scale[k] = size if context.scaled_by_length[k] != 0 else context.typical[k]


@inner
def measure_size(context: Context, t: float, q: Vector, p: Vector) -> float:
    """A length typical of the machine, m, from how angles enter lengths; 1 if none do."""
    reach, far = find_reach(context, t, q, p), extent(context, q)
    if reach > 0.0:
        return max(reach, 1e-3 * far)
    return far if far > 0.0 else 1.0


@inner
def measure_steepest(context: Context, slopes: Vector, size: float, known: bool) -> None:
    """Write the largest scaled slope of each constraint, beside those known of other poses."""
    for e in range(slopes.size):
        i, j = context.slope_rows[e], context.slope_columns[e]
        unit = size if context.marks[i] != _ENTERED else 1.0
        change = size if context.scaled_by_length[j] != 0 else context.typical[j]
        slope = abs(slopes[e] * change) / unit
        if not (known and not np.isfinite(slope)):
            context.steepest[i] = max(context.steepest[i], slope)


@inner
def write_row_scale(context: Context, t: float, q: Vector, p: Vector, size: float) -> None:
    """Typical change of each constraint: `size` for lengths, else 1.

    A row whose slopes are far from that, such as the square of a length, is measured by them.
    """
    jacobian_of(context)(t, q, p, context.slopes)
    mark_rows(context, context.slopes, context.marks)
    context.steepest[:] = 0.0
    measure_steepest(context, context.slopes, size, False)
    even = True
    for i in range(context.row_scale.size):
        context.row_scale[i] = size if context.marks[i] != _ENTERED else 1.0
        even = even and 1.0 / _FAR < context.steepest[i] < _FAR
    if even:
        return
    for k in range(2):  # a row may be flat by chance
        turn(context, k, q, context.pose)
        jacobian_of(context)(t, context.pose, p, context.other_slopes)
        measure_steepest(context, context.other_slopes, size, True)
    for i in range(context.row_scale.size):
        steepest = context.steepest[i]
        far = steepest > _FAR or 0.0 < steepest < 1.0 / _FAR
        if far and np.isfinite(steepest):
            context.row_scale[i] *= steepest


@inner
def measure_length(context: Context, t: float, q: Vector, p: Vector) -> float:
    """The length to which tolerances are relative; see `dense_equations.magnitudes`."""
    reach, far = find_reach(context, t, q, p), extent(context, q)
    if reach > _ROUNDING * max(far, 1.0):
        return max(reach, _LEAST_PART * far)
    mark_rows(context, context.slopes, context.marks)
    constraints_of(context)(t, context.neutral, p, context.phi)
    fixed, declared = 0.0, 0.0
    for i in range(context.phi.size):
        if context.marks[i] != _ENTERED:
            fixed = max(fixed, abs(context.phi[i]))
    for i in range(context.in_metres.size):
        if context.in_metres[i] != 0:
            declared = max(declared, abs(p[i]))
    known = max(reach, _LEAST_PART * far) if reach > 0.0 else 0.0
    # Where the machine has no length of its own, a distance from the origin is one beside a metre.
    own = max(reach, fixed, declared)
    least = _ROUNDING * max(known, far, fixed, declared, 0.0 if own > 0.0 else 1.0)
    for length in (known, far, fixed, declared):
        if length > least:
            return length
    return 1.0


@inner
def write_mobility(inertia: Vector, sizes: Vector, counted: Integers, mobility: Vector) -> None:
    """Typical size of a change of each coordinate, 1/√M_kk, from M_kk and typical sizes; all (n,).

    A coordinate without mass, such as the place of a contact on a cam, follows most easily: ten
    times the size of the most mobile body makes it one of the dependent coordinates. In reduced
    coordinates its mass is rounding. What a joint counts leads instead, as if it moved the heaviest
    body: it describes the motion through full turns, as no other coordinate in space does.
    """
    heaviest, lightest = 0.0, np.inf
    for k in range(inertia.size):
        heaviest = max(heaviest, inertia[k] * sizes[k] ** 2)
    for k in range(inertia.size):
        if inertia[k] * sizes[k] ** 2 > _ROUNDED_MASS * heaviest:
            lightest = min(lightest, inertia[k])
    for k in range(inertia.size):
        heavy = inertia[k] * sizes[k] ** 2 > _ROUNDED_MASS * heaviest
        mobility[k] = 1.0 / np.sqrt(inertia[k] if heavy else 0.01 * lightest)
        if counted[k] != 0 and heaviest > 0.0:
            mobility[k] = sizes[k] / np.sqrt(heaviest)


@inner
def compress(mobility: Vector, sizes: Vector) -> None:
    """Bring mobilities at most `_WIDEST` apart, beside the typical sizes of their coordinates.

    They say which coordinate follows more easily, not which constraints are independent.
    """
    most, least = 0.0, np.inf
    for k in range(mobility.size):
        most, least = max(most, mobility[k] / sizes[k]), min(least, mobility[k] / sizes[k])
    if most <= _WIDEST * least:
        return
    exponent = np.log(_WIDEST) / np.log(most / least)
    for k in range(mobility.size):
        mobility[k] = sizes[k] * most * (mobility[k] / sizes[k] / most) ** exponent


@inner
def spread_of_masses(context: Context, inertia: Vector, slopes: Vector) -> float:
    """Largest ratio of two mobilities Φ_ik² / M_kk in a row, from M_kk, (n,), and |Φ_ik|, (nnz,).

    Slopes of lengths and arms that rounding explains feel nothing.
    """
    unit, steepest, arms, spread = context.row_scale, context.steepest, 0.0, 1.0
    unit[:], steepest[:] = 0.0, 0.0
    for e in range(slopes.size):
        i, slope = context.slope_rows[e], slopes[e] if np.isfinite(slopes[e]) else 0.0
        steepest[i] = max(steepest[i], slope)
        if context.of_length[context.slope_columns[e]] != 0:
            unit[i] = max(unit[i], slope)
    for i in range(unit.size):
        unit[i] = unit[i] if unit[i] > 0.0 else steepest[i]
        unit[i] = unit[i] if unit[i] > 0.0 else 1.0
    for e in range(slopes.size):
        if context.of_length[context.slope_columns[e]] == 0 and np.isfinite(slopes[e]):
            arms = max(arms, slopes[e] / unit[context.slope_rows[e]])
    most, least = context.steepest, context.phi
    most[:], least[:] = 0.0, np.inf
    for e in range(slopes.size):
        i, j = context.slope_rows[e], context.slope_columns[e]
        slope = (slopes[e] if np.isfinite(slopes[e]) else 0.0) / unit[i]
        if inertia[j] > 0.0 and slope > _NEGLIGIBLE * (1.0 if context.of_length[j] != 0 else arms):
            most[i] = max(most[i], slope * slope / inertia[j])
            least[i] = min(least[i], slope * slope / inertia[j])
    for i in range(unit.size):
        spread = max(spread, most[i] / least[i])
    return spread


@compiled(f8(ADDRESSES, f8, vector, vector, i8))
def measure(context: Context, t: Any, q: Any, p: Any, question: Any) -> float:
    """For Python: a length typical of the machine (0), or of its tolerances (1), m."""
    if question == 0:
        return measure_size(context, t, q, p)
    return measure_length(context, t, q, p)


@compiled(none(ADDRESSES, f8, vector, vector, f8))
def measure_rows(context: Context, t: Any, q: Any, p: Any, size: Any) -> None:
    """For Python: see `write_row_scale`."""
    write_row_scale(context, t, q, p, size)


@compiled(none(vector, vector, integers, vector, i8))
def measure_mobility(
    inertia: Any, sizes: Any, counted: Any, mobility: Any, compressed: Any
) -> None:
    """For Python: see `write_mobility`; `compress` follows, if `compressed` is 1."""
    write_mobility(inertia, sizes, counted, mobility)
    if compressed != 0:
        compress(mobility, sizes)


@compiled(f8(ADDRESSES, vector, vector))
def measure_spread(context: Context, inertia: Any, slopes: Any) -> float:
    """For Python: see `spread_of_masses`."""
    return spread_of_masses(context, inertia, slopes)
