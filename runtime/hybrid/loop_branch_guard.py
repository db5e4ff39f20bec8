"""Guard of loop branches: no step passes a dead centre of a loop in closed form.

At a dead centre both branches of a loop meet: its ρ, the derivative by its angle, vanishes. The
motion passes with ρ̇ ≠ 0 onto the other branch, but kernels know ρ² alone and would stay on their
branch. A step that may have passed a dead centre is therefore rejected. At its start ρ
falls and would vanish after ρ/|ρ̇|, at its end it grows and would have vanished ρ/ρ̇ before: where ρ
goes through zero these two times add up to the step. Where a motion turns back before,
ρ² = ρ_m² + c² τ², they add up to the step and (ρ_m/c)² (1/τ₀ + 1/τ₁), three times a step or more
once the turn is resolved.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Context, Matrix, Vector
from runtime.core.jit import addressed
from runtime.core.loop_record import run_record
from runtime.core.outcomes import Outcome
from runtime.core.system import System
from runtime.core.unowned_array_views import view

SHORTEN = -1
_ADDED = 2.0  # measured: steps; with a smaller sum of both times a loop has passed its dead centre
_LEAST = 1e-14  # accuracy: of the largest ρ² so far; rounding
_NEAR = 1e-2  # measured: of the largest ρ² so far; below it steps shorten towards a dead centre
_AT_ONCE = 1e-3  # measured: of a usual step; a run ends at a dead centre this near
_SHORT_OF = 0.9  # measured: of the time to a dead centre; longest next step
_SHORT = 1e-4  # accuracy: of the last step from further away; shorter ones follow rounding

DEAD_CENTRE_NOTE = (
    "At t = {:.9g} s its loop is at a dead centre, where both ways to close it meet, and reduced "
    'coordinates follow one of them; take formulation="cartesian", which goes on from there.'
)
"""Message to the user about a run that ends there, at an instant."""

_ENDS = (Outcome.STEP_TOO_SMALL, Outcome.NOT_FINITE, Outcome.NEWTON_FAILED)


@addressed(ft.GUARD_BRANCHES)
def guard_branches(context: Context, t: float, h: float) -> int:
    """Judge a step from Y0 to Y1: 0, `SHORTEN` with `run.h` shorter, or the code of an outcome.

    It is 0 where no loop passes its dead centre. Where the run ends, `run.index` and `run.turn` say
    which loop does and when. The accelerations are a quotient 0/0 at a dead centre, and at the time
    τ before it they err by their rounding over τ³: no step control comes there, so steps much
    shorter than those further away end a run too.
    """
    r, p = run_record(context), context.parameters
    count, numbers = context[ft.LOOPS], context.loop_nearness
    before, after = view(numbers, 0, 2 * count), view(numbers, 2 * count, 2 * count)
    largest = view(numbers, 4 * count, count)
    nearness = abi.dead_centres_of(context)
    nearness(t + h, context.q1, context.v1, p, after)
    known, away = False, True
    stuck = h < _SHORT * numbers[5 * count]
    first, over, row = np.inf, False, -1
    for k in range(count):
        square, rate = after[2 * k], after[2 * k + 1]
        near = not square > _NEAR * largest[k]
        away = away and not near
        left = np.inf
        if not square > _LEAST * largest[k]:
            left = h
        elif stuck and near and rate < 0.0:
            over = True
            left = h - 2.0 * square / rate
        elif 2.0 * square < rate * h:
            if not known:
                nearness(t, context.q0, context.v0, p, before)
                known = True
            start, fall = before[2 * k], -before[2 * k + 1]
            if fall > 0.0:
                ahead, behind = 2.0 * start / fall, 2.0 * square / rate
                if ahead + behind < _ADDED * h:
                    left = h * ahead / (ahead + behind)
        largest[k] = max(largest[k], square)
        if left < first:
            first, row = left, context.loop_rows[k]
    if away:
        numbers[5 * count] = h
    if row < 0:
        return 0
    if over or first <= _AT_ONCE * r.usual:
        r.index, r.turn = row, t + first
        return Outcome.SINGULAR
    r.rejected += 1
    r.rejected_before = 1
    r.h = _SHORT_OF * first
    return SHORTEN


def find_dead_centre(
    system: System, t: float, state: Matrix, p: Vector, numbers: Vector, outcome: Outcome
) -> int | None:
    """The loop whose dead centre stopped a run that found no further step, or None.

    `state` holds q and v, (2, n), `numbers` the record of `guard_branches`. Where the integrated
    coordinates turn back, their accelerations grow beyond all bounds there.
    """
    count = len(system.loop_rows)
    if not count or outcome not in _ENDS:
        return None
    out = np.zeros(2 * count)
    system.dead_centres(t, state[0].copy(), state[1].copy(), p, out)
    near = [k for k in range(count) if not out[2 * k] > _NEAR * numbers[4 * count + k]]
    return system.loop_rows[near[0]] if near else None
