"""Consistency of modes: the motion that follows from them agrees, in a short look-ahead."""

import numpy as np

from runtime.constraints.newton_return import FAILED
from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Integers, Vector, view
from runtime.core.jit import inlined, inner
from runtime.core.kinds import BALANCED, CLOSED, SLIDING, Mode
from runtime.core.state_derivative import evaluate_accelerations
from runtime.hybrid.rest_forces import is_resting, rests
from runtime.hybrid.sliding_motion import UNBOUNDED, extrapolate
from runtime.linalg.vectors import largest_ratio

CONSISTENT = -1
_DECIDED = len(Mode)  # code: added to a mode in row PREFERRED
_SIGNIFICANT = 1e-14  # accuracy: change of g over its maximum that is more than rounding
RESTS = 1e-13  # accuracy: of a function's size; joints that keep it at zero keep it so closely
_FIRST = 1e-7  # measured: first look-ahead in parts of the last
MISSED = 1e-9  # accuracy: amount by which a share may exceed its bounds at an event


@inlined
def decided_entry(mode: int) -> int:
    """The entry of row PREFERRED for a mode that is decided and needs no look-ahead."""
    return mode + _DECIDED


@inlined
def fixed_entry(mode: int) -> int:
    """The entry of row PREFERRED for a mode that is decided and permits no other."""
    return mode + 2 * _DECIDED


@inlined
def is_fixed(entry: float) -> bool:
    """Whether an entry of row PREFERRED permits no other mode."""
    return int(entry) >= 2 * _DECIDED


@inlined
def preferred_mode(entry: float) -> int:
    """The mode in an entry of row PREFERRED, decided or not."""
    return int(entry) % _DECIDED


@inner
def look_ahead(context: Context, t: float, d: float, state: int) -> None:
    """Write g after a time `d`, at the acceleration in `second_scratch`, into row TRIAL."""
    extrapolate(context, state, context.second_scratch, d)
    q, v = ws.positions(context, ws.SAMPLE), ws.velocities(context, ws.SAMPLE)
    abi.switching_of(context)(t + d, q, v, context.parameters, context.trial)


@inner
def count_sliding(context: Context, modes: Integers) -> None:
    """Count the functions in sliding mode, so that the right-hand side is that of `modes`."""
    count = 0
    for k in range(modes.size):
        count += 1 if modes[k] == SLIDING else 0
    context[ft.SLIDING_COUNT] = count
    context[ft.MODIFIED] = count + context[ft.STABILIZED]


@inner
def nearest_mode(context: Context, k: int) -> int:
    """The mode, 0 or 1, at the bound to which the share of function `k` is nearer."""
    low, high = context.share_low[k], context.share_high[k]
    if low < UNBOUNDED:
        return 1
    return 1 if context.share[k] > 0.5 * (low + high) else 0


@inner
def find_unsupported(context: Context, t: float, q: Vector, v: Vector) -> int:
    """First function in sliding mode whose share is out of bounds, else `CONSISTENT`.

    The right-hand side must just have been evaluated.
    """
    count = context[ft.SLIDING_COUNT]
    for c in range(count):
        k = int(context.sliding_functions[c])
        if is_resting(context, c):
            continue
        inside = context.share_low[k] - MISSED <= context.share[k] <= context.share_high[k] + MISSED
        if context.limits[2 * k] >= 0:
            inside = ft.friction_margin_of(context)(context, t, q, v, k) >= -MISSED
        if not inside or not context.response[c * count + c] < 0.0:
            return k
    return CONSISTENT


@inner
def is_followed(context: Context, candidate: Integers, i: int) -> bool:
    """Whether the look-ahead tells of the `i`-th member; of sliding ones their shares do.

    Those that rest have none, and must stay on their surface.
    """
    k = context.members[i]
    return bool(candidate[k] != SLIDING or rests(context, k))


@inlined
def moved_by(context: Context, k: int) -> float:
    """Change of function `k` from row NOW to row TRIAL, 0 where it is rounding."""
    change = context.trial[k] - context.now[k]
    significant = abs(change) > _SIGNIFICANT * max(context.largest[k], abs(context.now[k]))
    return float(change) if significant else 0.0


@inner
def look_ahead_joined(
    context: Context, t: float, d: float, state: int, candidate: Integers
) -> None:
    """As `look_ahead`, with the joints closed, off which an extrapolated state goes."""
    q, v, a = ws.positions(context, state), ws.velocities(context, state), context.second_scratch
    closed = ft.correct_of(context)(context, t + d, ws.SAMPLE, ws.PROJECTION) != FAILED
    evaluate_accelerations(context, t, q, v, candidate, a)  # the return took their place
    if closed:
        q, v = ws.positions(context, ws.SAMPLE), ws.velocities(context, ws.SAMPLE)
        abi.switching_of(context)(t + d, q, v, context.parameters, context.trial)


@inner
def write_gap_rates(context: Context, t: float, d: float, state: int, row: int) -> None:
    """Write the rates of functions after a time `d`, as `look_ahead` goes, into row `row`."""
    look_ahead(context, t, d, state)
    q, v = ws.positions(context, ws.SAMPLE), ws.velocities(context, ws.SAMPLE)
    a, rates = context.second_scratch, ws.switch_row(context, row)
    abi.switching_rates_of(context)(t + d, q, v, a, context.parameters, rates)


@inner
def side_by_rates(context: Context, k: int, t: float, d: float, state: int) -> int:
    """The side, -1 or 1, to which the rate of contact `k` goes in proportion to time; else 0.

    A short way is lost in the rounding of a gap. The rates of gaps that joints or other contacts
    keep closed change with the square of time, by which an extrapolated state goes off these.
    """
    for part in range(3):
        write_gap_rates(context, t, 0.5 * part * d, state, ws.SCAN + part)
    now = ws.switch_row(context, ws.SCAN)[k]
    half, end = ws.switch_row(context, ws.SCAN + 1)[k], ws.switch_row(context, ws.SCAN + 2)[k]
    speeds = view(ws.row_of(context, ws.SIZE), context[ft.COORDINATES], context[ft.COORDINATES])
    rounding = RESTS * largest_ratio(ws.velocities(context, state), speeds)
    rounding += MISSED * d * largest_ratio(context.second_scratch, speeds)
    largest = context.reserve[k] if context.modes[k] == SLIDING else context.largest[k]
    linear = abs(end - 2.0 * half + now) < 0.25 * abs(end - now)
    if not linear or not abs(end - now) > largest * rounding:
        return 0
    return 1 if now + end > 0.0 else -1


@inner
def find_contradiction(
    context: Context, t: float, d: float, state: int, candidate: Integers, count: int
) -> int:
    """First of the `count` members that does not go to the side that its candidate mode claims.

    Returns `CONSISTENT` where all do. `signs` receives the direction of each: -1, 0 or 1.
    """
    members, signs = context.members, context.signs
    q, v = ws.positions(context, state), ws.velocities(context, state)
    count_sliding(context, candidate)
    evaluate_accelerations(context, t, q, v, candidate, context.second_scratch)
    if context[ft.SLIDING_COUNT] != 0:
        k = find_unsupported(context, t, q, v)
        if k != CONSISTENT:
            return k
    open_members = 0
    for i in range(count):
        signs[i] = 0
        open_members += 1 if is_followed(context, candidate, i) else 0
    joined, rates = context[ft.CONSTRAINT_COUNT] > 0, context.rate_now
    if joined:
        a = context.second_scratch
        abi.switching_rates_of(context)(t, q, v, a, context.parameters, rates)
    distance = d * _FIRST
    while open_members > 0 and distance <= 1.5 * d:
        look_ahead(context, t, distance, state)
        returned = False
        for i in range(count):
            k = members[i]
            if signs[i] != 0 or not is_followed(context, candidate, i):
                continue
            change = moved_by(context, k)
            along = distance * rates[k]
            if joined and change != 0.0 and abs(change - along) > 0.5 * abs(change):
                # The rate is not what moves it. Joints may keep it where it is.
                if not returned:
                    look_ahead_joined(context, t, distance, state, candidate)
                    returned = True
                    change = moved_by(context, k)
                least = max(context.band[k], RESTS * context.largest[k])
                change = change if abs(change) > least else 0.0
            if change != 0.0:
                signs[i] = 1 if change > 0.0 else -1
                open_members -= 1
        distance *= 10.0
    for i in range(count):
        k = int(members[i])
        if signs[i] == 0 and context.rigid[k] >= 0 and is_followed(context, candidate, i):
            signs[i] = side_by_rates(context, k, t, d, state)
        if candidate[k] == SLIDING:
            if signs[i] != 0:
                return k
            continue
        if not np.isfinite(context.trial[k]):
            return k
        entry = context.preferred[k]
        if int(entry) == decided_entry(candidate[k]) or is_fixed(entry):
            continue
        # A contact that others keep closed may touch without a force of its own; friction at rest
        # may exert any force within its bounds, also those at their ends.
        touches = (context.rigid[k] >= 0 or context.sticks[k] != 0) and signs[i] == 0
        goes_up = signs[i] > 0 or (signs[i] == 0 and context.boundary[k] == CLOSED)
        undecided = signs[i] == 0 and context.boundary[k] >= BALANCED
        if not touches and (undecided or goes_up != (candidate[k] == 1)):
            return k
    return CONSISTENT
