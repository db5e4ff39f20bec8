"""Belt drive: a belt or chain that neither stretches nor slips couples two pulleys."""

import sympy

from codegen.declare.element import ConjugateReaction, Constraint, Frame, I, J, Statement
from codegen.declare.element_fields import quantity, shared_fields
from codegen.declare.symbols import given
from codegen.drawing import shapes
from codegen.elements.joints.gear import WheelPair
from codegen.elements.registry import element

RADIUS_I, RADIUS_J = given("radius_i"), given("radius_j")
CARRIER, OFFSET = Frame("carrier"), given("offset")
PHI = (RADIUS_J * (J.phi - CARRIER.phi) - RADIUS_I * (I.phi - CARRIER.phi) - OFFSET,)


@shared_fields
class Pulleys(WheelPair):
    """Two pulleys and a belt round them, which may be crossed."""

    radius_i: sympy.Expr = quantity(
        "m", "positive", binds="positive", word="radius of the first pulley"
    )
    radius_j: sympy.Expr = quantity(
        "m", "positive", binds="positive", word="radius of the second pulley"
    )
    crossed: bool

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """Two pulleys and the belt."""
        i, j, radius_i, radius_j = self.i, self.j, self.radius_i, self.radius_j
        belt = shapes.Belt(i, j, radius_i, radius_j, self.crossed)
        return shapes.Wheel(i, radius_i), shapes.Wheel(j, radius_j), belt


@element
class Belt(Pulleys, Constraint):
    """R_j (φ_j - φ_c) - R_i (φ_i - φ_c) = s0: equal lengths of belt run off i and onto j.

    The pulleys turn in bearings of the carrier c, the ground or an arm that turns. A crossed belt
    turns them in opposite directions: R_i is negative in the equation. s0 belongs to the pulley
    angles at which the belt was laid on.

    The reaction is the force of the belt along the rim of pulley j, N, the difference of its
    tensions: R_j times it turns pulley j, and R_i times it holds pulley i back. The belt is as
    tight as it needs to be, and never slack. The sum of its tensions, which draws the bearings
    together, is inside the carrier and not modelled.
    """

    kind = "belt"
    example = """
        r_i, r_j = (model.parameter(r, 0.2, unit="m") for r in ("r_i", "r_j"))
        model.belt("chain", i, j, r_i, r_j)
    """

    def statement(self) -> Statement:
        """One equation, m: length of belt."""
        bindings = I.bind(self.i.at(0, 0)) | J.bind(self.j.at(0, 0))
        bindings |= {RADIUS_I: -self.radius_i if self.crossed else self.radius_i}
        bindings |= {RADIUS_J: self.radius_j, OFFSET: self.offset}
        bindings |= CARRIER.bind(self.carrier.at(0, 0))
        return Statement(PHI, ("belt",), ConjugateReaction((("force", "N"),)), bindings)
