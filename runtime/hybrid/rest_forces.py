"""Forces that keep functions at rest on their surfaces: stiction, and shares of one freedom.

The stiction force is the unknown force that keeps a joint with friction at rest. A combination of
the fields of sliding to either side would keep it at rest as well, but where one of them jams, that
field does not exist. Therefore kernels in mode 2 take a given force in the place of this friction:
zero, which is the base, and one unit. Everything is linear in the force, so that any unit serves
which rounding permits; whether friction can bear the force is decided by its limit, μ_s N.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Vector, view
from runtime.core.jit import inlined, inner
from runtime.core.kinds import BALANCED, FRICTION, MIXED, ONE_WAY, SLIDING
from runtime.linalg.dense_elimination import equilibrate
from runtime.linalg.rank_policy import SAME_HOLD
from runtime.linalg.vectors import axpy, copy_vector, dot, is_finite, largest_ratio

PRESCRIBED = SLIDING  # the mode in which kernels take the stiction force from p

_COARSE = 8.0  # accuracy: units in a force, above which their rounding would matter


@inner
def set_unit(context: Context, k: int, mode: int) -> None:
    """Set function `k` to mode 0 or 1; its stiction force to zero or to a unit against g.

    Mixed conditions at rest stay so, in the mode 2 of their kernels.
    """
    place = context.stiction_place[k]
    if place >= 0:
        unit = context.stiction_units[k]
        context.parameters[place] = -unit if mode != 0 else 0.0
    elif context.boundary[k] != MIXED or context.kernel_modes[k] != SLIDING:
        context.kernel_modes[k] = mode


@inner
def is_prescribed(context: Context, k: int) -> bool:
    """Whether kernels take from `p` what keeps function `k` at zero."""
    return bool(context.stiction_place[k] >= 0 or context.share_place[k] >= 0)


@inner
def write_forces(context: Context) -> None:
    """Write the stiction forces, and shares that kernels take, into `p`, for kernels in mode 2."""
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        place, share_place = context.stiction_place[k], context.share_place[k]
        if place >= 0:
            context.parameters[place] = -context.share[k] * context.stiction_units[k]
        if share_place >= 0:
            context.parameters[share_place] = context.share[k]
            context.kernel_modes[k] = PRESCRIBED


@inner
def suspend_friction(context: Context) -> None:
    """Set all frictions with an unknown stiction force to a force of zero, by `modes`."""
    for k in range(context[ft.SWITCHES]):
        if context.stiction_place[k] >= 0:
            context.parameters[context.stiction_place[k]] = 0.0
            context.modes[k] = PRESCRIBED


@inner
def find_jamming_friction(context: Context, t: float, q: Vector, v: Vector, a: Vector) -> int:
    """The friction that jams in sliding: without it, and those before it, `a` is finite; or -1.

    For states without accelerations under `modes`; `a` and `lam` are overwritten.
    """
    p, kernel_modes = context.parameters, context.kernel_modes
    copy_vector(context.modes, kernel_modes)
    for k in range(context[ft.SWITCHES]):
        if context.stiction_place[k] < 0 or context.modes[k] == PRESCRIBED:
            continue
        p[context.stiction_place[k]] = 0.0
        kernel_modes[k] = PRESCRIBED
        abi.accelerations_of(context)(t, q, v, p, kernel_modes, a, context.multipliers)
        if is_finite(a):
            return k
    return -1


@inner
def choose_units(context: Context, t: float, q: Vector, v: Vector) -> None:
    """Fill the units of the stiction forces, and the friction limits in the base.

    The limit serves as the unit: it has the size of the forces in the machine.
    """
    s, count = context[ft.SWITCHES], context[ft.SLIDING_COUNT]
    p, lam, reaction = context.parameters, context.base_multipliers, context.reaction
    first = 0
    while first < count and context.stiction_place[context.sliding_functions[first]] < 0:
        first += 1
    if first == count:
        return
    abi.reactions_of(context)(t, q, v, p, lam, reaction)
    abi.switched_reactions_of(context)(t, q, v, p, context.kernel_modes, lam, reaction)
    for c in range(first, count):
        k = context.sliding_functions[c]
        if context.stiction_place[k] >= 0:
            limit = reaction[context.limits[2 * k + 1]]
            context.stiction_units[s + k] = limit
            context.stiction_units[k] = limit if limit > 0.0 and np.isfinite(limit) else 1.0


@inner
def enlarge_unit(context: Context, k: int) -> bool:
    """Enlarge the unit of function `k` where it is too small a part of its force; whether it was.

    A share of NaN may come from a unit that is lost in the rounding of the base.
    """
    if context.stiction_place[k] < 0:
        return False
    unit, share = context.stiction_units, context.share[k]
    if not np.isfinite(share):
        lost = unit[k] < 1.0
        unit[k] = max(unit[k], 1.0)
        return bool(lost)
    if abs(share) > _COARSE:
        unit[k] *= abs(share)
        return True
    return False


_DRIVEN = 1e-12  # accuracy: of a size and all accelerations; a smaller response is rounding
_FORCED = 1e-14  # accuracy: of a size and all F/m; at rest a smaller response is rounding
_CLEARLY = 1e-6  # safety: the same, with F/m of an earlier instant; a larger response is certain


@inlined
def is_unilateral(context: Context, k: int) -> bool:
    """Whether function `k` is held by a reaction without a bound: of a contact, of a freewheel."""
    return bool(context.rigid[k] >= 0 or context.sticks[k] == ONE_WAY)


@inner
def orthogonalize_row(context: Context, i: int) -> float:
    """Make row `i` orthogonal to the rows before it, reactions first; size of its terms."""
    matrix, right, count = context.response_copy, context.right_side, context[ft.SLIDING_COUNT]
    closed = is_unilateral(context, context.sliding_functions[i])
    row = view(matrix, i * count, count)
    scale = max(1.0, abs(right[i]))
    for _ in range(2):
        for j in range(count):
            first = is_unilateral(context, context.sliding_functions[j])
            if not (j < i if first == closed else first):
                continue
            other = view(matrix, j * count, count)
            along = dot(row, other)
            axpy(-along, other, row)
            right[i] -= along * right[j]
            scale = max(scale, abs(along * right[j]))
    return float(scale)


@inner
def solve_least(context: Context, slack: float) -> int:
    """As `solve_equilibrated`, for the smallest of many solutions; 1 where there is none.

    The matrix is `response_copy`, the right side `right_side`, in which x takes its place; all
    arrays are overwritten. Frictions of one freedom share its force in many ways. This one makes
    Σ |column| x²/reach least: each bears the same part of its reach, the largest permitted |x| in
    `response_column`, so that they stick as long as possible, and break loose together. Rows are
    made orthogonal one after the other (Gram and Schmidt, twice); a row without a rest depends on
    the others, and its residual may be `slack` of its terms. Rows of contacts and freewheels come
    first and must be independent: one that repeats others may open.
    """
    matrix, right, reach = context.response_copy, context.right_side, context.response_column
    count = context[ft.SLIDING_COUNT]
    if equilibrate(matrix, right, count) != 0:
        return 1
    for c in range(count):
        norm = 0.0
        for i in range(count):
            norm += matrix[i * count + c] ** 2
        if not norm > 0.0:
            return 1
        reach[c] = np.sqrt(reach[c] / np.sqrt(norm))
        for i in range(count):
            matrix[i * count + c] *= reach[c]
    for turn in range(2):
        for i in range(count):
            closed = is_unilateral(context, context.sliding_functions[i])
            if closed != (turn == 0):
                continue
            row = view(matrix, i * count, count)
            size = np.sqrt(dot(row, row))
            scale = orthogonalize_row(context, i)
            rest = np.sqrt(dot(row, row))
            if rest > SAME_HOLD * size:
                for c in range(count):
                    row[c] /= rest
                right[i] /= rest
                continue
            if closed or not abs(right[i]) <= slack * scale:
                return 1
            row[:] = 0.0
            right[i] = 0.0
    for c in range(count):
        total = 0.0
        for i in range(count):
            total += right[i] * matrix[i * count + c]
        reach[c] *= total
    copy_vector(view(reach, 0, count), right)
    return 0


@inner
def is_resting(context: Context, c: int) -> bool:
    """Whether the `c`-th function in sliding mode stays on its surface by itself.

    No mode moves it off. A balanced one takes the mean of both sides there, of mixed ones each
    holds as it is written, which `rest_mixed` says to the kernels.
    """
    k = context.sliding_functions[c]
    if context.boundary[k] == MIXED:
        return bool(context.kernel_modes[k] == SLIDING)
    return bool(context.boundary[k] == BALANCED and not is_driven(context, c, 0.0))


@inner
def rest_mixed(context: Context) -> bool:
    """Let mixed functions rest that the modes do not drive onto their surface; whether any does."""
    found = False
    for c in range(context[ft.SLIDING_COUNT]):
        k = context.sliding_functions[c]
        if context.boundary[k] == MIXED and not is_driven(context, c, -1.0):
            context.kernel_modes[k] = SLIDING
            found = True
    return found


@inner
def is_clearly_driven(context: Context, c: int) -> bool:
    """Whether a force of friction moves the `c`-th function by far, by F/m as last measured."""
    k, response = context.sliding_functions[c], context.response[c * context[ft.SLIDING_COUNT] + c]
    known = context.force_rates[k] * context.reserve[k]
    return bool(context.sticks[k] == FRICTION and abs(response) > _CLEARLY * known > 0.0)


@inner
def is_driven(context: Context, c: int, way: float) -> bool:
    """Whether its modes move the `c`-th function in sliding mode, `way` -1 onto, 1 off, 0 either.

    A response that is the rounding of accelerations moves nothing, nor does that of forces which a
    machine that stands bears, nor does a condition move what a contact or a freewheel keeps.
    """
    k = context.sliding_functions[c]
    if is_clearly_driven(context, c):
        return True
    for j in range(context[ft.SLIDING_COUNT]):
        other = context.sliding_functions[j]
        kept = is_unilateral(context, other) and context.sticks[k] == 0
        if kept and share_freedom(context, k, other):
            return False
    response = context.response[c * context[ft.SLIDING_COUNT] + c]
    response = abs(response) if way == 0.0 else way * response
    if response <= 0.0:
        return False
    speeds = view(ws.row_of(context, ws.SIZE), context[ft.COORDINATES], context[ft.COORDINATES])
    per_second = largest_ratio(context.base_accelerations, speeds)
    per_second += largest_ratio(context.unit_accelerations[c], speeds)
    largest = context.reserve[k] if context.modes[k] == SLIDING else context.largest[k]
    per_second = max(_DRIVEN * per_second, _FORCED * context.force_rates[k])
    return not response <= largest * per_second


@inner
def measure_forces(context: Context, t: float, q: Vector, v: Vector, k: int) -> float:
    """Largest |F|/m beside the typical speed of its coordinate, in 1/s, under `kernel_modes`.

    0 where function `k` cannot rest.
    """
    if context.boundary[k] != BALANCED and context.boundary[k] != MIXED:
        return 0.0
    force, size = context.forces, ws.row_of(context, ws.SIZE)
    per_mass, n, largest = ws.row_of(context, ws.PROJECTION), context[ft.COORDINATES], 0.0
    abi.applied_forces_of(context)(t, q, v, context.parameters, context.kernel_modes, force)
    for j in range(n):
        rate = abs(force[j]) * per_mass[j] / size[n + j]
        largest = max(largest, rate if np.isfinite(rate) else 0.0)
    return float(largest)


@inner
def rests(context: Context, k: int) -> bool:
    """Whether function `k` is in sliding mode and rests, see `is_resting`."""
    for c in range(context[ft.SLIDING_COUNT]):
        if context.sliding_functions[c] == k:
            return is_resting(context, c)
    return False


@inner
def keep_resting(context: Context, value: float) -> None:
    """Replace the equations of functions that rest by x = `value`, in `solve_least`'s arrays.

    An unknown stiction force is zero there.
    """
    count = context[ft.SLIDING_COUNT]
    for c in range(count):
        if is_resting(context, c):
            unknown = context.stiction_place[context.sliding_functions[c]] >= 0
            context.right_side[c] = 0.0 if unknown else value
            for j in range(count):
                context.response_copy[c * count + j] = 1.0 if j == c else 0.0


@inner
def share_freedom(context: Context, k: int, other: int) -> bool:
    """Whether two functions in sliding mode act on one freedom; after the accelerations."""
    matrix, count = context.response, context[ft.SLIDING_COUNT]
    c, d = 0, 0
    for i in range(count):
        c = i if context.sliding_functions[i] == k else c
        d = i if context.sliding_functions[i] == other else d
    product = matrix[c * count + c] * matrix[d * count + d]
    crossed = matrix[c * count + d] * matrix[d * count + c]
    return bool(abs(product - crossed) <= SAME_HOLD * abs(product))
