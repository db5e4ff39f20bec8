"""M(q) and Q_v of all bodies, with blocks that the equations of their bodies make definite.

Coordinates with equations Φ_b = 0 between them, such as Euler parameters, may have a mass block M_b
that is singular: the velocity along their gradient n = Φ_b,qᵀ moves nothing. Every solution obeys
nᵀ q̈ = γ_b, so

    (M + Σ μ n nᵀ) q̈ + Φ_qᵀ λ = Q + Q_v + Σ μ n γ_b

has the same accelerations and multipliers for every μ, and T is the same for nᵀ q̇ = 0 (augmented
Lagrangian; E. Bayo et al., Computer Methods in Applied Mechanics and Engineering 71, 1988). With
μ > 0 the block is positive definite if and only if M_b is so on the velocities that Φ_b allows,
which is what a body has to promise; then no pivot vanishes in any order of elimination
(`codegen.lower.linear.factorization`). μ has the size of the block: trace M_b / nᵀn, neutral pose.
"""

import sympy

from codegen.declare.body import Bodies, Body, Loads
from codegen.declare.space_body import SpaceBody
from codegen.declare.state import State
from codegen.declare.symbols import Coordinate, kinds
from codegen.readers.calls import errors_at

Entries = tuple[tuple[int, int, sympy.Expr], ...]


def inertia(
    bodies: Bodies, states: tuple[State, ...], coordinates: tuple[Coordinate, ...]
) -> tuple[Entries, tuple[tuple[int, sympy.Expr], ...]]:
    """(row, column, entry) of M, 1 for a state, and (column, Q_v) where it is not zero."""
    columns = {q: k for k, q in enumerate(coordinates)}
    mass: dict[tuple[int, int], sympy.Expr] = {(k, k): sympy.S.Zero for k in columns.values()}
    mass |= {(columns[s.integral], columns[s.integral]): sympy.S.One for s in states}
    force: dict[int, sympy.Expr] = {}
    for body in bodies:
        with errors_at(f"body '{body.name}'"):
            block = {pair: entry for pair, entry in body.mass_matrix.items() if entry is not None}
            pushes = dict(body.inertia_force)
            if not isinstance(body, SpaceBody):  # whose block is definite
                for _, phi in body.equations:
                    _augment(body, phi, block, pushes)
        for (a, b), entry in block.items():
            mass[columns[a], columns[b]] = mass[columns[b], columns[a]] = entry
        force |= {columns[q]: push for q, push in pushes.items()}
    entries = ((i, k, entry) for (i, k), entry in sorted(mass.items()) if i == k or entry != 0)
    return tuple(entries), tuple((k, f) for k, f in sorted(force.items()) if f != 0)


def neutral(coordinates: tuple[Coordinate, ...]) -> dict[sympy.Symbol, float]:
    """Coordinate → its value in the neutral pose."""
    return {q: sympy.sympify(q.measure.neutral) for q in coordinates}


def _augment(
    body: Body,
    phi: sympy.Expr,
    block: dict[tuple[Coordinate, Coordinate], sympy.Expr],
    pushes: Loads,
) -> None:
    """Add μ n nᵀ to the block, and μ n γ to the forces."""
    moved = kinds(phi, Coordinate)
    pose = neutral(body.coordinates)
    n = {q: sympy.diff(phi, q) for q in moved}
    trace = sympy.Add(*(block.get((q, q), sympy.S.Zero) for q in moved)).subs(pose)
    square = sympy.Add(*(slope**2 for slope in n.values())).subs(pose)
    mu = sympy.nsimplify(trace / square)
    rate = sympy.Add(*(slope * q.rate for q, slope in n.items()))
    gamma = -sympy.Add(*(sympy.diff(rate, q) * q.rate for q in moved))
    for at, a in enumerate(moved):
        for b in moved[at:]:
            pair = (b, a) if (b, a) in block else (a, b)
            entry = block.get(pair, sympy.S.Zero) + mu * n[a] * n[b]
            block[pair] = sympy.simplify(entry)
        pushes[a] = sympy.simplify(pushes.get(a, sympy.S.Zero) + mu * n[a] * gamma)
