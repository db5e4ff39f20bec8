"""One-way clutch: a freewheel that drives in one direction and overruns in the other."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect, Measure, Pulls, label
from codegen.declare.element_conditions import Condition, number_problems, sign_conditions
from codegen.declare.symbols import SPEED
from codegen.elements.forces import scalar_measures as measures
from codegen.elements.registry import element


@element
class OneWayClutch(measures.TurnMeasures, Effect):
    """A torque from 0 to T_c on the driven body j, its opposite on the driver i, ω_j - ω_i ≥ 0.

    Where the driven body is faster it overruns, and nothing acts. Where both have one speed the
    clutch is engaged: it exerts what keeps them together, in the sliding mode of a switch, as long
    as that is a torque from 0 to the capacity T_c. It overruns where the torque would be negative,
    and slips where it would exceed T_c: there, and while the driver is still faster, it exerts T_c.
    All these changes are events of a run. There is no drag in overrunning, and no play.
    """

    kind = "one-way clutch"
    name: str
    i: Body
    j: Body
    capacity: sympy.Expr

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """T_c tends to make θ = φ_j - φ_i larger while θ̇ < 0."""
        return ((self.angle, sympy.Piecewise((-self.capacity, SPEED < 0), (0, True))),)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """θ, its rate, and the torque on the driven body, from 0 to T_c."""
        torque = sympy.Piecewise((self.capacity, SPEED < 0), (0, True))
        return measures.along_scalar(self.angle, "rad", torque)

    def problems(self) -> list[str]:
        """A body against itself, and a capacity that is none."""
        problems = measures.angle_problems(self, *self.bodies)
        problems += measures.same_body(label(self), self.bodies)
        return problems + number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """A torque that drives."""
        return sign_conditions(("capacity", self.capacity, "N m"), positive=True)
