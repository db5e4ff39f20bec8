"""Guard of loop branches: no step comes near a dead centre of a loop in closed form.

At a dead centre both branches of a loop meet: its ρ, the derivative by its angle, vanishes. The
motion passes with ρ̇ ≠ 0 onto the other branch, but kernels know ρ² alone and would stay on their
branch; before, rates and errors of the loop's angles grow as 1/ρ. A step that comes too near, or
that may have passed a dead centre, is therefore not taken, and the run goes on in other coordinates
(`runtime/dynamics/changes_of_coordinates.py`). At the start of a step that passes one, ρ falls and
would vanish after ρ/|ρ̇|, at its end it grows and would have vanished ρ/ρ̇ before: where ρ goes
through zero these two times add up to the step. Where a motion turns back before,
ρ² = ρ_m² + c² τ², they add up to the step and (ρ_m/c)² (1/τ₀ + 1/τ₁), three times a step or more
once the turn is resolved.
"""

from runtime.core import function_table_slots as ft
from runtime.core import kernel_abi as abi
from runtime.core.array_types import Context
from runtime.core.jit import addressed
from runtime.core.unowned_array_views import view

LEAST = 0.04  # measured: of the largest ρ²; below it a loop's rates err by five times as much
_ADDED = 2.0  # measured: steps; with a smaller sum of both times a loop has passed its dead centre


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
