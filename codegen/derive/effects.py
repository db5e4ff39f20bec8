"""Effects → potential energy, its gradient, generalized forces."""

from dataclasses import dataclass

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect
from codegen.declare.symbols import Coordinate, kinds
from codegen.derive.switching import as_pieces


@dataclass(frozen=True)
class EffectTerms:
    """What one effect brings.

    Attributes
    ----------
    potential
        V, J; None without one.
    gradient
        (coordinate, ∂V/∂q).
    forces
        (coordinate, Q) that have no potential.
    """

    potential: sympy.Expr | None
    gradient: tuple[tuple[Coordinate, sympy.Expr], ...]
    forces: tuple[tuple[Coordinate, sympy.Expr], ...]


def effect_terms(effect: Effect, bodies: tuple[Body, ...]) -> EffectTerms:
    """Potential, gradient and forces of `effect` in a scene with `bodies`."""
    potential = effect.potential(bodies)
    gradient: tuple[tuple[Coordinate, sympy.Expr], ...] = ()
    if potential is not None:
        potential = as_pieces(potential)
        gradient = tuple((q, sympy.diff(potential, q)) for q in kinds(potential, Coordinate))
    given = sorted(effect.forces(bodies).items(), key=lambda pair: pair[0].name)
    forces = ((q, as_pieces(force)) for q, force in given)
    return EffectTerms(potential, gradient, tuple((q, f) for q, f in forces if f != 0))
