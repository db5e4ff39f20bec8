"""Reactions between two modes, and what friction that sticks can bear.

Rows of reactions that a mode decides mix as the accelerations do, each mode with its own
multipliers; the others follow from the mixed multipliers.
"""

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    HELD,
    LIMITS,
    PLAIN,
    REACTION,
    REACTION_ROWS,
    RIGID_COUNT,
    SHARE,
    SWITCHES,
    WORK,
    reactions_of,
    switched_reactions_of,
)
from runtime.core.jit import addressed, inner
from runtime.core.signatures import LIMIT, Integers, Vector
from runtime.hybrid.stiction_force import engage, exert, release


@inner
def mix(machine: Integers, t: float, q: Vector, v: Vector, p: Vector, lam: Vector) -> None:
    """Fill REACTION with all rows for the mixed multipliers `lam`; `bent` must just have run."""
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size, rows, count = n + m, machine[REACTION_ROWS], machine[HELD]
    plain = integers_at(machine, PLAIN, 2 * s)
    held = view(plain, s, s)
    share = floats_at(machine, SHARE, s)
    room = floats_at(machine, REACTION, 3 * rows + m)
    out, base, other = view(room, 0, rows), view(room, rows, rows), view(room, 2 * rows, rows)
    own = view(room, 3 * rows, m)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    for c in range(count):
        release(machine, p, held[c])
    reactions_of(machine)(t, q, v, p, lam, out)
    for i in range(rows):
        base[i] = out[i]
    switched_reactions_of(machine)(t, q, v, p, plain, view(work, n, m), base)
    for i in range(rows):
        out[i] = base[i]
    for c in range(count):
        for i in range(m):
            own[i] = work[n + i] + work[(c + 1) * size + n + i]
        engage(machine, p, held[c])
        for i in range(rows):
            other[i] = base[i]
        switched_reactions_of(machine)(t, q, v, p, plain, own, other)
        release(machine, p, held[c])
        for i in range(rows):
            out[i] += share[held[c]] * (other[i] - base[i])
    exert(machine, p, count)


@addressed(LIMIT)
def limited(
    machine: Integers, t: float, q: Vector, v: Vector, p: Vector, lam: Vector, k: int
) -> float:
    """How much of what friction `k` can bear is left, in parts of it; 1 where nothing says.

    Where the force that presses depends on friction itself, bounds of the share alone do not tell
    when it tears loose: the force must be compared with what it may be, μ_s N. `bent` must just
    have run.
    """
    s, rows = machine[SWITCHES], machine[REACTION_ROWS]
    limits = integers_at(machine, LIMITS, 2 * s)
    force, limit = limits[2 * k], limits[2 * k + 1]
    if force < 0:
        return 1.0
    mix(machine, t, q, v, p, lam)
    room = floats_at(machine, REACTION, rows)
    if not room[limit] > 0.0:
        return -1.0
    return float(1.0 - abs(room[force]) / room[limit])
