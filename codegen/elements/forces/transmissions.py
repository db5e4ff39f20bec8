"""Torques between bodies that turn: motors, freewheels, elastic belts and gears."""

from dataclasses import replace

import sympy

from codegen.declare.body import Bodies, Body
from codegen.declare.element import Effect, Measures, OneWay, Pulls, Reported, label
from codegen.declare.element_fields import Condition, Conditions, ground_unless_given, quantity
from codegen.declare.symbols import SPEED, rate, side
from codegen.drawing import shapes
from codegen.elements import scalar_measures as measures
from codegen.elements.forces.contacts import GapSprings
from codegen.elements.joints.wheels import Pulleys, WheelPair, toothed_wheels
from codegen.elements.registry import element
from codegen.elements.scalar_measures import rim_travel


@element
class Motor(measures.TurnMeasures, Effect):
    """An electric motor with a straight torque-speed curve turns body j against body i.

    T = T_s (u - ω/ω_0) on the rotor j, -T on the stator i, with ω = φ̇_j - φ̇_i.

    This is the torque-speed line of a motor with permanent magnets, whose armature has neither
    inductance nor friction. T_s is the torque at rest and ω_0 the speed without load, both at the
    rated voltage; u is the voltage divided by the rated voltage, usually from -1 to 1. With u = 0
    the motor is short-circuited and brakes with the damping T_s/ω_0; beyond ω_0 it is a generator.
    """

    kind = "motor"
    example = """
        T_s = model.parameter("T_s", 0.8, unit="N m")
        omega_0 = model.parameter("omega_0", 300.0, unit="rad/s")
        model.motor("motor", on=j, from_=i, stall_torque=T_s, no_load_speed=omega_0)
    """
    name: str
    i: Body = ground_unless_given()
    j: Body
    stall_torque: sympy.Expr = quantity("N m", "positive", binds="positive")
    no_load_speed: sympy.Expr = quantity(
        "rad/s", "positive", binds="positive", word="no-load speed"
    )
    voltage: sympy.Expr = quantity()

    def pulls(self, bodies: Bodies) -> Pulls:
        """T tends to make θ = φ_j - φ_i larger."""
        line = SPEED / self.no_load_speed - self.voltage
        return ((self.angle, self.stall_torque * line),)

    def exerting(self, value: sympy.Expr) -> "Motor":
        """The motor whose torque is that value at any speed."""
        return replace(self, stall_torque=value, no_load_speed=sympy.oo, voltage=sympy.S.One)

    def measures(self, bodies: Bodies) -> Measures:
        """θ, ω and T."""
        line = self.voltage - SPEED / self.no_load_speed
        return measures.along_scalar(self.angle, "rad", self.stall_torque * line)

    def shapes(self) -> shapes.Shapes:
        """A round arrow between two bodies."""
        return (shapes.SpiralSpring(self.i, self.j, elastic=False, actuator=True, pushes=True),)


# formula: rad/s²; with the inertias the typical torque of a clutch
TYPICAL = 1.0


@element
class OneWayClutch(measures.TurnMeasures, Effect):
    """A freewheel: body i drives body j in one direction, and lets it run ahead.

    w = ω_j - ω_i ≥ 0, T ≥ 0, T w = 0: a torque T on the driven body j, -T on the driver i.

    If the driven body is faster, the clutch overruns and nothing acts. If both have one speed, it
    grips: it exerts the torque T ≥ 0 that keeps them together, and overruns where T would be
    negative. Both changes are events of a run. If w < 0 at the start, or after an impact elsewhere,
    the clutch has an impact, w⁺ = 0, in which the joints hold. An overrunning clutch has no drag,
    and there is no play.

    With a capacity T_c the clutch slips: T is at most T_c, and equals T_c while the driver is
    faster.

    In mode 1 the clutch overruns. In mode 0 the kernels exert a typical torque, from the inertias.
    Accelerations are linear in the torque, so that a run finds the multiple that keeps w at zero.
    """

    kind = "one-way clutch"
    example = 'model.one_way_clutch("freewheel", driver=i, driven=j)'
    name: str
    i: Body
    j: Body
    capacity: sympy.Expr | None = quantity("N m", "positive", binds="positive", default=None)

    def pulls(self, bodies: Bodies) -> Pulls:
        """T tends to make θ = φ_j - φ_i larger, where it does not overrun."""
        if self.capacity is None:
            return ((self.angle, -self._torque()),)
        return ((self.angle, sympy.Piecewise((-self.capacity, SPEED < 0), (0, True))),)

    def hold(self, bodies: Bodies) -> OneWay | None:
        """Without a capacity the speeds stay the same until the torque would be negative."""
        return OneWay(rate(self.angle), self._scale()) if self.capacity is None else None

    def reported(self, bodies: Bodies) -> Reported:
        """The torque on the driven body, never negative; with a capacity it is a measure."""
        return (("torque", "N m", self._torque()),) if self.capacity is None else ()

    def measures(self, bodies: Bodies) -> Measures:
        """θ, its rate, and with a capacity the torque on the driven body, from 0 to T_c."""
        found = measures.along_scalar(self.angle, "rad", self._torque())
        return found[:2] if self.capacity is None else found

    def _torque(self) -> sympy.Expr:
        if self.capacity is None:
            return side(self.name) * self._scale()
        return sympy.Piecewise((self.capacity, SPEED < 0), (0, True))

    def _scale(self) -> sympy.Expr:
        given = (body.inertia for body in self.bodies)
        inertias = [one for one in given if one is not None and measures.is_constant(one)]
        return sympy.Float(TYPICAL) * (sympy.Add(*inertias) if inertias else sympy.S.One)

    def shapes(self) -> shapes.Shapes:
        """A round sign between two bodies."""
        return (shapes.SpiralSpring(self.i, self.j, elastic=False, damper=True, pushes=True),)


@element
class ElasticBelt(Pulleys, GapSprings):
    """A belt that stretches runs round two pulleys; a strand that would push goes slack.

    Tensions T0 ± (k u + c u̇), never below 0, with u = R_j (φ_j - φ_c) - R_i (φ_i - φ_c) - s0.

    One strand stretches by u, the other by -u. The pulleys turn in bearings of the carrier c, the
    ground or an arm that turns; for a crossed belt R_i is negative in the stretch. k = E A/L is the
    stiffness of one strand, N/m, and T0 the tension of both when the belt is idle. A strand is
    slack where it is shorter by T0/k or more than in the idle belt. A slack strand exerts no force,
    nor does one whose damper would push. Both changes are events of a run.

    R_j times the difference of the tensions turns pulley j back, and R_i times the difference turns
    pulley i. The sum of the tensions loads the carrier. This load, creep and slip are not modelled.
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


@element
class GearWithBacklash(WheelPair, GapSprings):
    """Two gears whose teeth have backlash and are elastic.

    f = k (u ∓ b/2) + c u̇ where |u| > b/2, with u = R_i (φ_i - φ_c) + R_j (φ_j - φ_c) - s0.

    u is the relative motion of the teeth along the pitch circles, m, from the middle of the
    backlash b. A stiffness k and a damping c act on each flank. They never pull: a damper that
    would pull is cut off. Contact and its end are events of a run, and between the flanks nothing
    acts. The gears turn in bearings of the carrier c, the ground or an arm that turns; an internal
    gear has a negative radius.

    -R_i f turns gear i and -R_j f gear j. There is no pressure angle: the force along the line of
    centres and the shift of the pitch point are not modelled. For rigid teeth without play see
    gear.
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

    def conditions(self) -> Conditions:
        """Radii of two pitch circles."""
        product = self.radius_i * self.radius_j
        text = "the radii ({1:g}, {2:g}) m contain a 0; give the radii of the pitch circles."
        return (Condition(text, (product**2, self.radius_i, self.radius_j), open=True),)

    def shapes(self) -> shapes.Shapes:
        """Two toothed wheels."""
        return toothed_wheels((self.i, self.radius_i), (self.j, self.radius_j))
