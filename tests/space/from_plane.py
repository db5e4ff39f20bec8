"""Planar machines declared again in space, in a plane at any angle.

The plane's axes x and y, and its normal, are the columns of a rotation matrix. A body's z' axis is
the normal, so that its x' and y' axes are those that it has in the plane.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import sympy
from sympy import cos, sin

from codegen import Model
from codegen.declare.body import Body, Particle, Point
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate
from codegen.elements import drivers
from codegen.elements.forces import applied, springs
from codegen.elements.joints import guides, points, weld

NORMAL = (0, 0, 1)


class UntranslatableError(NotImplementedError):
    """An element or a value of the plane for which space has none."""


class Translation:
    """A scene of a planar model in space.

    Parameters
    ----------
    plane, scene
        The model, and the name of the scene.
    q
        Coordinate (``"crank.phi"``) → value at the drawing, at which all joints are closed.
    turn
        (3, 3), the axes of the plane.
    """

    def __init__(self, plane: Model, scene: str, q: Mapping[str, float], turn: Any) -> None:
        self.plane, self.scene, self.turn = plane, plane.scenes[scene], np.asarray(turn)
        self.q = q
        chosen = plane.defaults | {
            plane.parameters[name].symbol: value for name, value in self.scene.parameters
        }
        self._numbers = {symbol: sympy.Float(value) for symbol, value in chosen.items()}
        self.model: Any = Model(f"{plane.name}_{scene}_in_space", space=True)
        self.bodies: dict[str, Any] = {}
        self._symbols: dict[Any, Any] = {}
        for name in self.scene.bodies:
            self._body(plane.bodies[name])
        for joint in acting_joints(plane, self.scene):
            self._joint(joint)
        for name in self.scene.drivers:
            self._driver(plane.drivers[name])
        self.effects = [one for name in self.scene.effects for one in self._effect(name)]
        self.model.scene(scene, self.effects, [*self.model.drivers])

    def _body(self, body: Body) -> None:
        if isinstance(body, Particle) or body.mass is None or body.laws:
            raise UntranslatableError(f"body {body.name} is a {type(body).__name__} or has no mass")
        J = self._number(body.inertia)
        x, y, phi = (self.q[f"{body.name}.{c}"] for c in ("x", "y", "phi"))
        A = self.turn @ turned(phi)
        self.bodies[body.name] = made = self.model.body(
            body.name, self._number(body.mass), (0.4 * J, 0.8 * J, J),
            at=tuple(self.turn @ (x, y, 0.0)), axes=(tuple(A[:, 0]), tuple(A[:, 1])),
        )  # fmt: skip
        across = sympy.Matrix(self.turn.T)
        places, rates = (across * sympy.Matrix(of) for of in (made.position, made.velocity))
        axis = across * made.A[:, 0]
        self._symbols |= {
            body.x: places[0], body.y: places[1], body.vx: rates[0], body.vy: rates[1],
            body.omega: made.omega_z, cos(body.phi): axis[0], sin(body.phi): axis[1],
        }  # fmt: skip

    def _number(self, value: Any) -> float:
        return float(sympy.sympify(value).xreplace(self._numbers))

    def value(self, expression: Any) -> sympy.Expr:
        """An expression of the plane, in coordinates of space."""
        given = sympy.sympify(expression).xreplace(self._numbers)
        angles = {self.plane.bodies[name].phi for name in self.bodies}
        found: sympy.Expr = given.xreplace(self._symbols)
        if found.free_symbols & angles:  # of sums of angles
            found = sympy.expand_trig(given).xreplace(self._symbols)
        if left := found.free_symbols & angles:
            raise UntranslatableError(f"{given} contains {', '.join(sorted(map(str, left)))}")
        return found

    def at(self, point: Point) -> Any:
        """A point of a body."""
        place = np.array([self._number(s) for s in (point.sx, point.sy)] + [0.0])
        if point.body.fixed:
            return self.model.ground.at(*(self.turn @ place))
        return self.bodies[point.body.name].at(*place)

    def along(self, body: Body, axis: Any) -> Any:
        """An axis of a body."""
        if body.fixed:
            return self.model.ground.along(*(self.turn @ axis))
        return self.bodies[body.name].along(*axis)

    def _joint(self, joint: Any) -> None:
        if isinstance(joint, points.ExpressionConstraint):
            self.model.constraint(joint.name, *map(self.value, joint.phi))
            return
        if isinstance(joint, points.Absolute | weld.Weld) or not hasattr(joint, "i"):
            raise UntranslatableError(f"joint {joint.name} is a {joint.kind}")
        ends = self.at(joint.i), self.at(joint.j)
        match joint:
            case points.Revolute():
                both = tuple(self.along(p.body, NORMAL) for p in (joint.i, joint.j))
                self.model.revolute(joint.name, *ends, axis=both)
            case guides.Translational():
                axis = np.array([self._number(u) for u in joint.axis] + [0.0])
                back = turned(-self._number(joint.angle)) @ axis
                pairs = (joint.i.body, axis), (joint.j.body, back)
                both = tuple(self.along(*pair) for pair in pairs)
                self.model.translational(joint.name, *ends, axis=both)
            case points.RevoluteRevolute():
                self.model.distance(joint.name, *ends, self._number(joint.length))
            case guides.RevoluteTranslational():
                self.model.constraint(joint.name, *map(self.value, equations(joint)))
            case _:
                raise UntranslatableError(f"joint {joint.name} is a {joint.kind}")

    def _driver(self, driver: Any) -> None:
        """A driver of an angle is sin(φ - law) = 0, of which the slope along φ is 1."""
        if not isinstance(driver, drivers.Motion):
            raise UntranslatableError(f"driver {driver.name} is a {driver.kind}")
        law = self.value(driver.law)
        if not (isinstance(driver.driven, Coordinate) and driver.driven.letter == "phi"):
            self.model.driver(driver.name, self.value(driver.driven), law)
            return
        c, s = (self.value(f(driver.driven)) for f in (cos, sin))
        self.model.constraint(driver.name, s * cos(law) - c * sin(law))

    def _vector(self, x: Any, y: Any) -> tuple[Any, ...]:
        return tuple(sympy.Matrix(self.turn) * sympy.Matrix([x, y, 0]))

    def _effect(self, name: str) -> Iterator[str]:
        """Declare an effect; its names in space."""
        effect: Any = self.plane.effects.get(name)
        if effect is None or effect.kind == "tracked point":
            return
        if getattr(effect, "from_", None) is not None:
            raise UntranslatableError(f"{name} acts from a body")
        match effect:
            case applied.Gravity():
                g = [self._number(one) for one in effect.g]
                self.model.gravity(name, tuple(self.turn @ (*g, 0.0)))
            case applied.AppliedForce():
                fx, fy = self.value(effect.fx), self.value(effect.fy)
                own = effect.frame == "body"
                force = (fx, fy, 0) if own else self._vector(fx, fy)
                self.model.force(name, self.at(effect.point), force, frame=effect.frame)
            case applied.AppliedTorque():
                value = (0, 0, self.value(effect.value))
                self.model.torque(name, self.bodies[effect.body.name], value, frame="body")
            case applied.Potential():
                self.model.potential(name, self.value(effect.energy))
            case applied.LineForce():
                ends = self.at(effect.i), self.at(effect.j)
                self.model.line_force(name, *ends, self.value(effect.value))
            case springs.Spring() if effect.law is None:
                numbers = {
                    "stiffness": effect.stiffness, "free_length": effect.free_length or 0,
                    "damping": effect.damping, "preload": effect.preload,
                }  # fmt: skip
                given = {word: self._number(one) for word, one in numbers.items()}
                given["actuator"] = self.value(effect.actuator)
                given = {word: one for word, one in given.items() if one != 0}
                self.model.spring(name, self.at(effect.i), self.at(effect.j), **given)
            case _:
                raise UntranslatableError(f"{name} is a {effect.kind}")
        yield name


def turned(angle: float) -> Any:
    """The rotation about the normal."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def equations(joint: Any) -> tuple[sympy.Expr, ...]:
    """Φ of a joint in the plane."""
    statement = joint.statement()
    return tuple(phi.xreplace(statement.bindings) for phi in statement.phi)


def acting_joints(plane: Model, scene: Scene) -> list[Any]:
    """The joints of a scene: all bodies take part, except the one that a link stands for."""
    bodies = {*scene.bodies, "ground"}
    stands_for = (getattr(joint, "instead_of", None) for joint in plane.joints.values())
    return [
        joint for (name, joint), of in zip(plane.joints.items(), stands_for, strict=True)
        if name not in scene.inactive_joints and {b.name for b in joint.bodies} <= bodies
        and (of is None or of.name not in bodies)
    ]  # fmt: skip
