"""Whether a step shows all that narrow functions of the position do in it.

A barrier of a millimetre lies between the places at which a method of a step of a metre looks. The
functions are therefore enclosed over the step, by interval arithmetic on the cubics of its motion,
and compared with their values at the ends of its quarters. Where more may hide, the step ends where
nothing does; no force is evaluated for that.
"""

import math

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.array_types import Context, Vector
from runtime.core.jit import addressed, inner
from runtime.core.loop_record import run_record
from runtime.core.unowned_array_views import view
from runtime.explicit_time.interval_arithmetic import cubic_bounds
from runtime.explicit_time.interval_evaluation import enclose
from runtime.linalg.vectors import copy_vector

_VARIED = 0.5  # measured: of the range of a value in a step; what it may do in a quarter of it
_HIDDEN = 0.1  # measured: of that range; what it may do there beyond what its two ends show
_NEGLIGIBLE = 1e-9  # accuracy: of the range of a value anywhere; less does not count
_LEAST = 1e-2  # safety: of a value's size; a smaller range counts as that
_PARTS = 4  # measured: of a step, at whose ends its functions are seen
_MANY_STAGES = 10  # measured: of a method that sees twice as many parts
_SWELLS = 0.25  # measured: of that range; what a step with stages at its end alone may pass over
_MOST = 500  # safety: intervals that are looked at in one step
_NARROWEST = 2.0**-20  # safety: of a part; what is not decided there hides something
_SHORTEST = 2.0**-12  # safety: of a step; the next one is no shorter
_FINEST = 1e-12  # safety: of the run; shorter steps are never rejected here
_TURN = 2.0 * math.pi
# Rows of the scratch: values at the ends of parts, bounds, what is permitted, range in the step.
_LOW, _HIGH, _STEPS, _FLOOR, _CEILING, _SIZE, _AT = range(9, 16)
ROWS = 16  # layout: of the scratch


@inner
def follow_motion(context: Context, t: float, h: float) -> None:
    """Write the cubics of all coordinates over the step, by its fraction."""
    n, ends, motion = context[ft.COORDINATES], context.position_ends, context.position_motion
    for end in range(2):
        y = ws.row_of(context, ws.Y0 if end == 0 else ws.Y1)
        q, v = view(y, 0, n), view(y, n, n)
        if context[ft.EXPANDED] != 0:
            expand = ft.expand_of(context)
            turns, p = context.position_turns, context.parameters
            expand(t + end * h, q, v, p, turns, ends[2 * end], ends[2 * end + 1])
        else:
            copy_vector(q, ends[2 * end])
            copy_vector(v, ends[2 * end + 1])
    for j in context.position_angles:  # in closed form, which knows no whole turns
        apart = ends[2, j] - ends[0, j] - 0.5 * h * (ends[1, j] + ends[3, j])
        ends[2, j] -= _TURN * math.floor(apart / _TURN + 0.5)
    for j in range(len(motion)):
        change, leave, arrive = ends[2, j] - ends[0, j], h * ends[1, j], h * ends[3, j]
        motion[j, 0], motion[j, 1] = ends[0, j], leave
        motion[j, 2] = 3.0 * change - 2.0 * leave - arrive
        motion[j, 3] = leave + arrive - 2.0 * change


@inner
def bound_values(context: Context, a: float, b: float, low: Vector, high: Vector) -> None:
    """Bounds of all values from the fraction a of the step to b."""
    r, box, motion = run_record(context), context.position_box, context.position_motion
    n, numbers = len(motion), context.position_numbers
    first = box.size - 2 * n
    for j in range(n):
        box[first + j], box[first + n + j] = cubic_bounds(motion, j, a, b)
    t0, t1, steps = r.t + a * r.length, r.t + b * r.length, context.position_work[_STEPS]
    # No function here is a table: what stands for its knots and pieces is not read.
    enclose(context.position_code, numbers, box, numbers, motion, t0, t1, low, high, steps)


@inner
def see_ranges(context: Context, end: float, parts: int) -> None:
    """Write the values at the ends of the parts up to `end`, and how far they range."""
    work, watched = context.position_work, context.position_watched
    for k in range(parts + 1):
        bound_values(context, end * k / parts, end * k / parts, work[k], work[_HIGH])
    for i in range(watched.size):
        w, least, most = watched[i], math.inf, -math.inf
        for k in range(parts + 1):
            least, most = min(least, work[k, w]), max(most, work[k, w])
        size = max(most - least, _LEAST * max(abs(least), abs(most)))
        work[_SIZE, w] = max(size, _NEGLIGIBLE * context.position_scales[i])


@inner
def exceeds(context: Context, low: Vector, high: Vector) -> bool:
    """Whether bounds go beyond what is permitted; values that there are none of do not."""
    work = context.position_work
    for w in context.position_watched:
        if low[w] < work[_FLOOR, w] or high[w] > work[_CEILING, w]:
            return True
    return False


@inner
def swells(context: Context, parts: int) -> bool:
    """Whether values go beyond those at the ends: an implicit method looks there alone."""
    work = context.position_work
    for w in context.position_watched:
        first, last, most = work[0, w], work[parts, w], _SWELLS * work[_SIZE, w]
        for k in range(1, parts):
            beyond = max(work[k, w] - max(first, last), min(first, last) - work[k, w])
            if beyond > most:
                return True
    return False


@inner
def is_resolved(context: Context, end: float) -> bool:
    """Whether the ends of the parts up to the fraction `end` of the step show what is in them."""
    work, looks = context.position_work, 0
    low, high, at = work[_LOW], work[_HIGH], work[_AT]
    stages = run_record(context).stage_calls
    parts = 2 * _PARTS if stages >= _MANY_STAGES else _PARTS
    see_ranges(context, end, parts)
    if stages == 0 and swells(context, parts):
        return False
    for k in range(parts):
        for w in context.position_watched:
            size, first, last = work[_SIZE, w], work[k, w], work[k + 1, w]
            if abs(last - first) > _VARIED * size:
                return False
            work[_FLOOR, w] = min(first, last) - _HIDDEN * size
            work[_CEILING, w] = max(first, last) + _HIDDEN * size
        a, last_end = end * k / parts, end * (k + 1) / parts
        width = last_end - a
        narrowest = _NARROWEST * width
        while a < last_end:
            b = min(a + width, last_end)
            bound_values(context, a, b, low, high)
            looks += 1
            if not exceeds(context, low, high):
                a = b
                width *= 2.0
                continue
            bound_values(context, 0.5 * (a + b), 0.5 * (a + b), at, high)
            width = 0.5 * (b - a)
            if exceeds(context, at, at) or width < narrowest or looks > _MOST:
                return False
    return True


@addressed(ft.RESOLVED_PART)
def find_resolved_part(context: Context) -> float:
    """The part of the step, at most 1, in which nothing hides."""
    r = run_record(context)
    finest = _FINEST * r.duration
    if r.length <= finest:
        return 1.0
    follow_motion(context, r.t, r.length)
    part = 1.0
    while part > _SHORTEST and not is_resolved(context, part):
        part *= 0.5
    least: float = finest / r.length
    return max(part, least)
