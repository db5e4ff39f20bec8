"""Elastic belt: two strands that stretch and never push couple two pulleys."""

from collections.abc import Mapping

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Constraint
from codegen.declare.element_conditions import Condition, sign_conditions
from codegen.drawing import shapes
from codegen.elements.forces.scalar_measures import rim_travel
from codegen.elements.forces.spring_damper_contact import GapSprings
from codegen.elements.joints.carrier import WheelPair, pulleys_and_belt, radius_conditions
from codegen.elements.registry import element


@element
class ElasticBelt(WheelPair, GapSprings):
    """Tensions T0 ± (k u + c u̇), never below 0, with u = R_j (φ_j - φ_c) - R_i (φ_i - φ_c) - s0.

    u is the stretch of the one strand, and -u that of the other. The pulleys turn in bearings of
    the carrier c, the ground or an arm that turns; for a crossed belt R_i is negative in the
    stretch. k = E A/L is the stiffness of one strand, N/m, and T0 the
    tension of both when the belt is idle. A strand is slack where its stretch has used up T0/k:
    there, and where its damper would push, it exerts nothing. Both changes are events of a run.

    R_j times the difference of the tensions turns pulley j back, R_i times it turns pulley i. Their
    sum draws the bearings together inside the carrier, and is not modelled; nor are creep and slip.
    """

    kind = "elastic belt"
    example = """
        k = model.parameter("k", 2e4, unit="N/m")
        model.elastic_belt("belt", i, j, 0.1, 0.3, stiffness=k, pretension=50.0)
    """
    name: str
    i: Body
    j: Body
    carrier: Body
    radius_i: sympy.Expr
    radius_j: sympy.Expr
    crossed: bool
    stiffness: sympy.Expr
    damping: sympy.Expr
    pretension: sympy.Expr
    offset: sympy.Expr
    joints: Mapping[str, Constraint]
    may_pull = False

    @property
    def stretch(self) -> sympy.Expr:
        """u, m, of the strand that tightens where pulley j runs ahead."""
        first = self.radius_i if self.crossed else -self.radius_i
        wheels = (self.i, first), (self.j, self.radius_j)
        return rim_travel(*wheels, self.carrier) - self.offset

    @property
    def gaps(self) -> tuple[sympy.Expr, ...]:
        """How far each strand is from being taut, m."""
        idle = self.pretension / self.stiffness
        return -self.stretch - idle, self.stretch - idle

    def conditions(self) -> tuple[Condition, ...]:
        """Radii of two pulleys, a belt that stretches, and a tension that pulls."""
        stiffness = sign_conditions(
            ("stiffness", self.stiffness, "N/m"), positive=True,
            advice=", or model.belt for one that does not stretch",
        )  # fmt: skip
        more = sign_conditions(
            ("damping", self.damping, "N s/m"), ("pretension", self.pretension, "N")
        )
        return radius_conditions(self.radius_i, self.radius_j) + stiffness + more

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """Two pulleys and the belt."""
        return pulleys_and_belt(self, self.crossed)
