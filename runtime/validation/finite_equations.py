"""Elements whose equations or forces are not finite numbers at a state."""

from collections.abc import Iterator

import numpy as np

from codegen.errors import AssemblyError
from runtime.core.kinds import SLIDING
from runtime.mechanism.dense_equations import Equations, FloatArray, IntArray

_AHEAD = tuple(10.0**k for k in range(-12, 0))  # safety: of a second; where a run was to go next
_OF_FORCES = "effect", "nonconservative"  # kinds of powers
_PLACES = (
    "a power, a root or a logarithm at or below zero, a division by zero, a table's end, an "
    "exponential that overflows (1/(1 + exp(x)) is (1 - tanh(x/2))/2)"
)


def require_finite(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> None:
    """Refuse a start at which constraints, their rates or their accelerations are not finite."""
    problems = list(_constraints(equations, t, q, v))
    if problems:
        raise AssemblyError([f"{equations.description.title}: {problem}" for problem in problems])


def describe_infinite(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, modes: IntArray
) -> str:
    """Sentences on what is not finite at a state, or else soon after it; empty where all is."""
    modes = np.where(modes == SLIDING, 0, modes)
    for ahead in (0.0, *_AHEAD):
        state = t + ahead, q + ahead * v, v
        found = [*_constraints(equations, *state), *_forces(equations, *state, modes)]
        if found:
            return " ".join(sentence[0].upper() + sentence[1:] for sentence in found)
    return ""


def _constraints(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> Iterator[str]:
    """A sentence for each joint or driver with a row that is not finite."""
    table = equations.description.constraints
    moving = equations.description.analysis != "equilibrium"
    parts = (
        ("equation Φ", equations.constraints(t, q)),
        ("derivative Φ_q", _sums(equations, t, q)),
        ("velocity ν", equations.velocity_rhs(t, q)),
        ("acceleration γ", equations.acceleration_rhs(t, q, v) if moving else np.zeros(0)),
    )
    named: set[str] = set()
    for word, values in parts:
        for row in np.flatnonzero(~np.isfinite(values)):
            element = table[row].element
            if element not in named:
                named.add(element)
                yield (
                    f"the {word} of {table[row].kind} '{element}' is {values[row]} at "
                    f"t = {t:.9g} s; look for {_PLACES}, and write a law that has finite first "
                    "and second derivatives there, or start elsewhere."
                )


def _sums(equations: Equations, t: float, q: FloatArray) -> FloatArray:
    """Sums of the rows of Φ_q, (m,)."""
    sums = np.zeros(equations.m)
    np.add.at(sums, equations.description.jacobian_rows, equations.slopes(t, q))
    return sums


def _forces(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, modes: IntArray
) -> Iterator[str]:
    """A sentence for each effect whose force is not finite, as far as the tables tell."""
    description = equations.description
    if not description.has_masses:
        return
    forces = equations.forces(t, q, v, modes)
    along = [row.name for row, f in zip(description.coordinates, forces, strict=True) if _bad(f)]
    if not along:
        return
    powers, idle = np.zeros(len(description.powers)), np.zeros(equations.m)
    equations.kernels.powers(t, q, v, equations.p, modes, idle, powers)
    rows = zip(description.powers, powers, strict=True)
    working = {row.name for row in description.powers}
    blamed = [row.name for row, power in rows if row.kind in _OF_FORCES and _bad(power)]
    if not blamed:
        blamed = [row.name for row in description.effects if row.name not in working]
    if blamed:
        names = " or ".join(f"'{name}'" for name in dict.fromkeys(blamed))
        yield (
            f"the force of {names} along {', '.join(along)} is not finite at t = {t:.9g} s; look "
            f"for {_PLACES}, or for a spring whose ends coincide."
        )


def _bad(number: float) -> bool:
    return not np.isfinite(number)
