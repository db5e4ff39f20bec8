"""Detection of a singular position ahead: a pivot of Φ_q that is to change its sign.

The Jacobian, columns scaled by the masses and rows of unit length, is eliminated row by row. The
pivot of a row, its largest remaining entry, is about the distance of the row from those before it.
The elimination is repeated, in the same order of pivots, at the end of a step or a little later. A
pivot that changes sign in between announces a singular position.

Pivots of the Jacobian of a large machine, in an order of few fill-ins that is kept.
"""

import numpy as np

from runtime.constraints.partitioning import evaluate_jacobian
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import EPS, Context, Vector
from runtime.core.jit import addressed, allocating, inner
from runtime.core.loop_record import run_record
from runtime.linalg.dense_elimination import Sparse, eliminate_rows, fill_unit_rows, smallest_pivot
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.sparse_elimination import by_rows, eliminate_in_order, order_sparsely
from runtime.linalg.symbolic_elimination import replay_plan, write_plan
from runtime.linalg.vectors import copy_vector, largest_ratio


@allocating(ft.FIND_PIVOTS)
def find_sparse_pivots(context: Context, row: int, search: int) -> int:
    """Eliminate the Jacobian that was evaluated last, columns scaled, rows of unit length.

    Its pivots are written into row `row` of the pivots, in an order of their own if `search`, else
    in that of the last search; the order is `pivot_rows` and `pivot_columns`, of rows without a
    pivot -1. Returns 1 where every row with an entry has a pivot, else 0.
    """
    rows, columns = context.jacobian_rows, context.jacobian_columns
    scale = ws.second_half(context, ws.PARTITION)
    order, pivot_columns, pivots = context.pivot_rows, context.pivot_columns, context.pivots[row]
    m, n, rank = order.size, scale.size, 0
    values, lengths = np.empty(rows.size), np.zeros(m)
    for e in range(rows.size):
        values[e] = context.jacobian_values[e] * scale[columns[e]]
        lengths[rows[e]] += values[e] ** 2
    for i in range(m):
        lengths[i] = max(lengths[i], context.shortest[i] ** 2)
    for e in range(rows.size):
        if lengths[rows[e]] > 0.0:
            values[e] /= np.sqrt(lengths[rows[e]])
    if search != 0:
        column_order = np.empty(n, np.int64)
        matrix = by_rows(rows, columns, values, m)
        rank = order_sparsely(matrix, n, REDUNDANT, order, column_order)
        for k in range(m):
            pivot_columns[k] = column_order[k] if k < rank else -1
    while rank < m and pivot_columns[rank] >= 0:
        rank += 1
    row_place, column_place = np.empty(m, np.int64), np.full(n, -1)
    for k in range(m):
        row_place[order[k]] = k
        if k < rank:
            column_place[pivot_columns[k]] = k
    at = rank
    for j in range(n):
        if column_place[j] < 0:
            column_place[j] = at
            at += 1
    ordered = by_rows(row_place[rows], column_place[columns], values, m)
    upper = eliminate_in_order(ordered, n, rank, np.zeros(m), REDUNDANT)
    regular = 1
    for k in range(m):
        pivots[order[k]] = upper.values[upper.starts[k]] if k < rank else 0.0
        if lengths[order[k]] > 0.0 and not abs(pivots[order[k]]) > REDUNDANT:
            regular = 0
    return regular


BEHIND = 0.1  # measured: of a step; the motion is examined from so far back
AHEAD = 2.5  # measured: of a step; the motion is examined so far ahead
_REACH = 0.5  # measured: of the coordinates' sizes; how far a motion is continued
_MARGIN = 0.5  # measured: of the time in which a pivot could vanish; time to the next look
_TRUST = 0.5  # measured: of the time ahead in which no position was found; time to the next look
_STEPS = 10.0  # safety: most steps to the next look; forces may grow meanwhile
_NEAR = 1e-5  # measured: a pivot that counts as small in any case
_CANDIDATES = 4  # measured: pivots with a change of sign that are examined; most have a pole there
_REFINED = 6  # safety: steps by which a pivot that changes sign within a step is followed
# Rows of `pivots`: pivots now, later, at the last look, and one over the lengths of Φ_q's rows.
NOW, LATER, LAST, LENGTHS = range(4)
# Places in `pivot_history`: time of the last look, smallest pivot when its order was chosen.
WHEN, LEAST = 0, 1
_POORER = 0.5  # measured: part of the smallest pivot at its search; below it a new order is found


@inner
def travel_time(way: float, speed: float, acceleration: float) -> float:
    """The time τ of a way = speed τ + acceleration τ²/2, without a difference of large numbers."""
    pace = speed + np.sqrt(speed * speed + 2.0 * acceleration * way)
    return float(2.0 * way / (pace + 1e-300))


@inner
def mean_acceleration(context: Context, v: Vector, h: float) -> float:
    """The largest mean acceleration of a step of length h that ends with v, in sizes a s²."""
    size, largest = ws.first_half(context, ws.SIZE), 0.0
    for j in range(size.size):
        largest = max(largest, abs(v[j] - context.v0[j]) / size[j])
    return float(largest / h)


@inner
def plan_next_look(
    context: Context, t: float, h: float, ahead: float, weakest: float, speed: float, rates: int
) -> None:
    """Set `look_at` to the instant until which no pivot can vanish, from time t on.

    Pivots change about as fast as the motion, whose derivative at t is row `rates`; `weakest` is
    the smallest, and within the time `ahead`, infinite at rest, nothing announced itself.
    """
    size = ws.first_half(context, ws.SIZE)
    acceleration = largest_ratio(ws.velocity_rates(context, rates), size)
    earliest = travel_time(_MARGIN * weakest, speed, acceleration)
    run_record(context).look_at = t + min(max(_TRUST * ahead, earliest), _STEPS * h)


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
def interpolate_step(context: Context, x: float, span: float, state: int) -> None:
    """Write into `SAMPLE` the position at a share x of a step, on the cubic through both ends.

    A chord would miss it by the square of the step.
    """
    q, v = context.q0, context.v0
    end, rate = ws.positions(context, state), ws.velocities(context, state)
    moved = ws.positions(context, ws.SAMPLE)
    for j in range(q.size):
        chord = end[j] - q[j]
        first, last = span * v[j] - chord, chord - span * rate[j]
        moved[j] = q[j] + x * (chord + (1.0 - x) * ((1.0 - x) * first + x * last))


@inner
def continue_motion(context: Context, s: float) -> None:
    """Write into `SAMPLE` the position on the tangent of the motion, a time s after Y0."""
    q, v = context.q0, context.v0
    moved = ws.positions(context, ws.SAMPLE)
    for j in range(q.size):
        moved[j] = q[j] + s * v[j]


@inner
def find_pivots(context: Context, t: float, state: int, row: int, search: int) -> None:
    """Eliminate Φ_q at t and the position in row `state`, columns scaled and rows of unit length.

    Its pivots are written into row `row` of the pivots, in an order of their own if `search`.
    """
    dense = context.dense_jacobian
    sparse = evaluate_jacobian(context, t, ws.positions(context, state))
    if context[ft.SPARSE] != 0:
        ft.find_pivots_sparsely_of(context)(context, row, search)
        return
    fill_unit_rows(sparse, context.scale, context.shortest, dense, context.pivots[row])
    eliminate_rows(dense, context.pivot_columns, context.pivots[row], search)


@inner
def next_zero(
    context: Context, span: float, back: float, ahead: float, beyond: float
) -> tuple[float, int]:
    """Time, by linear interpolation, of the pivot that vanishes next after `beyond`, and its row.

    The time lies between `back` and `ahead`, or is infinite.
    """
    now, later = context.pivots[NOW], context.pivots[LATER]
    nearest, which = np.inf, 0
    for i in range(now.size):
        change = later[i] - now[i]
        if max(abs(now[i]), abs(later[i])) <= REDUNDANT or change == 0.0:
            continue
        s = -now[i] * span / change
        if back <= s <= ahead and beyond < abs(s) < abs(nearest):
            nearest, which = s, i
    return nearest, which


@inner
def keep_pivots(context: Context, instant: float) -> None:
    """Keep the later pivots as those of the last look."""
    context.pivot_history[WHEN] = instant
    copy_vector(context.pivots[LATER], context.pivots[LAST])


@inner
def stays_regular(
    context: Context, t: float, h: float, state: int, speed: float, ahead: float
) -> bool:
    """Whether pivots by the plan announce nothing at the end of a step; says when to look again."""
    known = context.pivot_history
    last, later = context.pivots[LAST], context.pivots[LATER]
    flat, lengths = context.flat_jacobian, context.pivots[LENGTHS]
    sparse = evaluate_jacobian(context, t + h, ws.positions(context, state))
    if context[ft.SPARSE] != 0:
        if ft.find_pivots_sparsely_of(context)(context, LATER, 0) == 0:
            return False
    elif not replay_plan(sparse, context.scale, flat, context.elimination_plan, lengths, later):
        return False
    weakest = min(smallest_pivot(last), smallest_pivot(later))
    passed = t + h - known[WHEN]
    if not weakest > _POORER * known[LEAST] or approaches_zero(last, later, passed, ahead - h):
        return False
    keep_pivots(context, t + h)
    last_rates = ws.K + run_record(context).last
    plan_next_look(context, t + h, h, ahead - h, weakest, speed, last_rates)
    return True


@inner
def remember(context: Context, instant: float, weakest: float) -> None:
    """Keep the later pivots and the plan of their order for the next look."""
    keep_pivots(context, instant)
    later, lengths = context.pivots[LATER], context.pivots[LENGTHS]
    context.pivot_history[LEAST] = min(weakest, smallest_pivot(later))
    if context[ft.SPARSE] != 0:
        context.elimination_plan[0] = 1  # the order alone, which `find_pivots_sparsely` keeps
        return
    sparse = Sparse(context.jacobian_rows, context.jacobian_columns, context.jacobian_values)
    order, dense, plan = context.pivot_columns, context.dense_jacobian, context.elimination_plan
    write_plan(order, sparse, context.scale, dense, plan, lengths)
    for i in range(lengths.size):
        lengths[i] /= max(1.0, lengths[i] * context.shortest[i])


@inner
def follow_pivot(
    context: Context, t: float, span: float, state: int, which: int, first: float
) -> float:
    """Share of the step at which the pivot of row `which` vanishes, from the guess `first` on.

    By the Illinois rule, as pivots are no straight lines.
    """
    later = context.pivots[LATER]
    low, high, x = 0.0, 1.0, first
    at_low, at_high = context.pivots[NOW][which], later[which]
    for _ in range(_REFINED):
        if not x < 1.0:
            break
        interpolate_step(context, x, span, state)
        find_pivots(context, t + x * span, ws.SAMPLE, LATER, 0)
        if (later[which] > 0.0) == (at_low > 0.0):
            low, at_low, at_high = x, later[which], 0.5 * at_high
        else:
            high, at_high, at_low = x, later[which], 0.5 * at_low
        x = low - at_low * (high - low) / (at_high - at_low)
    return x


@addressed(ft.VANISHING)
def predict_vanishing_pivot(context: Context, t: float, h: float, state: int) -> float:
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
    r, plan, size = run_record(context), context.elimination_plan, ws.first_half(context, ws.SIZE)
    now, later = context.pivots[NOW], context.pivots[LATER]
    failed = state == ws.Y0
    v = ws.velocities(context, state)
    speed = max(largest_ratio(context.v0, size), largest_ratio(v, size))
    acceleration = 0.0 if failed else mean_acceleration(context, v, h)
    span, back = h, 0.0
    ahead = max(AHEAD * h, travel_time(r.foresight, speed, acceleration))
    # Only from look to look: in a gap between them a pivot may change its sign twice.
    known = plan[0] > 0 and t <= r.look_at and t + h > context.pivot_history[WHEN]
    if not failed and known and stays_regular(context, t, h, state, speed, ahead):
        return np.inf
    plan[0] = 0
    if failed:
        # Rounding fails steps that are shorter and shorter within this distance, on either side.
        noisy = np.cbrt(EPS / r.rtol) / max(speed, 1e-300)
        back, ahead = -max(BEHIND * h, noisy), max(h, noisy)
        span = min(h, _REACH / max(speed, 1e-300))
    beyond = -1.0
    for candidate in range(_CANDIDATES):
        find_pivots(context, t, ws.Y0, NOW, 1)
        if failed:
            continue_motion(context, span)
        find_pivots(context, t + span, ws.SAMPLE if failed else state, LATER, 0)
        weakest = smallest_pivot(now)
        nearest, which = next_zero(context, span, back, ahead, beyond)
        if candidate == 0:
            trusted = 0.0 if nearest < np.inf else ahead
            plan_next_look(context, t, h, trusted, weakest, speed, ws.K)
        if not nearest < np.inf:
            if candidate == 0 and not failed:
                remember(context, t + h, weakest)
            return np.inf
        beyond = abs(nearest)
        if failed:
            continue_motion(context, nearest)
        else:
            share = follow_pivot(context, t, span, state, which, nearest / span)
            nearest = share * span
            interpolate_step(context, share, span, state)
        # With an order of pivots of its own, is this position as poor as it seems?
        find_pivots(context, t + nearest, ws.SAMPLE, LATER, 1)
        least = 1.0
        for i in range(now.size):
            if abs(now[i]) > REDUNDANT:
                least = min(least, abs(later[i]))
        if not (least > 0.5 * weakest and least > _NEAR):
            return float(nearest)
    return np.inf
