"""What holds a switching function at zero: the share of each field, and the motion along both.

A function g is *held* where the motion stays on g = 0: both fields push onto the surface
(A. F. Filippov, Differential Equations with Discontinuous Righthand Sides, 1988), friction sticks,
or a rigid contact is closed. With accelerations a⁰ and a¹ of modes 0 and 1 the motion has

    a = a⁰ + α (a¹ - a⁰),     dg/dt = 0,

the share α between bounds: 0 and 1; wider by the ratio of the coefficients where friction sticks.
A rigid contact has a¹ without its force and a⁰ with a unit of it; g̈ = 0 decides, and the reaction
is 1 - α units, from 0 to infinity. Friction in a joint has a⁰ without its force and a¹ with a unit
of it (`sought`). Several are held by as many shares at once: forces of different
effects add up, so that the accelerations of one changed mode each are enough.
"""

import numpy as np

from runtime.core.array_views import floats_at, integers_at, view
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    HIGH,
    LOW,
    PLAIN,
    RIGID,
    RIGID_COUNT,
    SHARE,
    SOUGHT,
    SWITCHES,
    UNIT,
    WORK,
    accelerations_of,
    gap_accelerations_of,
    switching_rates_of,
)
from runtime.core.jit import inner
from runtime.core.rounding import EPS
from runtime.core.signatures import Integers, Vector
from runtime.hybrid.degenerate_sliding import least
from runtime.hybrid.stiction_force import (
    FREE_MODE,
    choose_units,
    engage,
    outgrown,
    release,
)
from runtime.linalg.lu import solve_equilibrated
from runtime.linalg.rank_policy import SAME_HOLD

CANCELLED = 64.0 * EPS
"""accuracy: of the largest of some terms; a sum below it is their rounding."""

HELD_MODE = 2
"""A mode that is neither 0 nor 1: the motion stays on the surface."""

_UNITS = 3  # safety: attempts at a unit of the size of the force


def work_size(n: int, m: int, s: int, r: int) -> int:
    """Floats of WORK for n coordinates, m constraints, s switches and r contacts."""
    return (s + 2) * (n + m) + 2 * s * s + 4 * s + r


@inner
def units(
    machine: Integers,
    t: float,
    q: Vector,
    v: Vector,
    p: Vector,
    modes: Integers,
) -> int:
    """Fill WORK: fields with nothing held, then with one mode changed each, and what they do.

    In the place of a mode that friction whose force is sought would change, a unit of this force.
    WORK holds, with c the number of modes that are held: accelerations and multipliers of the base
    (n + m); the change by each (c rows of n + m, room for s); the matrix of d(dg/dt) or d(g̈), by
    rows (s × s); the same of the base (s). Returns what `accelerations` says of the base.
    """
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size = n + m
    plain = integers_at(machine, PLAIN, 2 * s)
    held = view(plain, s, s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    sought = integers_at(machine, SOUGHT, s)
    count = 0
    for k in range(s):
        plain[k] = HELD_MODE if modes[k] == FREE_MODE else modes[k]
        if sought[k] >= 0:
            p[sought[k]] = 0.0
        if modes[k] == HELD_MODE:
            plain[k] = HELD_MODE if sought[k] >= 0 else 0
            held[count] = k
            count += 1
    base_a, base_lam = view(work, 0, n), view(work, n, m)
    weak = int(accelerations_of(machine)(t, q, v, p, plain, base_a, base_lam))
    base = view(work, (s + 1) * size + s * s, s)
    respond(machine, t, q, v, base_a, p, held, count, base)
    choose_units(machine, t, q, v, p, count)
    for c in range(count):
        unit(machine, t, q, v, p, count, c)
    return weak


@inner
def unit(machine: Integers, t: float, q: Vector, v: Vector, p: Vector, count: int, c: int) -> None:
    """Fill the `c`-th change of the field, and what it does, in WORK, where the base stands."""
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size = n + m
    plain = integers_at(machine, PLAIN, 2 * s)
    held = view(plain, s, s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    matrix = view(work, (s + 1) * size, s * s)
    base = view(work, (s + 1) * size + s * s, s)
    column = view(work, (s + 1) * size + s * s + s, s)
    unit_a = view(work, (c + 1) * size, n)
    unit_lam = view(work, (c + 1) * size + n, m)
    engage(machine, p, held[c])
    accelerations_of(machine)(t, q, v, p, plain, unit_a, unit_lam)
    release(machine, p, held[c])
    respond(machine, t, q, v, unit_a, p, held, count, column)
    for i in range(count):
        matrix[i * count + c] = column[i] - base[i]
    for j in range(n):
        unit_a[j] -= work[j]
    for i in range(m):
        unit_lam[i] -= work[n + i]


@inner
def respond(
    machine: Integers,
    t: float,
    q: Vector,
    v: Vector,
    a: Vector,
    p: Vector,
    held: Integers,
    count: int,
    out: Vector,
) -> None:
    """Write dg/dt, for a rigid contact g̈, of the `count` functions that are held."""
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    r = machine[RIGID_COUNT]
    size = n + m
    rigid = integers_at(machine, RIGID, s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + r)
    rates = view(work, (s + 1) * size + s * s + 2 * s, s)
    gaps = view(work, (s + 1) * size + s * s + 4 * s, r)
    switching_rates_of(machine)(t, q, v, a, p, rates)
    if r > 0:
        gap_accelerations_of(machine)(t, q, v, a, p, gaps)
    for c in range(count):
        k = held[c]
        out[c] = gaps[rigid[k]] if rigid[k] >= 0 else rates[k]


@inner
def shares(machine: Integers, t: float, q: Vector, v: Vector, p: Vector, count: int) -> None:
    """Shares by which the `count` functions are held, into SHARE; not a number where none do.

    The matrix that `units` left is kept, but for the columns of units that prove too small.
    """
    s = machine[SWITCHES]
    held = view(integers_at(machine, PLAIN, 2 * s), s, s)
    for _ in range(_UNITS):
        balanced(machine, count)
        grown = 0
        for c in range(count):
            if outgrown(machine, held[c]):
                unit(machine, t, q, v, p, count, c)
                grown += 1
        if grown == 0:
            return
    balanced(machine, count)


@inner
def balanced(machine: Integers, count: int) -> None:
    """The shares with which nothing that is held changes, by the matrix that stands in WORK."""
    n, m, s = machine[COORDINATES], machine[CONSTRAINT_COUNT], machine[SWITCHES]
    size = n + m
    held = view(integers_at(machine, PLAIN, 2 * s), s, s)
    rigid = integers_at(machine, RIGID, s)
    sought, forces = integers_at(machine, SOUGHT, s), floats_at(machine, UNIT, 2 * s)
    share = floats_at(machine, SHARE, s)
    work = floats_at(machine, WORK, (s + 2) * size + 2 * s * s + 4 * s + machine[RIGID_COUNT])
    matrix = view(work, (s + 1) * size, s * s)
    base = view(work, (s + 1) * size + s * s, s)
    right = view(work, (s + 1) * size + s * s + 3 * s, s)
    copy = view(work, (s + 1) * size + s * s + 4 * s + machine[RIGID_COUNT], s * s)
    for i in range(count):
        right[i] = -base[i]
    for i in range(count * count):
        copy[i] = matrix[i]
    if solve_equilibrated(copy, right, count, SAME_HOLD) != 0:
        low, high = floats_at(machine, LOW, s), floats_at(machine, HIGH, s)
        middle = view(work, (s + 1) * size + s * s + 2 * s, s)
        reach = view(work, (s + 1) * size + s * s + s, s)
        for c in range(count):
            k = held[c]
            # A contact without a force has its upper bound as its share, and no lower one.
            middle[c] = high[k] if rigid[k] >= 0 else 0.5 * (low[k] + high[k])
            reach[c] = 1.0 if rigid[k] >= 0 else 0.5 * (high[k] - low[k])
            if sought[k] >= 0:
                middle[c], reach[c] = 0.0, forces[s + k] / forces[k]
        for i in range(count):
            right[i] = -base[i]
            for c in range(count):
                copy[i * count + c] = matrix[i * count + c]
                right[i] -= matrix[i * count + c] * middle[c]
        found = least(machine, copy, right, count, reach, SAME_HOLD)
        for i in range(count):
            right[i] = right[i] + middle[i] if found == 0 else np.nan
    for c in range(count):
        share[held[c]] = right[c]
