"""The right side of the equations of motion, as the methods call it."""

from runtime.core.array_views import view
from runtime.core.function_table import BENDS, EACH_STAGE, accelerations_of, bent_of, bent_slope_of
from runtime.core.jit import inlined
from runtime.core.signatures import Integers, Vector
from runtime.core.workspace import ROWS


@inlined
def field(
    machine: Integers,
    t: float,
    q: Vector,
    v: Vector,
    p: Vector,
    modes: Integers,
    a: Vector,
    lam: Vector,
) -> int:
    """Accelerations and multipliers; 0, or 1 + the constraint whose pivot is weak.

    Where the motion follows the machine's own equations this is its kernel and nothing else.
    """
    if machine[BENDS] == 0:
        return int(accelerations_of(machine)(t, q, v, p, modes, a, lam))
    return int(bent_of(machine)(machine, t, q, v, p, modes, a, lam))


@inlined
def slope(
    machine: Integers,
    t: float,
    state: int,
    derivative: int,
    w: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> int:
    """Write the derivative at the state in row `state` into row `derivative`.

    Where stages are corrected, the state is first; returns the iterations that took, negative
    where they failed. All but the machine's own equations is one call: a stage with three calls in
    it takes twice the time, whichever is made.
    """
    if machine[BENDS] + machine[EACH_STAGE] != 0:
        return int(bent_slope_of(machine)(machine, t, state, derivative, w, p, modes, lam))
    length = w.size // ROWS
    n = length // 2
    q = view(w, state * length, n)
    v = view(w, state * length + n, n)
    rate = view(w, derivative * length, n)
    accelerations_of(machine)(t, q, v, p, modes, view(w, derivative * length + n, n), lam)
    for j in range(n):
        rate[j] = v[j]
    return 0
