"""When do the constraints next cease to be independent? A cheap look along the motion.

The Jacobian, columns scaled by the masses and rows made unit length, is reduced row by row, each by
its largest remaining entry: the pivot of a row is about its distance from the rows before it. The
reduction is repeated, in the same order of pivots, where the machine will be a little later. A
pivot that changes sign in between announces a singular position.
"""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    RANK,
    VANISHING,
    dense_jacobian_of,
    elimination_plan_of,
    flat_jacobian_of,
    jacobian_columns_of,
    jacobian_rows_of,
    jacobian_values_of,
    parameters_of,
    pivot_columns_of,
    pivot_history_of,
    pivots_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import jacobian_of
from runtime.core.rounding import EPS
from runtime.core.run_record import run_record
from runtime.core.workspace import (
    PARTITION,
    SAMPLE,
    SIZE,
    Y0,
    K,
    first_half,
    positions,
    second_half,
    velocities,
    velocity_rates,
)
from runtime.linalg.elimination_plan import replay_plan, write_plan
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.row_elimination import eliminate_rows, fill_unit_rows, smallest_pivot

BEHIND = 0.1  # measured: of a step; how far back the motion is looked at
AHEAD = 2.5  # measured: of a step; how far ahead it is
_REACH = 0.5  # measured: of the coordinates' sizes; how far a motion is continued
_MARGIN = 0.5  # measured: of the time in which a pivot could vanish; when to look again
_TRUST = 0.5  # measured: of the time over which nothing announced itself; when to look again
_NEAR = 1e-5  # measured: a pivot that counts as small in any case
_CANDIDATES = 4  # measured: pivots that change sign, most of them by way of infinity
_REFINED = 6  # safety: steps by which a pivot that changes sign within a step is followed
# Rows of the array PIVOTS: pivots now, later, at the last look, and one over the lengths of Φ_q's
# rows. Behind them: the time of that look, and the smallest pivot when an order was found.
PIVOT_ROWS = 4
WHEN, LEAST = 0, 1
# measured: part of the smallest pivot at its search below which an order is found anew
_POORER = 0.5


@inner
def between(
    x: float, span: float, q: Vector, v: Vector, end: Vector, rate: Vector, moved: Vector
) -> None:
    """The position a share x into a step, on the cubic through the states at both ends.

    A chord would miss it by the square of the step.
    """
    for j in range(q.size):
        chord = end[j] - q[j]
        first, last = span * v[j] - chord, chord - span * rate[j]
        moved[j] = q[j] + x * (chord + (1.0 - x) * ((1.0 - x) * first + x * last))


@inner
def greatest(rates: Vector, size: Vector) -> float:
    """The largest rate of a coordinate, in its sizes."""
    found = 0.0
    for j in range(rates.size):
        found = max(found, abs(rates[j]) / size[j])
    return found


@inner
def sooner(t: float, weakest: float, speed: float, haste: float) -> float:
    """The instant until which no pivot vanishes, as they change about as fast as the motion."""
    way = _MARGIN * weakest
    return float(t + 2.0 * way / (speed + np.sqrt(speed * speed + 2.0 * haste * way) + 1e-300))


@inner
def announced(now: Vector, later: Vector, span: float, ahead: float) -> bool:
    """Whether a pivot has changed sign in the time `span`, or is to vanish within `ahead` of it."""
    for i in range(now.size):
        if now[i] * later[i] < 0.0:
            return True
        if abs(later[i]) * span < ahead * (abs(now[i]) - abs(later[i])):
            return True
    return False


@addressed(VANISHING)
def vanishing(context: Integers, t: float, h: float, state: int) -> float:
    """Time after t at which a pivot vanishes, where that is soon; else infinite.

    Pivots are compared at the start of the step, Y0, and in row `state`, its end; where that is Y0
    too, which says that the step has failed, a little later on the motion as it begins, and a
    pivot that has just vanished is found too.
    `run.look_at` is set to the instant until which no pivot can vanish: a pivot changes by about
    as much as the coordinates, in their typical sizes. Where a look before found an order of
    pivots, these are had at little cost, and if none has changed sign since, that is all. Else two
    eliminations, some more where something is announced: a pivot changes sign by way of infinity
    too, where an earlier one of the same order vanishes.
    """
    p = parameters_of(context)
    r = run_record(context)
    n = context[COORDINATES]
    m = context[CONSTRAINT_COUNT]
    jacobian = jacobian_of(context)
    rows = jacobian_rows_of(context)
    columns = jacobian_columns_of(context)
    values = jacobian_values_of(context)
    dense = dense_jacobian_of(context)
    order = pivot_columns_of(context)
    pivots = pivots_of(context)
    now, later, last = view(pivots, 0, m), view(pivots, m, m), view(pivots, 2 * m, m)
    lengths = view(pivots, 3 * m, m)
    known = pivot_history_of(context)
    plan = elimination_plan_of(context)
    scale = second_half(context, PARTITION)
    size = first_half(context, SIZE)
    q = positions(context, Y0)
    v = velocities(context, Y0)
    end, rate = positions(context, state), velocities(context, state)
    moved, place = positions(context, SAMPLE), velocities(context, SAMPLE)
    speed = max(greatest(v, size), greatest(velocities(context, state), size))
    span, back, ahead = h, 0.0, max(AHEAD * h, r.foresight / max(speed, 1e-300))
    # Only from look to look: in a gap between them a pivot may change its sign twice.
    if state != Y0 and plan[0] > 0 and t <= r.look_at and t + h > known[WHEN]:
        flat = flat_jacobian_of(context)
        if replay_plan(
            jacobian, t + h, end, p, scale, rows, columns, values, flat, plan, lengths, later
        ):
            weakest = min(smallest_pivot(last), smallest_pivot(later))
            passed = t + h - known[WHEN]
            if weakest > _POORER * known[LEAST] and not announced(last, later, passed, ahead - h):
                known[WHEN] = t + h
                for i in range(m):
                    last[i] = later[i]
                r.look_at = t + _TRUST * ahead
                if _MARGIN * weakest > speed * _TRUST * ahead:
                    haste = greatest(velocity_rates(context, K), size)
                    r.look_at = max(r.look_at, sooner(t, weakest, speed, haste))
                return np.inf
    plan[0] = 0
    haste = greatest(velocity_rates(context, K), size)
    if state == Y0:
        # Rounding fails steps that are shorter and shorter within this distance, on either side.
        noisy = np.cbrt(EPS / r.rtol) / max(speed, 1e-300)
        back, ahead = -max(BEHIND * h, noisy), max(h, noisy)
        span = min(h, _REACH / max(speed, 1e-300))
    for j in range(n):
        moved[j] = q[j] + span * v[j] if state == Y0 else end[j]
    beyond = -1.0
    for candidate in range(_CANDIDATES):
        fill_unit_rows(jacobian, t, q, p, scale, rows, columns, values, dense)
        eliminate_rows(dense, order, now, 1)
        fill_unit_rows(jacobian, t + span, moved, p, scale, rows, columns, values, dense)
        eliminate_rows(dense, order, later, 0)
        weakest = smallest_pivot(now)
        nearest, which = np.inf, 0
        for i in range(m):
            change = later[i] - now[i]
            if max(abs(now[i]), abs(later[i])) <= REDUNDANT or change == 0.0:
                continue
            if abs(now[i]) <= REDUNDANT and context[RANK] < m:
                continue  # it follows from others wherever these hold
            s = -now[i] * span / change
            if back <= s <= ahead and beyond < abs(s) < abs(nearest):
                nearest, which = s, i
        if candidate == 0:
            r.look_at = sooner(t, weakest, speed, haste)
        if not nearest < np.inf:
            if candidate == 0:
                r.look_at = max(r.look_at, t + _TRUST * ahead)
                if state != Y0 and context[RANK] == m:
                    known[WHEN], known[LEAST] = t + h, min(weakest, smallest_pivot(later))
                    for i in range(m):
                        last[i] = later[i]
                    write_plan(order, rows, columns, values, scale, dense, plan, lengths)
            return np.inf
        beyond = abs(nearest)
        if state != Y0:
            # Pivots are no straight lines: within the step, follow the one that changes sign.
            low, high, x = 0.0, 1.0, nearest / span
            at_low, at_high = now[which], later[which]
            for _ in range(_REFINED):
                between(x, span, q, v, end, rate, place)
                fill_unit_rows(
                    jacobian, t + x * span, place, p, scale, rows, columns, values, dense
                )
                if not x < 1.0:
                    break
                eliminate_rows(dense, order, later, 0)
                if (later[which] > 0.0) == (at_low > 0.0):
                    low, at_low, at_high = x, later[which], 0.5 * at_high
                else:
                    high, at_high, at_low = x, later[which], 0.5 * at_low
                x = low - at_low * (high - low) / (at_high - at_low)
            nearest = x * span
        else:
            for j in range(n):
                place[j] = q[j] + nearest / span * (moved[j] - q[j])
            fill_unit_rows(jacobian, t + nearest, place, p, scale, rows, columns, values, dense)
        # With an order of pivots of its own, is this position as poor as it seems?
        eliminate_rows(dense, order, later, 1)
        least = 1.0
        for i in range(m):
            if abs(now[i]) > REDUNDANT:
                least = min(least, abs(later[i]))
        if not (least > 0.5 * weakest and least > _NEAR):
            return float(nearest)
    return np.inf
