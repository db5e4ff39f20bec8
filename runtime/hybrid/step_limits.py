"""Limits of a step besides its error: peaks of functions of the position, and dead centres.

**Peaks.** A barrier of a millimetre lies between the places at which a method of a step of a metre
looks, and the error of the step says nothing of it. The argument u of such a function, ((x - a)/b)²
of a bell, is smooth over the step where the function itself is not: the cubic through its values
and rates at both ends says how near it comes to the peak between them, and three values in between,
on the cubic of the motion, say how far that cubic is to be trusted. Where the function may be
larger there by orders of magnitude than at either end, the step ends in front of the peak, from
where on its error shows the function.

**Dead centres** of a loop in closed form. There both branches of the loop meet: its ρ, the
derivative by its angle, vanishes. The motion passes with ρ̇ ≠ 0 onto the other branch, but kernels
know ρ² alone and would stay on their branch; before, rates and errors of the loop's angles grow as
1/ρ. A step that comes too near, or that may have passed a dead centre, is therefore not taken, and
the run goes on in other coordinates (`runtime/dynamics/changes_of_coordinates.py`). At the start of
a step that passes one, ρ falls and would vanish after ρ/|ρ̇|, at its end it grows and would have
vanished ρ/ρ̇ before: where ρ goes through zero these two times add up to the step. Where a motion
turns back before, ρ² = ρ_m² + c² τ², they add up to the step and (ρ_m/c)² (1/τ₀ + 1/τ₁), three
times a step or more once the turn is resolved.
"""

import math

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Context, Vector, view
from runtime.core.jit import addressed, inner
from runtime.core.kernel_abi import peak_arguments_of
from runtime.core.kinds import EXPONENTIAL, KINK, POWER, STEP
from runtime.core.loop_record import run_record
from runtime.hybrid.events import X1, X2, X3, cubic, write_motion_between

_RISE = 4.0  # measured: logarithm of peak over ends from which on the error of a step may miss it
_IN_FRONT = 0.4  # measured: of `_RISE`; the step ends so far below the peak
_SLOW = 1.0  # safety: largest change of a power's argument times its exponent, in parts of it
_NEGLIGIBLE = -40.0  # accuracy: logarithm of a value that is negligible beside values elsewhere
_POLE = 1e-14  # accuracy: of an argument at the ends; a power of a smaller one between has a pole
_TRUSTED = 2.0  # safety: times the difference of cubic and values; distance of u from the cubic
_CERTAIN = 0.25  # measured: of the rise; up to this uncertainty the cubic sets the end of the step
_RESOLVED = 0.1  # measured: of the variation of u; largest difference of cubic and values
_ROUNDING = 1e-13  # accuracy: of the largest |u|; such a difference is rounding
_FINEST = 1e-12  # safety: of the run; shorter steps are taken as they are
_LONGEST = 0.9  # safety: part of a step; a longer part might be stretched to a stop again
_POINTS = 16  # measured: parts of the cubic, at whose ends its peak is looked for
_ZOOMS = 14  # safety: zooms, each by 8; the last covers 2e-13 of the step
_HALVINGS = 45  # safety: halvings; the last covers 3e-14 of the step

# Rows of the scratch: u and du/dt at both ends, u at three points between, rates there.
_U0, _R0, _U1, _R1, _A1, _A2, _A3, _RATES_BETWEEN = range(8)

LEAST = 0.04  # measured: of the largest ρ²; below it a loop's rates have five times the error
_ADDED = 2.0  # measured: steps; a loop with a smaller sum of both times has passed its dead centre


@inner
def evaluate_arguments(context: Context, t: float, row: int, u: Vector, rate: Vector) -> None:
    """Arguments of the functions at a state, and their rates."""
    n, y = context[ft.COORDINATES], ws.row_of(context, row)
    q, v = view(y, 0, n), view(y, n, n)
    peak_arguments_of(context)(t, q, v, context.parameters, context.modes, u, rate)


@inner
def evaluate_between(context: Context, t: float, h: float) -> None:
    """Arguments on the cubic of the motion, between both ends of the step."""
    rows = context.peak_rows
    for index, x in enumerate((X1, X2, X3)):
        write_motion_between(context, x, h)
        evaluate_arguments(context, t + x * h, ws.SAMPLE, rows[_A1 + index], rows[_RATES_BETWEEN])


@inner
def height(kind: int, exponent: float, u: float) -> float:
    """Logarithm of a function's value; of a step, of its slope."""
    size = abs(u)
    if kind < POWER:
        return u if kind == EXPONENTIAL else -2.0 * size
    if size == 0.0:
        return math.copysign(math.inf, -exponent)
    return exponent * math.log(size)


@inner
def largest_height(kind: int, exponent: float, low: float, high: float) -> float:
    """The largest height between two arguments."""
    if kind == EXPONENTIAL:
        return high
    least = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
    farthest = kind != STEP and exponent > 0.0
    return height(kind, exponent, max(abs(low), abs(high)) if farthest else least)


@inner
def cubic_range(
    y0: float, change: float, leave: float, arrive: float, low: float, high: float
) -> tuple[float, float]:
    """The range from `low` to `high`, extended by the extrema of a cubic inside its step."""
    # The slope at x is a x² + b x + leave.
    a, b = 3.0 * (leave + arrive - 2.0 * change), 2.0 * (3.0 * change - 2.0 * leave - arrive)
    under = b * b - 4.0 * a * leave
    if under > 0.0:
        half = -0.5 * (b + math.copysign(math.sqrt(under), b))
        for number in range(2):
            x = -1.0
            if number == 0 and a != 0.0:
                x = half / a
            elif number == 1 and half != 0.0:
                x = leave / half
            if 0.0 < x < 1.0:
                y = cubic(x, y0, change, leave, arrive)
                low, high = min(low, y), max(high, y)
    return low, high


@inner
def may_peak(context: Context, h: float) -> bool:
    """Whether a function may peak in the step, as far as its argument and rate at both ends say."""
    rows = context.peak_rows
    for k in range(context[ft.PEAKS]):
        kind, exponent = context.peak_kinds[k], context.peak_exponents[k]
        u0, u1 = rows[_U0, k], rows[_U1, k]
        apart = abs(u1 - u0) + h * (abs(rows[_R0, k]) + abs(rows[_R1, k]))
        least = min(abs(u0), abs(u1))
        if kind >= POWER and max(2.0, abs(exponent)) * apart <= _SLOW * least:
            continue  # it rises by 1.4 times that at most
        ends = max(height(kind, exponent, u0), height(kind, exponent, u1))
        top = largest_height(kind, exponent, min(u0, u1) - apart, max(u0, u1) + apart)
        if top - ends > _RISE and (kind >= POWER or top > _NEGLIGIBLE):
            return True
    return False


@inner
def front_of_peak(
    kind: int, exponent: float, u0: float, change: float, leave: float, arrive: float, below: float
) -> float:
    """The fraction of the step in front of the peak of the cubic at which it is so far `below`."""
    low, width, peak, largest = 0.0, 1.0, 0.0, -math.inf
    for _ in range(_ZOOMS):
        for point in range(_POINTS + 1):
            x = low + width * point / _POINTS
            y = height(kind, exponent, cubic(x, u0, change, leave, arrive))
            if y > largest:
                peak, largest = x, y
        width *= 2.0 / _POINTS
        low = max(0.0, min(peak - 0.5 * width, 1.0 - width))
    front = 0.0
    for _ in range(_HALVINGS):
        x = 0.5 * (front + peak)
        if height(kind, exponent, cubic(x, u0, change, leave, arrive)) < largest - below:
            front = x
        else:
            peak = x
    return peak


@inner
def resolved_part_for(context: Context, k: int, h: float) -> float:
    """The part of the step, at most 1, after which function `k` shows its peak."""
    rows, kind, exponent = context.peak_rows, context.peak_kinds[k], context.peak_exponents[k]
    u0, u1, a1, a2, a3 = rows[_U0, k], rows[_U1, k], rows[_A1, k], rows[_A2, k], rows[_A3, k]
    leave, arrive, change = h * rows[_R0, k], h * rows[_R1, k], u1 - u0
    if not math.isfinite(u0 + u1 + a1 + a2 + a3 + leave + arrive):
        return 1.0
    difference = max(
        abs(a1 - cubic(X1, u0, change, leave, arrive)),
        abs(a2 - cubic(X2, u0, change, leave, arrive)),
        abs(a3 - cubic(X3, u0, change, leave, arrive)),
    )
    low, high = min(u0, u1, a1, a2, a3), max(u0, u1, a1, a2, a3)
    low, high = cubic_range(u0, change, leave, arrive, low, high)
    if difference <= _ROUNDING * max(abs(low), abs(high)):
        difference = 0.0
    apart = _TRUSTED * difference
    ends = max(height(kind, exponent, u0), height(kind, exponent, u1))
    top = largest_height(kind, exponent, low - apart, high + apart)
    if not top - ends > _RISE or (kind < POWER and top < _NEGLIGIBLE):
        return 1.0
    least = _POLE * max(abs(u0), abs(u1))
    if kind == POWER and exponent < 0.0 and low < least and high > -least:
        return 1.0  # a pole, which no step shows
    seen = largest_height(kind, exponent, low, high)
    if seen - ends > _RISE and top - seen <= _CERTAIN * (seen - ends):
        x = front_of_peak(kind, exponent, u0, change, leave, arrive, _IN_FRONT * _RISE)
        if x > 0.0:
            return min(x, _LONGEST)
    resolved: float = (_RESOLVED * (high - low) / max(difference, 1e-300)) ** (1.0 / 3.0)
    return max(0.1, min(0.5, resolved))


@addressed(ft.RESOLVED_PART)
def find_resolved_part(context: Context) -> float:
    """The part of the step, at most 1, after which no peak is passed over.

    It is negative where the shortest step still leads through a kink.
    """
    r = run_record(context)
    shortest = r.length <= _FINEST * r.duration
    rows = context.peak_rows
    evaluate_arguments(context, r.t, ws.Y0, rows[_U0], rows[_R0])
    evaluate_arguments(context, r.t + r.length, ws.Y1, rows[_U1], rows[_R1])
    if not may_peak(context, r.length):
        return 1.0
    evaluate_between(context, r.t, r.length)
    part = 1.0
    for k in range(context[ft.PEAKS]):
        if not shortest:
            part = min(part, resolved_part_for(context, k, r.length))
        elif context.peak_kinds[k] == KINK and resolved_part_for(context, k, r.length) < 1.0:
            return -1.0
    return part


@addressed(ft.GUARD_BRANCHES)
def guard_branches(context: Context, t: float, h: float, taken: int) -> int:
    """1 where the step from Y0 to Y1 leads to a dead centre of a loop, else 0.

    A step that was not `taken` is judged from its start alone: whether the dead centre, within two
    of its lengths, may be why it failed.
    """
    p, count, numbers = context.parameters, context[ft.LOOPS], context.loop_nearness
    before, after = view(numbers, 0, 3 * count), view(numbers, 3 * count, 3 * count)
    largest = view(numbers, 6 * count, count)
    nearness, known = abi.dead_centres_of(context), taken == 0
    if known:
        nearness(t, context.q0, context.v0, p, before)
    else:
        nearness(t + h, context.q1, context.v1, p, after)
    for k in range(count):
        if taken != 0:
            square, rate, size = after[3 * k], after[3 * k + 1], after[3 * k + 2]
            largest[k] = max(largest[k], size)
            if not square > LEAST * largest[k]:
                return 1
            if not 2.0 * square < rate * h:
                continue
            if not known:
                nearness(t, context.q0, context.v0, p, before)
                known = True
            behind = 2.0 * square / rate
        else:
            behind = 0.0
        start, fall = before[3 * k], -before[3 * k + 1]
        if fall > 0.0 and 2.0 * start / fall + behind < _ADDED * h:
            return 1
    return 0
