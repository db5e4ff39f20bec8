"""Switching functions along a run, and their rates."""

from runtime.compiled import inlined
from runtime.integrate.signatures import Integers, Vector
from runtime.integrate.slots import switching_of, switching_rates_of
from runtime.integrate.views import view
from runtime.integrate.workspace import ROWS, SWITCH_ROWS


@inlined
def functions(
    machine: Integers,
    t: float,
    state: int,
    slot: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """Write g at the state in row `state` of the workspace into row `slot` of `sw`."""
    n = w.size // (2 * ROWS)
    s = sw.size // SWITCH_ROWS
    q, v = view(w, state * 2 * n, n), view(w, state * 2 * n + n, n)
    switching_of(machine)(t, q, v, p, view(sw, slot * s, s))


@inlined
def measure(
    machine: Integers,
    t: float,
    state: int,
    derivative: int,
    slot: int,
    w: Vector,
    sw: Vector,
    p: Vector,
    modes: Integers,
    lam: Vector,
) -> None:
    """Write g into row `slot` of `sw` and dg/dt into the next, for two rows of the workspace."""
    n = w.size // (2 * ROWS)
    s = sw.size // SWITCH_ROWS
    functions(machine, t, state, slot, w, sw, p, modes, lam)
    q, v = view(w, state * 2 * n, n), view(w, state * 2 * n + n, n)
    a = view(w, derivative * 2 * n + n, n)
    switching_rates_of(machine)(t, q, v, a, p, view(sw, (slot + 1) * s, s))
