"""Dead centres of the loops that kernels close in closed form.

There the two branches of a loop meet. With x = ρ/R, which vanishes there, the motion passes with
ẋ ≠ 0 onto the other branch, but kernels know x² alone and would go on on the one that they are
on. So a step that may have passed one is not taken. At its start x falls and would vanish after
x/|ẋ|, at its end it grows and would have vanished x/ẋ before: where x goes through zero these two
times add up to the step. Where a motion turns back before, x² = x_m² + c² τ², they add up to the
step and (x_m/c)² (1/τ₀ + 1/τ₁), three times a step or more once the turn is resolved.
"""

import numpy as np

from runtime.compiled import compiled
from runtime.integrate.problem import System
from runtime.integrate.signatures import PASSED, Integers, Matrix, Vector
from runtime.integrate.slots import LOOP_ROWS, LOOPS, NEARNESS, dead_centres_of
from runtime.integrate.views import floats_at, integers_at, view
from runtime.integrate.workspace import ROWS, Y0, Y1, Run
from runtime.outcomes import Outcome

NONE = 2.0  # more than a step
_ADDED = 2.0  # steps: the sum of both times below which a loop has passed its dead centre
_LEAST = 1e-14  # x² that is rounding
_NEAR = 1e-3  # x² of a state from which a run that ends without a step was on its way there

_ENDS = (Outcome.STEP_TOO_SMALL, Outcome.NOT_FINITE, Outcome.NEWTON_FAILED)


@compiled(PASSED)
def passed(machine: Integers, t: float, h: float, w: Vector, run: Run, p: Vector) -> float:
    """Share of the step from Y0 to Y1 after which a loop passes its dead centre; else `NONE`.

    `run.index` then says which.
    """
    r = run[0]
    length = w.size // ROWS
    n = length // 2
    count = machine[LOOPS]
    rows = integers_at(machine, LOOP_ROWS, count)
    numbers = floats_at(machine, NEARNESS, 4 * count)
    before, after = view(numbers, 0, 2 * count), view(numbers, 2 * count, 2 * count)
    nearness = dead_centres_of(machine)
    nearness(t + h, view(w, Y1 * length, n), view(w, Y1 * length + n, n), p, after)
    known = False
    first = NONE
    for k in range(count):
        x2, rate = after[2 * k], after[2 * k + 1]
        share = NONE
        if not x2 > _LEAST:
            share = 1.0
        elif 2.0 * x2 < rate * h:
            if not known:
                nearness(t, view(w, Y0 * length, n), view(w, Y0 * length + n, n), p, before)
                known = True
            y2, fall = before[2 * k], -before[2 * k + 1]
            if fall > 0.0:
                ahead, behind = 2.0 * y2 / fall, 2.0 * x2 / rate
                if ahead + behind < _ADDED * h:
                    share = ahead / (ahead + behind)
        if share < first:
            first = share
            r.index = rows[k]
    return first


def on_the_way(system: System, t: float, state: Matrix, p: Vector, outcome: Outcome) -> int | None:
    """Which loop's dead centre stopped a run that came to no further step, if one did.

    `state` holds q and v, (2, n). Where the coordinates that are integrated turn back, their
    accelerations grow beyond all bounds there, and steps become shorter and shorter.
    """
    if not system.loop_rows or outcome not in _ENDS:
        return None
    out = np.zeros(2 * len(system.loop_rows))
    system.dead_centres(t, state[0].copy(), state[1].copy(), p, out)
    nearest = int(out[::2].argmin())
    return system.loop_rows[nearest] if out[2 * nearest] < _NEAR else None
