"""One-way clutch: a freewheel that drives in one direction and overruns in the other."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Effect, Measure, OneWay, Pulls, Reported
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import SPEED, rate, side
from codegen.drawing import shapes
from codegen.elements.forces import scalar_measures as measures
from codegen.elements.registry import element

# formula: rad/s²; with the inertias the typical torque of a clutch
TYPICAL = 1.0


@element
class OneWayClutch(measures.TurnMeasures, Effect):
    """w = ω_j - ω_i ≥ 0, T ≥ 0, T w = 0: a torque T on the driven body j, -T on the driver i.

    Where the driven body is faster it overruns, and nothing acts. Where both have one speed it
    grips: it exerts what keeps them together, as long as that is a torque T ≥ 0, and overruns
    where the torque would be negative. Both are events of a run. A speed w < 0 at the start, or
    behind the impact of something else, ends in an impact of the clutch, w⁺ = 0, with the joints
    kept. There is no drag in overrunning, and no play.

    With a capacity T_c it slips: it exerts at most T_c, and T_c while the driver is faster.

    In mode 1 it overruns. In mode 0 the kernels exert a typical torque, from the inertias;
    accelerations are linear in it, so that a run finds by which multiple of it w stays zero.
    """

    kind = "one-way clutch"
    example = 'model.one_way_clutch("freewheel", driver=i, driven=j)'
    name: str
    i: Body
    j: Body
    capacity: sympy.Expr | None = quantity("N m", "positive", binds="positive", default=None)

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """T tends to make θ = φ_j - φ_i larger, where it does not overrun."""
        if self.capacity is None:
            return ((self.angle, -self._torque()),)
        return ((self.angle, sympy.Piecewise((-self.capacity, SPEED < 0), (0, True))),)

    def hold(self, bodies: tuple[Body, ...]) -> OneWay | None:
        """Without a capacity the speeds stay the same until the torque would be negative."""
        return OneWay(rate(self.angle), self._scale()) if self.capacity is None else None

    def reported(self, bodies: tuple[Body, ...]) -> Reported:
        """The torque on the driven body, never negative; with a capacity it is a measure."""
        return (("torque", "N m", self._torque()),) if self.capacity is None else ()

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """θ, its rate, and with a capacity the torque on the driven body, from 0 to T_c."""
        found = measures.along_scalar(self.angle, "rad", self._torque())
        return found[:2] if self.capacity is None else found

    def _torque(self) -> sympy.Expr:
        if self.capacity is None:
            return side(self.name) * self._scale()
        return sympy.Piecewise((self.capacity, SPEED < 0), (0, True))

    def _scale(self) -> sympy.Expr:
        inertias = [body.inertia for body in self.bodies if body.inertia is not None]
        return sympy.Float(TYPICAL) * (sympy.Add(*inertias) if inertias else sympy.S.One)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """A round sign between two bodies."""
        return (shapes.SpiralSpring(self.i, self.j, elastic=False, damper=True),)
