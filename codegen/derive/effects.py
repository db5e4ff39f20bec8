"""Effects → potential energy, its gradient, generalized forces."""

from dataclasses import dataclass

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect, Pressing, friction_law
from codegen.declare.symbols import Coordinate, kinds, t
from codegen.derive.switching import as_pieces


@dataclass(frozen=True)
class FrictionTerms:
    """A force -grip · N along a slip s, N from the reaction of a joint.

    Attributes
    ----------
    joint
        Name of the joint that rubs.
    slip
        ṡ.
    grip
        strength · tanh(ṡ / creep).
    direction
        (coordinate, ∂s/∂q): the generalized forces of a unit force along s.
    contacts
        Loads as in `FrictionLaw`.
    unit
        Of the force.
    """

    joint: str
    slip: sympy.Expr
    grip: sympy.Expr
    direction: tuple[tuple[Coordinate, sympy.Expr], ...]
    contacts: tuple[Pressing, ...]
    unit: str


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
    friction
        The force that follows from a joint's reaction, if this is one.
    """

    potential: sympy.Expr | None
    gradient: tuple[tuple[Coordinate, sympy.Expr], ...]
    forces: tuple[tuple[Coordinate, sympy.Expr], ...]
    friction: FrictionTerms | None = None


def effect_terms(effect: Effect, bodies: tuple[Body, ...]) -> EffectTerms:
    """Potential, gradient and forces of `effect` in a scene with `bodies`."""
    potential = effect.potential(bodies)
    gradient: tuple[tuple[Coordinate, sympy.Expr], ...] = ()
    if potential is not None:
        potential = as_pieces(potential)
        gradient = tuple((q, sympy.diff(potential, q)) for q in kinds(potential, Coordinate))
    given = sorted(effect.forces(bodies).items(), key=lambda pair: pair[0].name)
    forces = ((q, as_pieces(force)) for q, force in given)
    pushing = tuple((q, f) for q, f in forces if f != 0)
    return EffectTerms(potential, gradient, pushing, _friction(effect))


def _friction(effect: Effect) -> FrictionTerms | None:
    law = friction_law(effect)
    if law is None:
        return None
    direction = tuple((q, sympy.diff(law.along, q)) for q in kinds(law.along, Coordinate))
    slip = sympy.Add(*(slope * q.rate for q, slope in direction), sympy.diff(law.along, t))
    grip = law.strength * sympy.tanh(slip / law.creep)
    return FrictionTerms(law.joint, slip, grip, direction, law.contacts, law.unit)
