"""The machine elements that pass rotation on: motors, belts, screws, clutches."""

from typing import Any

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.elements.forces.elastic_belt import ElasticBelt
from codegen.elements.forces.gear_with_backlash import GearWithBacklash
from codegen.elements.forces.motor import Motor
from codegen.elements.forces.one_way_clutch import OneWayClutch
from codegen.elements.joints.belt import Belt
from codegen.elements.joints.rack_and_pinion import RollingDisc
from codegen.elements.joints.screw import Screw
from codegen.model.base import Declarations, Pair, Place, declares


class Transmissions(Declarations):
    """Motors and transmissions of a declaration."""

    @declares(Motor, i="from_", j="on")
    def motor(
        self, name: str, on: Body, from_: Body | None = None, *, stall_torque: Any,
        no_load_speed: Any, voltage: Any = 1,
    ) -> Effect:  # fmt: skip
        """A motor whose torque falls in a straight line with its speed, T = T_s (u - ω/ω_0).

        Parameters
        ----------
        on
            The rotor, on which T acts.
        from_
            The stator, on which -T acts; None: the ground. ω = φ̇_on - φ̇_from.
        stall_torque, no_load_speed
            T_s in N m and ω_0 in rad/s, at the rated voltage, both positive.
        voltage
            u, the voltage as a multiple of the rated one: any expression of t, q, q̇ and
            parameters.
        """

    @declares(Belt)
    def belt(
        self, name: str, i: Body, j: Body, radius_i: Any, radius_j: Any, *,
        carrier: Body | None = None, crossed: bool = False, offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """A belt or chain that neither stretches nor slips couples two pulleys.

        Parameters
        ----------
        i, j
            The pulleys.
        radius_i, radius_j
            Their radii, m, both positive.
        carrier
            The body that carries the bearings of both; None: the ground.
        crossed
            Whether the belt is crossed, and turns the pulleys in opposite directions.
        offset
            s0 in m: R_j (φ_j - φ_c) - R_i (φ_i - φ_c) as the belt was laid on. Crossed, R_i counts
            as negative.
        """

    @declares(ElasticBelt)
    def elastic_belt(
        self, name: str, i: Body, j: Body, radius_i: Any, radius_j: Any, *, stiffness: Any,
        damping: Any = 0, pretension: Any = 0, carrier: Body | None = None, crossed: bool = False,
        offset: Any = 0,
    ) -> Effect:  # fmt: skip
        """A belt or chain of two strands that stretch, and pull only, couples two pulleys.

        Parameters
        ----------
        i, j
            The pulleys.
        radius_i, radius_j
            Their radii, m, both positive.
        stiffness, damping
            k = E A/L in N/m and c in N s/m of one strand.
        pretension
            T0 in N, the tension of both strands when the belt is idle.
        carrier
            The body that carries the bearings of both; None: the ground.
        crossed
            Whether the belt is crossed, and turns the pulleys in opposite directions.
        offset
            R_j (φ_j - φ_c) - R_i (φ_i - φ_c) of the idle belt, m. Crossed, R_i counts as negative.
        """

    @declares(GearWithBacklash)
    def gear_with_backlash(
        self, name: str, i: Body, j: Body, radius_i: Any, radius_j: Any, *, backlash: Any,
        stiffness: Any, damping: Any = 0, carrier: Body | None = None, offset: Any = 0,
    ) -> Effect:  # fmt: skip
        """Two gears whose teeth bear by a spring and a damper on either flank, with play between.

        Parameters
        ----------
        i, j
            The gears.
        radius_i, radius_j
            Radii of the pitch circles, m; negative for an internal gear.
        backlash
            b, the play along the pitch circles from flank to flank, m.
        stiffness, damping
            k in N/m and c in N s/m of the teeth, along the pitch circles.
        carrier
            The body that carries the bearings of both; None: the ground.
        offset
            R_i (φ_i - φ_c) + R_j (φ_j - φ_c) in the middle of the backlash, m.
        """

    @declares(Screw)
    def screw(
        self, name: str, frame: Place, nut: Place, spindle: Body, lead: Any, axis: Pair = (1, 0),
        offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """A nut travels along an axis by `lead` for each turn of a spindle.

        Parameters
        ----------
        frame
            A point of the body in which the spindle turns, on the axis of travel.
        nut
            A point of the nut; a body means its centre of mass.
        spindle
            The body that turns: the spindle's wheel, or its motor.
        lead
            h, the travel of one turn, m; negative for a left-hand thread.
        axis
            Direction of travel in the frame of `frame`.
        offset
            How far along `axis` the nut lies from `frame`, m, where both bodies have the same φ.
        """

    @declares(RollingDisc)
    def rolling_disc(
        self, name: str, disc: Place, line: Place, radius: Any, axis: Pair = (1, 0),
        offset: Any = 0,
    ) -> Constraint:  # fmt: skip
        """A disc rolls along a line of another body without slip.

        Parameters
        ----------
        disc
            The disc's centre; a body means its centre of mass.
        line
            A point on the line; a body means its centre of mass.
        radius
            The disc's radius, m.
        axis
            Direction of the line in the frame of its body; the disc lies to the left of it.
        offset
            How far along `axis` the centre lies from `line`, m, where both bodies have the same φ.
        """

    @declares(OneWayClutch, i="driver", j="driven")
    def one_way_clutch(self, name: str, driver: Body, driven: Body, capacity: Any = None) -> Effect:
        """A freewheel: `driver` turns `driven` counter-clockwise, which may overrun it.

        It is rigid: while it grips, both have one speed, and where something would make the driver
        faster at an instant, as a start or the impact of a contact, an impact gives them one.

        Parameters
        ----------
        driver, driven
            The bodies i and j of ω_j - ω_i ≥ 0; for a clutch that drives clockwise exchange them.
        capacity
            T_c in N m, the torque at which the clutch slips; None: it never does.
        """
