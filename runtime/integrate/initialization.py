"""The first instant of a run: partition, return onto the constraints, modes, first step."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Vector, i8, none, vector
from runtime.core.jit import ADDRESSES, compiled, inner, unlocked
from runtime.core.kernel_abi import switching_of, switching_rates_of
from runtime.core.kinds import FRICTION, ONE_WAY, OPEN, SLIDING, Direction
from runtime.core.loop_record import Plan, run_record
from runtime.core.outcomes import Outcome, Site
from runtime.core.state_derivative import evaluate_accelerations, write_derivative
from runtime.core.workspace_rows import Y0, K, row_of, switch_row
from runtime.hybrid.impact import ON_SURFACE
from runtime.hybrid.mode_consistency import CONSISTENT, RESTS, count_sliding
from runtime.hybrid.mode_transition import LOOK_AHEAD, log_event
from runtime.hybrid.rest_forces import find_jamming_friction, is_unilateral, rests, suspend_friction
from runtime.hybrid.sliding_motion import STEP, evaluate_switching_and_rates
from runtime.integrate.sampling import record
from runtime.integrate.step_acceptance import LEAST_ERROR, copy_end
from runtime.linalg.vectors import copy_vector, is_finite

_BEGAN, _CEASED = int(Direction.BEGAN), int(Direction.CEASED)
_ROUGH = 0.1  # accuracy: of a function's spread; |g| that is rounded in its last few units


@inner
def write_start(
    context: Context, q: Vector, v: Vector, sizes: Vector, scale: Vector, absolute: Vector
) -> None:
    """Put a run into the state (q, v), (n,) each, with typical sizes and changes, (n,) each.

    Absolute tolerances, (2n,), are `rtol` times the sizes, at most 1, where they are no number.
    """
    n, rtol = q.size, run_record(context).rtol
    size, tolerance = row_of(context, ws.SIZE), row_of(context, ws.ATOL)
    partition, projection = row_of(context, ws.PARTITION), row_of(context, ws.PROJECTION)
    weights, y = context.weights, row_of(context, Y0)
    for j in range(n):
        y[j], y[n + j] = q[j], v[j]
        size[j], size[n + j] = sizes[j], sizes[j]
        partition[j], partition[n + j], projection[j] = scale[j] ** 2, scale[j], scale[j] ** 2
        weights[j], weights[3 * n + j] = scale[j] ** 2, sizes[j]
    for j in range(2 * n):
        given = absolute[j]
        tolerance[j] = rtol * min(1.0, size[j]) if np.isnan(given) else given


@compiled(none(ADDRESSES, vector, vector, vector, vector, vector))
def place_start(
    context: Context, q: Vector, v: Vector, sizes: Vector, scale: Vector, absolute: Vector
) -> None:
    """For Python: see `write_start`."""
    write_start(context, q, v, sizes, scale, absolute)


@inner
def measure_spreads(context: Context, t: float) -> None:
    """Write into row TRIAL how far functions go when all is changed by its size: Σ |∂g| size.

    dg/dt is linear in velocities and accelerations; taken one at a time, each of its size, they
    give the derivatives.
    """
    p, rates = context.parameters, switching_rates_of(context)
    sample, size = row_of(context, ws.SAMPLE), row_of(context, ws.SIZE)
    q, v = context.q0, ws.positions(context, ws.SAMPLE)
    a, known = ws.velocities(context, ws.SAMPLE), context.spreads
    now, rest = switch_row(context, ws.SCAN), switch_row(context, ws.SCAN + 1)
    spread = context.trial
    sample.fill(0.0)
    rates(t, q, v, a, p, rest)
    spread.fill(0.0)
    for j in range(sample.size):
        sample[j] = size[j]
        rates(t, q, v, a, p, now)
        sample[j] = 0.0
        for k in range(spread.size):
            change = abs(now[k] - rest[k])
            spread[k] += change if np.isfinite(change) else 0.0
    for k in range(spread.size):
        spread[k] = max(spread[k], known[k])


@inner
def place_on_constraints(context: Context, t: float) -> int:
    """Choose the independent coordinates and return Y0 onto the constraints."""
    r = run_record(context)
    ft.repartition_of(context)(context, t, Y0)
    r.repartitions *= r.resumed  # what a run begins with is no change
    if r.rank < context[ft.RANK]:
        r.index = context.row_order[r.rank]
        r.site = Site.START_RANK
        return Outcome.SINGULAR
    result = ft.correct_of(context)(context, t, Y0, ws.PARTITION)
    r.returns += 1
    if result == FAILED:
        r.site = Site.START_NEWTON
        return Outcome.NEWTON_FAILED
    r.corrections += result
    return Outcome.OK


@inner
def choose_modes(context: Context, t: float) -> int:
    """Set the modes, and the sizes of switching functions by which their rounding is judged."""
    r, modes, rigid = run_record(context), context.modes, context.rigid
    largest, spread = context.largest, context.trial
    band, reserve = context.band, context.reserve
    impact_at, size = context.impact_at, ws.first_half(context, ws.SIZE)
    # A run of no length has modes too; they are judged as if it went on for a second.
    longest = r.h_max if r.h_max > 0.0 else 1.0
    h = ft.first_step_of(context)(context, t, longest, r.rtol, r.estimate_order)
    context.settings[STEP] = h
    measure_spreads(context, t)
    for k in range(modes.size):
        # The rounding of a function is that of what it is made of, however small itself.
        if rigid[k] < 0:
            largest[k] = _ROUGH * spread[k]
        else:
            impact_at[k], largest[k] = t, size[0]
            for j in range(size.size):
                largest[k] = min(largest[k], size[j])
    blamed = ft.initialize_modes_of(context)(context, 0, t, LOOK_AHEAD * h, Y0)
    for k in range(modes.size):
        if modes[k] == SLIDING:
            reserve[k] = largest[k]
            largest[k], band[k] = 1.0, 0.0
    write_derivative(context, t, Y0, K)  # after the impacts of this instant
    evaluate_switching_and_rates(context, t, Y0, K, ws.G0)
    r.rhs += 2
    if blamed != CONSISTENT:
        r.index = blamed
        r.site = Site.START_MODES
        return Outcome.INCONSISTENT
    return Outcome.OK


@inner
def record_start(context: Context, t: float) -> None:
    """Write the samples of the first instant."""
    r, t_eval = run_record(context), context.sample_times
    if r.every_step != 0:
        record(context, t, Y0)
    while r.next_sample < context[ft.SAMPLE_TIMES] and t_eval[r.next_sample] <= t:
        if r.every_step == 0:
            record(context, t_eval[r.next_sample], Y0)
        r.next_sample += 1
    for i in range(r.samples):
        for k in range(context[ft.SWITCHES]):
            # At the very instant of the start g > 0 does not hold yet on its boundary, g ≥ 0 may.
            on_boundary = context.band[k] > 0.0 and context.boundary[k] == OPEN
            if on_boundary and not is_unilateral(context, k):
                context.out_modes[i, k] = 0


@inner
def are_dependent(context: Context, t: float) -> bool:
    """Whether a weak pivot at Y0 is one of Φ_q, for which velocities do not matter.

    At rest the law of a friction with a creep speed, whose own pivot is weak in a jam, has no
    force.
    """
    v, a = ws.positions(context, ws.SAMPLE), ws.velocities(context, ws.SAMPLE)
    v.fill(0.0)
    return evaluate_accelerations(context, t, context.q0, v, context.modes, a) > 0


@unlocked(i8(ADDRESSES))
def start(context: Context) -> int:
    """Prepare a run whose state is in row Y0: everything that the first step needs.

    Returns the code of an outcome: OK, or why there is no first step (`run.index` says which
    constraint or switching function).
    """
    r = run_record(context)
    outcome: int = Outcome.OK
    t, free, weak = r.t, r.plan == Plan.FREE, 0
    if free and context[ft.CONSTRAINT_COUNT] > 0:
        outcome = place_on_constraints(context, t)
        if outcome != Outcome.OK:
            return outcome
    q, v = context.q0, context.v0
    a = ws.velocity_rates(context, K)
    # Whether the constraints are independent is not for a joint to say that friction jams.
    suspend_friction(context)
    if free:
        weak = write_derivative(context, t, Y0, K)
        if weak > 0 and are_dependent(context, t):
            r.index = weak - 1
            r.site = Site.START_WEAK
            return Outcome.SINGULAR
    else:  # accelerations are those by continuity
        copy_vector(v, ws.position_rates(context, K))
    if context[ft.SWITCHES] > 0 and r.resumed == 0:
        outcome = choose_modes(context, t)
    if not is_finite(a):
        jammed = find_jamming_friction(context, t, q, v, a)
        if jammed == CONSISTENT:
            r.index = weak - 1  # of the joint whose friction, of a creep speed, jams, if any
            r.site = Site.START_NOT_FINITE
            return Outcome.NOT_FINITE
        r.index = jammed
        r.site = Site.START_JAM
        return Outcome.INCONSISTENT
    if r.fixed == 0 and not r.h > 0.0:
        r.h = ft.first_step_of(context)(context, t, r.h_max, r.rtol, r.estimate_order)
        r.rhs += 1
    r.rhs += 1
    ft.restart_of(context)(context, t, r.h)
    if r.resumed == 0:
        record_start(context, t)
    return outcome


@inner
def follow_jumps(context: Context, t: float) -> bool:
    """Give conditions whose functions have jumped over zero the modes of their sides; if any has.

    Rates, by which a function that is at zero is judged, do not matter there: a sawtooth jumps up
    and goes down.
    """
    any_jumped, g, modes = False, context.now, context.modes
    evaluate_switching_and_rates(context, t, Y0, K, ws.G0)
    copy_end(context, 0, 1)
    switching_of(context)(t, context.q0, context.v0, context.parameters, g)
    for k in range(context[ft.SWITCHES]):
        sticks = context.sticks[k] == FRICTION
        if context.rigid[k] >= 0 or context.sticks[k] == ONE_WAY or sticks != (modes[k] == SLIDING):
            continue  # friction gives no impulse: it slides where its slip jumps
        mode = 1 if g[k] > 0.0 else 0
        least = max(context.band[k], ON_SURFACE * context.largest[k])
        if mode != modes[k] and abs(g[k]) > least:
            if sticks:
                context.largest[k] = context.reserve[k]
            modes[k], context.band[k], any_jumped = mode, 0.0, True
            log_event(context, t, k, _BEGAN if mode == 1 else _CEASED)
    if any_jumped:
        count_sliding(context, modes)
    return any_jumped


@inner
def comes_to_rest(context: Context, k: int) -> bool:
    """Whether function `k` is at zero in Y0 and stays there: a drive that stops has no crossing."""
    if is_unilateral(context, k) or context.modes[k] == SLIDING:
        return False
    least, ahead = ON_SURFACE * context.largest[k], LOOK_AHEAD * run_record(context).h
    return bool(abs(context.g0[k]) <= least and abs(ahead * context.r0[k]) <= least)


@inner
def sets_off(context: Context, k: int) -> bool:
    """Whether function `k`, which rests at zero in Y0, leaves it at a rate that is no rounding."""
    if context.modes[k] != SLIDING or not rests(context, k):
        return False
    switching_rates_of(context)(
        run_record(context).t, context.q0, context.v0, ws.velocity_rates(context, K),
        context.parameters, context.response_rates,
    )  # fmt: skip
    moved = LOOK_AHEAD * run_record(context).h * context.response_rates[k]
    return bool(abs(moved) > RESTS * context.reserve[k])


@compiled(i8(ADDRESSES))
def start_anew(context: Context) -> int:
    """Go on from the state in row Y0 under other laws of time: accelerations, modes, first step.

    Returns the code of an outcome.
    """
    r = run_record(context)
    t, r.site = r.t, Site.ANEW
    if context[ft.CONSTRAINT_COUNT] > 0 and context[ft.CORRECTING] != 0:
        result = ft.correct_of(context)(context, t, Y0, ws.PROJECTION)
        if result == FAILED:
            return Outcome.NEWTON_FAILED
        r.corrections += result
    write_derivative(context, t, Y0, K)
    if follow_jumps(context, t):
        write_derivative(context, t, Y0, K)
    for k in range(context[ft.SWITCHES]):
        evaluate_switching_and_rates(context, t, Y0, K, ws.G0)
        side = 1.0 if context.modes[k] != 0 else -1.0
        turned = side * context.g0[k] < -context.band[k]
        if turned or comes_to_rest(context, k) or sets_off(context, k):
            copy_end(context, 0, 1)
            ft.transition_of(context)(context, k, t, r.h)
            copy_end(context, 1, 0)
            if r.blamed != CONSISTENT:
                r.index = r.blamed
                return Outcome.INCONSISTENT
    if not is_finite(ws.velocity_rates(context, K)):
        return Outcome.NOT_FINITE
    r.look_at = min(r.look_at, t)
    ft.restart_of(context)(context, t, r.h)
    if r.fixed == 0:
        first = ft.first_step_of(context)(context, t, r.h_max, r.rtol, r.estimate_order)
        r.h = min(r.h, 2.0 * first)
        r.error_old, r.remembered = LEAST_ERROR, 0.0
    r.rhs += 2
    return Outcome.OK
