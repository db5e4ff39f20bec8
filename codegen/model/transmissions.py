"""The machine elements that pass rotation on: motors, belts, screws, clutches."""

from types import MappingProxyType
from typing import Any

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.declare.symbols import SignRule
from codegen.elements.forces.elastic_belt import ElasticBelt
from codegen.elements.forces.gear_with_backlash import GearWithBacklash
from codegen.elements.forces.motor import Motor
from codegen.elements.forces.one_way_clutch import OneWayClutch
from codegen.elements.joints.belt import Belt
from codegen.elements.joints.rolling_disc import RollingDisc
from codegen.elements.joints.screw import Screw
from codegen.model.base import Declarations, Pair, Place


class Transmissions(Declarations):
    """Motors and transmissions of a declaration."""

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
        where = f"motor '{name}'"
        advice = "a motor turns a rotor against a stator."
        rotor = self._body(where, on, advice)
        stator = self.ground if from_ is None else self._body(where, from_, advice)
        stall = self._value(stall_torque, "N m", f"stall torque of {where}", "positive")
        speed = self._value(no_load_speed, "rad/s", f"no-load speed of {where}", "positive")
        share = self._value(voltage, "", f"voltage of {where}")
        return self._declare(Motor(name, stator, rotor, stall, speed, share))

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
        where = f"belt '{name}'"
        wheels, (start, joints) = self._wheels(where, i, j, carrier, radius_i, radius_j, offset)
        turned = self._read.flag(crossed, f"{where}: crossed")
        return self._declare(Belt(name, *wheels, turned, start, joints))

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
        where = f"elastic belt '{name}'"
        wheels, laid = self._wheels(where, i, j, carrier, radius_i, radius_j, offset)
        turned = self._read.flag(crossed, f"{where}: crossed")
        k = self._value(stiffness, "N/m", f"stiffness of {where}", "positive")
        c = self._value(damping, "N s/m", f"damping of {where}")
        tension = self._value(pretension, "N", f"pretension of {where}")
        return self._declare(ElasticBelt(name, *wheels, turned, k, c, tension, *laid))

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
        where = f"gear with backlash '{name}'"
        wheels, laid = self._wheels(where, i, j, carrier, radius_i, radius_j, offset, sign="")
        play = self._value(backlash, "m", f"backlash of {where}")
        k = self._value(stiffness, "N/m", f"stiffness of {where}", "positive")
        c = self._value(damping, "N s/m", f"damping of {where}")
        return self._declare(GearWithBacklash(name, *wheels, play, k, c, *laid))

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
        where = f"screw '{name}'"
        ends = self._pair(name, frame, nut)
        turned = self._body(where, spindle, "a spindle turns as a whole.")
        rise = self._value(lead, "m", f"lead of {where}")
        line = self._read.axis(axis, name)
        start = self._value(offset, "m", f"offset of {where}")
        return self._declare(Screw(name, *ends, turned, rise, line, start))

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
        size = self._value(radius, "m", f"radius of '{name}'")
        along = self._read.axis(axis, name)
        start = self._value(offset, "m", f"offset of '{name}'")
        return self._declare(RollingDisc(name, *self._pair(name, disc, line), size, along, start))

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
        where = f"one-way clutch '{name}'"
        advice = "a clutch couples two bodies that turn."
        first, second = (self._body(where, body, advice) for body in (driver, driven))
        most = self._optional(capacity, "N m", f"capacity of {where}", "positive")
        return self._declare(OneWayClutch(name, first, second, most))

    def _wheels(
        self, where: str, i: Any, j: Any, carrier: Any, radius_i: Any, radius_j: Any, offset: Any,
        sign: SignRule = "positive",
    ) -> tuple[tuple[Body, Body, Body, Any, Any], tuple[Any, Any]]:  # fmt: skip
        """Two wheels, what carries them, the ground unless given, their radii; offset and joints.

        `sign` is that of the radii.
        """
        advice = "it couples bodies that turn, wherever their bearings are."
        first, second = (self._body(where, body, advice) for body in (i, j))
        advice = "carrier is the body that carries the bearings."
        arm = self.ground if carrier is None else self._body(where, carrier, advice)
        one, other = (self._value(r, "m", f"radius of {where}", sign) for r in (radius_i, radius_j))
        start = self._value(offset, "m", f"offset of {where}")
        return (first, second, arm, one, other), (start, MappingProxyType(self.joints))
