"""Gears and racks in space, between the coordinates of joints, through their turns."""

from typing import ClassVar

import sympy

from codegen.declare.body import Bodies
from codegen.declare.element import ConjugateReaction, Constraint, Statement
from codegen.declare.element_fields import quantity, shared_fields
from codegen.declare.symbols import given
from codegen.elements.registry import element

RATIO, OFFSET = given("ratio"), given("offset")


@shared_fields
class Teeth(Constraint):
    """A coordinate of a joint follows the angle of another joint, through all turns."""

    letter: ClassVar[str]  # of the coordinate that follows
    name: str
    angle: sympy.Expr = quantity("rad")
    driven: sympy.Expr = quantity()
    ratio: sympy.Expr = quantity()
    offset: sympy.Expr = quantity(lambda of: getattr(of.driven, "unit", ""))
    on: Bodies

    def statement(self) -> Statement:
        """One equation, rad or m."""
        phi = (self.driven - RATIO * self.angle - OFFSET,)
        bindings = {RATIO: self.ratio, OFFSET: self.offset}
        return Statement(phi, ("mesh",), ConjugateReaction.along(self.letter), bindings)


@element(space=True)
class GearInSpace(Teeth):
    """Two wheels mesh: the angle of one joint follows that of another, through all turns.

    θ_j - n θ_i - θ_0 = 0, with the ratio n = ± R_i/R_j, negative where positive turns of the one
    make negative ones of the other. Both joints have the carrier of the wheels, or the ground, as
    one of their two bodies, and the angles are relative to it. The reaction is the torque on the
    second wheel about its axis; that on the first is -n times it. The bearings' share of the force
    of the teeth is not computed.
    """

    kind = "gear in space"
    letter = "angle"


@element(space=True)
class RackInSpace(Teeth):
    """A pinion drives a rack: the slide of one joint follows the angle of another.

    s - R θ - s0 = 0, with R negative where positive turns make the slide smaller. The reaction is
    the force on the rack along its slide; the torque on the pinion is -R times it.
    """

    kind = "rack in space"
    letter = "slide"
    ratio: sympy.Expr = quantity("m")
