"""The machine elements that pass rotation on: motors, belts, screws, clutches."""

from typing import Any

from codegen.declare.body import Body
from codegen.declare.element import Effect
from codegen.elements.forces.motor import Motor
from codegen.model.base import Declarations


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
