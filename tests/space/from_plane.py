"""Planar machines declared again in space, in a plane at any angle and place.

The plane's axes x and y, and its normal, are the columns of a rotation matrix. A body's z' axis is
the normal, so that its x' and y' axes are those that it has in the plane. A particle is a body
whose spin nothing turns. An angle in a sine or a cosine is that of the body's axes; any other is
the sum of the angles of joints from the ground on, counted through turns. Joints of the plane that
space does not have are their own equations there.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import sympy
from sympy import cos, sin

import linkwright as lw
from codegen import Model
from codegen.declare.body import Body, Particle, Point
from codegen.declare.scene import Scene
from codegen.elements import drivers
from codegen.elements.forces import applied, contacts, springs, transmissions
from codegen.elements.joints import guides, points

NORMAL = (0, 0, 1)
KEEPERS = (
    points.Revolute, guides.Translational, guides.RevoluteTranslational, points.RevoluteRevolute,
)  # fmt: skip
"""Joints that keep their bodies in one plane in space, too; a distance does not."""


class UntranslatableError(NotImplementedError):
    """An element or a value of the plane for which space has none."""


@lw.element
class OwnEquations(lw.Constraint):
    """Equations with coordinates of a joint's own, such as the place of a contact on a cam."""

    kind = "equations of the plane"
    name: str
    phi: tuple[sympy.Expr, ...]
    rows: tuple[str, ...]
    own: Any
    on: tuple[lw.SpaceBody, ...]

    def statement(self) -> lw.Statement:
        """The equations as they stand."""
        forces = tuple((row, "") for row in self.rows)
        return lw.Statement(self.phi, self.rows, lw.ConjugateReaction(forces), {}, self.own)


class Translation:
    """A scene of a planar model in space.

    Parameters
    ----------
    plane, scene
        The model, and the scene.
    q
        Coordinate (``"crank.phi"``) → value at the drawing, at which all joints are closed.
    turn, origin
        (3, 3), the axes of the plane; (3,), the place of its origin, m.
    """

    def __init__(
        self, plane: Model, scene: Scene, q: Mapping[str, float], turn: Any, origin: Any = (0, 0, 0)
    ) -> None:
        self.plane, self.scene, self.q = plane, scene, q
        self.turn, self.origin = np.asarray(turn), np.asarray(origin, float)
        chosen = plane.defaults | {
            plane.parameters[name].symbol: value for name, value in scene.parameters
        }
        self._numbers = {symbol: sympy.Float(value) for symbol, value in chosen.items()}
        self.model: Any = Model(f"{plane.name}_{scene.name}_in_space", space=True)
        self.bodies: dict[str, Any] = {"ground": self.model.ground}
        self._symbols: dict[Any, Any] = {}
        for name in scene.bodies:
            self._body(plane.bodies[name])
        acting = acting_joints(plane, scene)
        self.edges = {joint.name: names_of(joint) for joint in acting if is_keeper(joint)}
        for joint in filter(is_keeper, acting):
            self._keeper(joint)
        for name in scene.bodies:
            if name not in reached(self.edges):
                self.edges[f"plane_{name}"] = "ground", name
                ends = self.model.ground.at(*self.origin), self.bodies[name].at(0, 0, 0)
                self.model.planar(f"plane_{name}", *ends, axis=tuple(self.turn[:, 2]))
        self._angles = self._counted_angles()
        for joint in acting:
            if not is_keeper(joint):
                self._joint(joint)
        for name, one in plane.connections.items():
            if name in self.model.joints:
                when, until = map(self._condition, (one.released, one.engaged))
                connect = self.model.release if one.acts_first else self.model.engage
                connect(name, *((when, until) if one.acts_first else (until, when)))
        for name in scene.states:
            self._state(plane.states[name])
        for name in scene.drivers:
            self._driver(plane.drivers[name])
        self.effects = [one for name in scene.effects for one in self._effect(name)]
        until = {one.name: self._condition(one.indicator) for one in scene.until}
        words = {"analysis": scene.analysis, "until": until or None}
        self.model.scene(scene.name, self.effects, [*self.model.drivers], **words)

    @property
    def loops(self) -> int:
        """How many loops the joints that keep bodies in the plane close."""
        return len(self.edges) - len(self.scene.bodies)

    @property
    def in_loops(self) -> set[str]:
        """The joints in these loops."""
        without = {name: {n: e for n, e in self.edges.items() if n != name} for name in self.edges}
        return {name for name, ends in self.edges.items() if {*ends} <= reached(without[name])}

    @property
    def spins(self) -> int:
        """How many bodies are particles in the plane."""
        return sum(not self.plane.bodies[name].turns for name in self.scene.bodies)

    def _body(self, body: Body) -> None:
        if body.mass is None or body.laws:
            raise UntranslatableError(f"body {body.name} has no mass, or one that varies")
        m = self.number(body.mass)
        J = m if isinstance(body, Particle) else self.number(body.inertia)
        x, y, phi = (self.q.get(f"{body.name}.{c}", 0.0) for c in ("x", "y", "phi"))
        A = self.turn @ turned(phi)
        self.bodies[body.name] = made = self.model.body(
            body.name, m, (0.4 * J, 0.8 * J, J), at=tuple(self.origin + self.turn @ (x, y, 0.0)),
            axes=(tuple(A[:, 0]), tuple(A[:, 1])),
        )  # fmt: skip
        across = sympy.Matrix(self.turn.T)
        places = across * (sympy.Matrix(made.position) - sympy.Matrix(self.origin))
        rates, axis = across * sympy.Matrix(made.velocity), across * made.A[:, 0]
        self._symbols |= {
            body.x: places[0], body.y: places[1], body.vx: rates[0], body.vy: rates[1],
            body.omega: made.omega_z, cos(body.phi): axis[0], sin(body.phi): axis[1],
        }  # fmt: skip

    def number(self, value: Any) -> float:
        return float(sympy.sympify(value).xreplace(self._numbers))

    def value(self, expression: Any) -> sympy.Expr:
        """An expression of the plane, in coordinates of space."""
        given = sympy.sympify(expression).xreplace(self._numbers)
        angles = {self.plane.bodies[name].phi for name in self.scene.bodies}
        found: sympy.Expr = given.xreplace(self._symbols)
        if found.free_symbols & angles:  # of sums of angles
            found = sympy.expand_trig(given).xreplace(self._symbols)
        found = found.xreplace(self._angles)
        if left := found.free_symbols & angles:
            raise UntranslatableError(f"{given} contains {', '.join(sorted(map(str, left)))}")
        return found

    def _condition(self, indicator: Any) -> Any:
        """The condition that an expression of the plane is 1 under and else 0."""
        return None if indicator is None else self.value(indicator).args[0].cond

    def _counted_angles(self) -> dict[Any, sympy.Expr]:
        """φ → its value at the drawing, and the angles of joints on a way from the ground."""
        turns: dict[str, Any] = {"ground": sympy.S.Zero}
        for _ in self.edges:
            for name, (i, j) in self.edges.items():
                joint = self.model.joints[name]
                step = joint.angle if "angle" in joint.countable else sympy.S.Zero
                if (i in turns) != (j in turns):
                    turns |= {j: turns[i] + step} if i in turns else {i: turns[j] - step}
        turning = (body for body in map(self.plane.bodies.get, turns) if body and body.turns)
        return {body.phi: self.q[f"{body.name}.phi"] + turns[body.name] for body in turning}

    def at(self, point: Point) -> Any:
        """A point of a body."""
        place = np.array([self.number(s) for s in (point.sx, point.sy)] + [0.0])
        if point.body.fixed:
            return self.model.ground.at(*(self.origin + self.turn @ place))
        return self.bodies[point.body.name].at(*place)

    def along(self, body: Body, axis: Any) -> Any:
        """An axis of a body."""
        if body.fixed:
            return self.model.ground.along(*(self.turn @ axis))
        return self.bodies[body.name].along(*axis)

    def _keeper(self, joint: Any) -> None:
        ends = self.at(joint.i), self.at(joint.j)
        normals = tuple(self.along(p.body, NORMAL) for p in (joint.i, joint.j))
        match joint:
            case points.Revolute():
                self.model.revolute(joint.name, *ends, axis=normals)
            case points.RevoluteRevolute():
                length = self.number(joint.length)
                self.model.revolute_revolute(joint.name, *ends, length, axis=normals)
            case guides.Guide():
                axis = np.array([self.number(u) for u in joint.axis] + [0.0])
                if isinstance(joint, guides.RevoluteTranslational):
                    if joint.distance != 0:
                        raise UntranslatableError(f"{joint.name} keeps a distance from its line")
                    words = {"axis": self.along(joint.i.body, axis), "hinge": normals}
                    self.model.revolute_translational(joint.name, *ends, **words)
                    return
                back = turned(-self.number(joint.angle)) @ axis
                pairs = (joint.i.body, axis), (joint.j.body, back)
                both = tuple(self.along(*pair) for pair in pairs)
                self.model.translational(joint.name, *ends, axis=both)

    def _joint(self, joint: Any) -> None:
        statement = joint.statement()
        if isinstance(joint, points.Distance):
            ends = self.at(joint.i), self.at(joint.j)
            self.model.distance(joint.name, *ends, self.number(joint.length))
            return
        phi = tuple(self.value(row.xreplace(statement.bindings)) for row in statement.phi)
        if statement.own:
            bodies = tuple(self.bodies[body.name] for body in joint.bodies)
            made = OwnEquations(joint.name, phi, statement.rows, statement.own, bodies)
            self.model.add(made)
            return
        self.model.constraint(joint.name, *phi)

    def _state(self, state: Any) -> None:
        words = {"start": state.start, "unit": state.unit, "nominal": state.nominal}
        if state.triggers:
            raise UntranslatableError(f"{state.name} is a latch")
        if state.clock is None:
            made = self.model.state(state.name, self.value(state.rate), **words)
        else:
            every, delay = (self.number(one) for one in (state.clock.every, state.clock.delay))
            sample = None if state.sample is None else self.value(state.sample)
            made = self.model.sampled(state.name, every, sample, delay, **words)
        self._symbols[state.symbol] = made

    def _driver(self, driver: Any) -> None:
        if not isinstance(driver, drivers.Motion):
            raise UntranslatableError(f"{driver.name} is a {driver.kind}")
        self.model.driver(driver.name, self.value(driver.driven), self.value(driver.law))

    def _vector(self, x: Any, y: Any) -> tuple[Any, ...]:
        return tuple(sympy.Matrix(self.turn) * sympy.Matrix([x, y, 0]))

    def _torque(self, name: str, on: Body, value: Any, from_: Body | None) -> Iterator[str]:
        """A torque about the normal on one body, and the opposite on another."""
        for body, sign, word in ((on, 1, name), (from_, -1, f"{name}_back")):
            if body is not None and not body.fixed:
                exerted = (0, 0, sign * self.value(value))
                self.model.torque(word, self.bodies[body.name], exerted, frame="body")
                yield word

    def _effect(self, name: str) -> Iterator[str]:
        """Declare an effect; its names in space."""
        effect: Any = self.plane.effects.get(name)
        if effect is None or effect.kind == "tracked point":
            return
        match effect:
            case applied.AppliedTorque():
                yield from self._torque(name, effect.body, effect.value, effect.from_)
                return
            case transmissions.Motor():
                speed = (effect.j.omega - effect.i.omega) / effect.no_load_speed
                torque = effect.stall_torque * (effect.voltage - speed)
                yield from self._torque(name, effect.j, torque, effect.i)
                return
            case applied.Gravity():
                g = [self.number(one) for one in effect.g]
                self.model.gravity(name, tuple(self.turn @ (*g, 0.0)))
            case applied.AppliedForce() if effect.from_ is None:
                fx, fy = self.value(effect.fx), self.value(effect.fy)
                own = effect.frame == "body"
                force = (fx, fy, 0) if own else self._vector(fx, fy)
                self.model.force(name, self.at(effect.point), force, frame=effect.frame)
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
                given = {word: self.number(one) for word, one in numbers.items()}
                given["actuator"] = self.value(effect.actuator)
                given = {word: one for word, one in given.items() if one != 0}
                self.model.spring(name, self.at(effect.i), self.at(effect.j), **given)
            case contacts.Contact():
                law = {"stiffness": effect.stiffness, "damping": effect.damping}
                words = {word: self.number(one) for word, one in law.items()}
                words["may_pull"] = effect.may_pull
                self.model.contact(name, gap=self.value(effect.gap), **words)
            case contacts.RigidContact() if not effect.limits:
                words = {"restitution": self.number(effect.restitution)}
                self.model.contact(name, gap=self.value(effect.gap), **words)
            case _:
                raise UntranslatableError(f"{name} is a {effect.kind}")
        yield name


def turned(angle: float) -> Any:
    """The rotation about the normal."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def is_keeper(joint: Any) -> bool:
    """Whether the joint keeps its bodies in one plane in space."""
    return isinstance(joint, KEEPERS) and not isinstance(joint, points.Distance)


def names_of(joint: Any) -> tuple[str, str]:
    """The names of the two bodies of a joint."""
    i, j = joint.i.body.name, joint.j.body.name
    return i, j


def reached(edges: Mapping[str, tuple[str, str]]) -> set[str]:
    """The bodies that a way of joints leads to from the ground."""
    found, before = {"ground"}, 0
    while len(found) > before:
        before = len(found)
        found |= {name for ends in edges.values() if {*ends} & found for name in ends}
    return found


def acting_joints(plane: Model, scene: Scene) -> list[Any]:
    """The joints of a scene: all bodies take part, except the one that a link stands for."""
    bodies = {*scene.bodies, "ground"}
    stands_for = (getattr(joint, "instead_of", None) for joint in plane.joints.values())
    return [
        joint for (name, joint), of in zip(plane.joints.items(), stands_for, strict=True)
        if name not in scene.inactive_joints and {b.name for b in joint.bodies} <= bodies
        and (of is None or of.name not in bodies)
    ]  # fmt: skip
