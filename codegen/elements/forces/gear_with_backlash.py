"""Gear with backlash: teeth that bear on either flank, by a spring and a damper, with play."""

import sympy

from codegen.declare.element import label
from codegen.declare.element_conditions import Condition
from codegen.declare.element_fields import quantity
from codegen.drawing import shapes
from codegen.elements.forces.scalar_measures import rim_travel
from codegen.elements.forces.spring_damper_contact import GapSprings
from codegen.elements.joints.gear import WheelPair, toothed_wheels
from codegen.elements.registry import element


@element
class GearWithBacklash(WheelPair, GapSprings):
    """f = k (u ∓ b/2) + c u̇ where |u| > b/2, with u = R_i (φ_i - φ_c) + R_j (φ_j - φ_c) - s0.

    u is how far the teeth have moved through each other along the pitch circles, m, from the middle
    of the backlash b. On each flank they bear by a stiffness k and a damping c, and never pull:
    where the damper would, it is cut off. Contact and its end are events of a run, and between the
    flanks nothing acts. The gears turn in bearings of the carrier c, the ground or an arm that
    turns; an internal gear has a negative radius.

    -R_i f turns gear i and -R_j f gear j. There is no pressure angle: the force along the line of
    centres, and the shift of the pitch point, are inside the carrier. For rigid teeth without play
    see gear.
    """

    kind = "gear with backlash"
    example = """
        k = model.parameter("k", 5e6, unit="N/m")
        c = model.parameter("c", 200.0, unit="N s/m")
        model.gear_with_backlash("mesh", i, j, 0.1, 0.3, backlash=1e-4, stiffness=k, damping=c)
    """
    stiffness: sympy.Expr = quantity(
        "N/m", "positive", binds="positive", advice=", or model.gear for teeth that are rigid"
    )
    backlash: sympy.Expr = quantity("m", "nonnegative")
    damping: sympy.Expr = quantity("N s/m", "nonnegative")
    may_pull = False

    @property
    def gaps(self) -> tuple[sympy.Expr, ...]:
        """The play that is left before each flank, m."""
        wheels = (self.i, self.radius_i), (self.j, self.radius_j)
        moved = rim_travel(*wheels, self.carrier) - self.offset
        return self.backlash / 2 - moved, self.backlash / 2 + moved

    def problems(self) -> list[str]:
        """Gears and a carrier that are none."""
        problems = super().problems()
        if all(radius.is_number and radius < 0 for radius in (self.radius_i, self.radius_j)):
            problems.append(f"{label(self)}: both gears are internal; make one radius positive.")
        return problems

    def conditions(self) -> tuple[Condition, ...]:
        """Radii of two pitch circles."""
        product = self.radius_i * self.radius_j
        text = "the radii ({1:g}, {2:g}) m contain a 0; give the radii of the pitch circles."
        return (Condition(text, (product**2, self.radius_i, self.radius_j), open=True),)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """Two toothed wheels."""
        return toothed_wheels((self.i, self.radius_i), (self.j, self.radius_j))
