"""Detection of a singular position ahead: a pivot of Φ_q that is to change its sign.

The Jacobian, columns scaled by the masses and rows of unit length, is eliminated row by row. The
pivot of a row, its largest remaining entry, is about the distance of the row from those before it.
The elimination is repeated, in the same order of pivots, at the end of a step or a little later. A
pivot that changes sign in between announces a singular position.
"""

import numpy as np

from runtime.core.array_types import Integers, Vector
from runtime.core.array_views import view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
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
# Rows of `pivots_of`: pivots now, later, at the last look, and one over the lengths of Φ_q's rows.
PIVOT_ROWS = 4
# Places in `pivot_history_of`: time of the last look, smallest pivot when its order was chosen.
WHEN, LEAST = 0, 1
# measured: part of the smallest pivot at its search below which an order is found anew
_POORER = 0.5


@inner
def interpolate_step(
    x: float, span: float, q: Vector, v: Vector, end: Vector, rate: Vector, moved: Vector
) -> None:
    """The position at a share x of a step, on the cubic through the states at both ends.

    A chord would miss it by the square of the step.
    """
    for j in range(q.size):
        chord = end[j] - q[j]
        first, last = span * v[j] - chord, chord - span * rate[j]
        moved[j] = q[j] + x * (chord + (1.0 - x) * ((1.0 - x) * first + x * last))


@inner
def largest_rate(rates: Vector, size: Vector) -> float:
    """The largest rate of a coordinate, in units of its size."""
    found = 0.0
    for j in range(rates.size):
        found = max(found, abs(rates[j]) / size[j])
    return found


@inner
def earliest_zero(t: float, weakest: float, speed: float, haste: float) -> float:
    """The instant before which no pivot vanishes, as pivots change about as fast as the motion."""
    way = _MARGIN * weakest
    return float(t + 2.0 * way / (speed + np.sqrt(speed * speed + 2.0 * haste * way) + 1e-300))


@inner
def approaches_zero(now: Vector, later: Vector, span: float, ahead: float) -> bool:
    """Whether a pivot changed sign within the time `span`, or would vanish within `ahead` of it."""
    for i in range(now.size):
        if now[i] * later[i] < 0.0:
            return True
        if abs(later[i]) * span < ahead * (abs(now[i]) - abs(later[i])):
            return True
    return False


@inner
def next_zero(
    now: Vector,
    later: Vector,
    independent: bool,
    span: float,
    back: float,
    ahead: float,
    beyond: float,
) -> tuple[float, int]:
    """Time, by linear interpolation, of the pivot that vanishes next after `beyond`, and its row.

    The time lies between `back` and `ahead`, or is infinite. Unless all rows are `independent`, one
    without a pivot now follows from others wherever these hold.
    """
    nearest, which = np.inf, 0
    for i in range(now.size):
        change = later[i] - now[i]
        if max(abs(now[i]), abs(later[i])) <= REDUNDANT or change == 0.0:
            continue
        if abs(now[i]) <= REDUNDANT and not independent:
            continue
        s = -now[i] * span / change
        if back <= s <= ahead and beyond < abs(s) < abs(nearest):
            nearest, which = s, i
    return nearest, which


@inner
def fill_at(context: Integers, t: float, q: Vector) -> None:
    """Write Φ_q at (t, q), columns scaled and rows of unit length, into the dense Jacobian."""
    fill_unit_rows(
        jacobian_of(context),
        t,
        q,
        parameters_of(context),
        second_half(context, PARTITION),
        jacobian_rows_of(context),
        jacobian_columns_of(context),
        jacobian_values_of(context),
        dense_jacobian_of(context),
    )


@inner
def stays_regular(
    context: Integers, t: float, h: float, state: int, speed: float, ahead: float
) -> bool:
    """Whether pivots by the plan announce nothing at the end of a step; says when to look again."""
    r, m = run_record(context), context[CONSTRAINT_COUNT]
    pivots, known = pivots_of(context), pivot_history_of(context)
    later, last = view(pivots, m, m), view(pivots, 2 * m, m)
    size = first_half(context, SIZE)
    if not replay_plan(
        jacobian_of(context),
        t + h,
        positions(context, state),
        parameters_of(context),
        second_half(context, PARTITION),
        jacobian_rows_of(context),
        jacobian_columns_of(context),
        jacobian_values_of(context),
        flat_jacobian_of(context),
        elimination_plan_of(context),
        view(pivots, 3 * m, m),
        later,
    ):
        return False
    weakest = min(smallest_pivot(last), smallest_pivot(later))
    passed = t + h - known[WHEN]
    if not weakest > _POORER * known[LEAST] or approaches_zero(last, later, passed, ahead - h):
        return False
    known[WHEN] = t + h
    for i in range(m):
        last[i] = later[i]
    r.look_at = t + _TRUST * ahead
    if _MARGIN * weakest > speed * _TRUST * ahead:
        haste = largest_rate(velocity_rates(context, K), size)
        r.look_at = max(r.look_at, earliest_zero(t, weakest, speed, haste))
    return True


@inner
def fastest(context: Integers, state: int) -> float:
    """The largest velocity at both ends of the step, in units of the coordinates' sizes, 1/s."""
    size = first_half(context, SIZE)
    ends = largest_rate(velocities(context, state), size)
    return max(largest_rate(velocities(context, Y0), size), ends)


@inner
def remember(context: Integers, instant: float, weakest: float) -> None:
    """Keep the later pivots and the plan of their order for the next look."""
    m = context[CONSTRAINT_COUNT]
    pivots, known = pivots_of(context), pivot_history_of(context)
    later, last = view(pivots, m, m), view(pivots, 2 * m, m)
    known[WHEN], known[LEAST] = instant, min(weakest, smallest_pivot(later))
    for i in range(m):
        last[i] = later[i]
    write_plan(
        pivot_columns_of(context),
        jacobian_rows_of(context),
        jacobian_columns_of(context),
        jacobian_values_of(context),
        second_half(context, PARTITION),
        dense_jacobian_of(context),
        elimination_plan_of(context),
        view(pivots, 3 * m, m),
    )


@inner
def follow_pivot(
    context: Integers, t: float, span: float, state: int, which: int, first: float
) -> float:
    """Share of the step at which the pivot of row `which` vanishes, from the guess `first` on.

    By the Illinois rule, as pivots are no straight lines. The dense Jacobian is left as it was at
    the last share, perhaps eliminated already, which changes no pivot in an order of its own.
    """
    m = context[CONSTRAINT_COUNT]
    pivots = pivots_of(context)
    now, later = view(pivots, 0, m), view(pivots, m, m)
    q, v = positions(context, Y0), velocities(context, Y0)
    end, rate = positions(context, state), velocities(context, state)
    place = velocities(context, SAMPLE)
    low, high, x = 0.0, 1.0, first
    at_low, at_high = now[which], later[which]
    for _ in range(_REFINED):
        interpolate_step(x, span, q, v, end, rate, place)
        fill_at(context, t + x * span, place)
        if not x < 1.0:
            break
        eliminate_rows(dense_jacobian_of(context), pivot_columns_of(context), later, 0)
        if (later[which] > 0.0) == (at_low > 0.0):
            low, at_low, at_high = x, later[which], 0.5 * at_high
        else:
            high, at_high, at_low = x, later[which], 0.5 * at_low
        x = low - at_low * (high - low) / (at_high - at_low)
    return x


@addressed(VANISHING)
def predict_vanishing_pivot(context: Integers, t: float, h: float, state: int) -> float:
    """Time after t at which a pivot vanishes, where that is soon; else infinite.

    Pivots are compared at the start of the step, Y0, and in row `state`, its end. Where that is Y0
    too, which says that the step has failed, they are compared a little later on the motion as it
    begins, and a pivot that has just vanished is found too.

    `look_at` of the run is set to the instant until which no pivot can vanish: a pivot changes by
    about as much as the coordinates, in their typical sizes. Where a look before found an order of
    pivots, these follow at little cost by its plan, and if none has changed sign since, that is
    all. Else there are two eliminations, and some more where something is announced: a pivot also
    changes sign by way of infinity, where an earlier one of the same order vanishes.
    """
    r, m = run_record(context), context[CONSTRAINT_COUNT]
    pivots, plan = pivots_of(context), elimination_plan_of(context)
    now, later = view(pivots, 0, m), view(pivots, m, m)
    dense, order = dense_jacobian_of(context), pivot_columns_of(context)
    q, v = positions(context, Y0), velocities(context, Y0)
    moved, place = positions(context, SAMPLE), velocities(context, SAMPLE)
    speed = fastest(context, state)
    span, back, ahead = h, 0.0, max(AHEAD * h, r.foresight / max(speed, 1e-300))
    # Only from look to look: in a gap between them a pivot may change its sign twice.
    known = plan[0] > 0 and t <= r.look_at and t + h > pivot_history_of(context)[WHEN]
    if state != Y0 and known and stays_regular(context, t, h, state, speed, ahead):
        return np.inf
    plan[0] = 0
    haste = largest_rate(velocity_rates(context, K), first_half(context, SIZE))
    if state == Y0:
        # Rounding fails steps that are shorter and shorter within this distance, on either side.
        noisy = np.cbrt(EPS / r.rtol) / max(speed, 1e-300)
        back, ahead = -max(BEHIND * h, noisy), max(h, noisy)
        span = min(h, _REACH / max(speed, 1e-300))
    end = positions(context, state)
    for j in range(q.size):
        moved[j] = q[j] + span * v[j] if state == Y0 else end[j]
    beyond = -1.0
    for candidate in range(_CANDIDATES):
        fill_at(context, t, q)
        eliminate_rows(dense, order, now, 1)
        fill_at(context, t + span, moved)
        eliminate_rows(dense, order, later, 0)
        weakest = smallest_pivot(now)
        nearest, which = next_zero(now, later, context[RANK] == m, span, back, ahead, beyond)
        if candidate == 0:
            r.look_at = earliest_zero(t, weakest, speed, haste)
        if not nearest < np.inf:
            if candidate == 0:
                r.look_at = max(r.look_at, t + _TRUST * ahead)
                if state != Y0 and context[RANK] == m:
                    remember(context, t + h, weakest)
            return np.inf
        beyond = abs(nearest)
        if state != Y0:
            nearest = span * follow_pivot(context, t, span, state, which, nearest / span)
        else:
            for j in range(q.size):
                place[j] = q[j] + nearest / span * (moved[j] - q[j])
            fill_at(context, t + nearest, place)
        # With an order of pivots of its own, is this position as poor as it seems?
        eliminate_rows(dense, order, later, 1)
        least = 1.0
        for i in range(m):
            if abs(now[i]) > REDUNDANT:
                least = min(least, abs(later[i]))
        if not (least > 0.5 * weakest and least > _NEAR):
            return float(nearest)
    return np.inf
