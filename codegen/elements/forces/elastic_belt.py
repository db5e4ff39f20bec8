"""Elastic belt: two strands that stretch and never push couple two pulleys."""

import sympy

from codegen.declare.element_fields import quantity
from codegen.elements.forces.scalar_measures import rim_travel
from codegen.elements.forces.spring_damper_contact import GapSprings
from codegen.elements.joints.belt import Pulleys
from codegen.elements.registry import element


@element
class ElasticBelt(Pulleys, GapSprings):
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
    stiffness: sympy.Expr = quantity(
        "N/m", "positive", binds="positive", advice=", or model.belt for one that does not stretch"
    )
    damping: sympy.Expr = quantity("N s/m", "nonnegative")
    pretension: sympy.Expr = quantity("N", "nonnegative")
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
