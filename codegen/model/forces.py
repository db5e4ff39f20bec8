"""The effects of a declaration: everything that pushes, pulls or turns."""

from collections.abc import Mapping
from typing import Any, Literal

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect
from codegen.declare.symbols import Coordinate
from codegen.elements.forces.applied import AppliedForce, AppliedTorque
from codegen.elements.forces.expression import GeneralizedForce, Potential
from codegen.elements.forces.gravity import Gravity
from codegen.model.base import Declarations


class Forces(Declarations):
    """What acts on bodies."""

    def gravity(self, name: str, g: tuple[Any, Any]) -> Effect:
        """Uniform gravity (g_x, g_y), m/s², on every body of the scene."""
        gx, gy = (self._read.value(a, "m/s^2", f"gravity '{name}'") for a in g)
        return self._effect(Gravity(name, gx, gy))

    def force(
        self,
        name: str,
        on: Point | Body,
        fx: Any = 0,
        fy: Any = 0,
        when: Any = None,
        frame: Literal["ground", "body"] = "ground",
    ) -> Effect:
        """A force (fx, fy) in N at a point, while the condition `when` holds."""
        fx, fy = (self._read.gated(f, "N", f"force '{name}'", when) for f in (fx, fy))
        point = self._point(name, on)
        frame = self._read.choice(frame, ("ground", "body"), f"force '{name}', frame")
        return self._effect(AppliedForce(name, point, fx, fy, frame))

    def torque(self, name: str, on: Body, value: Any, when: Any = None) -> Effect:
        """A torque in N m on a body, while the condition `when` holds."""
        gated = self._read.gated(value, "N m", f"torque '{name}'", when)
        return self._effect(AppliedTorque(name, on, gated))

    def potential(self, name: str, energy: Any) -> Effect:
        """A potential energy V(q) in J, as a plain expression."""
        v = self._read.value(energy, "J", f"potential '{name}'")
        return self._effect(Potential(name, v, self._bodies_in(v)))

    def generalized_force(
        self, name: str, components: Mapping[Any, Any], when: Any = None
    ) -> Effect:
        """Generalized forces Q: coordinate → plain expression (N for lengths, N m for angles)."""
        pairs = []
        for coordinate, force in components.items():
            if not isinstance(coordinate, Coordinate):
                self._note(f"force '{name}': {coordinate!r} is no coordinate; write body.x.")
                continue
            unit = "N m" if coordinate.name.endswith("_phi") else "N"
            pairs.append((coordinate, self._read.gated(force, unit, f"force '{name}'", when)))
        bodies = self._bodies_in(*(coordinate for coordinate, _ in pairs))
        return self._effect(GeneralizedForce(name, tuple(pairs), bodies))
