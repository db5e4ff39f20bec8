"""The declaration of a machine: bodies, parameters, joints, drivers, effects and scenes.

A declaration never raises for a wrong element: every problem is noted, and `build` reports all
of them at once (`codegen.check`).
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from codegen.declare import quantities
from codegen.declare.body import Body, Ground, Point
from codegen.declare.element import Constraint, Effect
from codegen.declare.names import name_problem
from codegen.declare.parameter import ParameterDeclaration, SignRule
from codegen.declare.reading import Reader
from codegen.declare.scene import Analysis, Scene
from codegen.declare.scene_values import UNITS, Names, Values, named, overrides, states
from codegen.declare.symbols import Coordinate, Parameter, Velocity, kinds
from codegen.elements.drivers.motion import Motion
from codegen.elements.forces.applied import AppliedForce, AppliedTorque
from codegen.elements.forces.expression import GeneralizedForce, Potential
from codegen.elements.forces.gravity import Gravity
from codegen.elements.joints.absolute import Absolute
from codegen.elements.joints.expression import ExpressionConstraint
from codegen.elements.joints.revolute import Revolute
from codegen.elements.joints.revolute_revolute import RevoluteRevolute
from codegen.elements.joints.translational import Translational


class Model:
    """A planar machine.

    Parameters
    ----------
    name
        An identifier; begins the names of the generated files.
    gravity
        (g_x, g_y) in m/s²; declares the effect ``"gravity"``. Other gravities: `Model.gravity`.

    Examples
    --------
    >>> model = Model("pendulum", gravity=(0, -9.81))
    >>> bob = model.body("bob", mass=1.0, inertia=0.1)
    >>> hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    >>> swing = model.scene("swing", effects=["gravity"], start={"bob.phi": 0})
    """

    def __init__(self, name: str, gravity: tuple[Any, Any] | None = None) -> None:
        self.name = name
        self.token = object()
        self.ground = Ground("ground", None, None, self.token)
        self.bodies: dict[str, Body] = {}
        self.parameters: dict[str, ParameterDeclaration] = {}
        self.joints: dict[str, Constraint] = {}
        self.drivers: dict[str, Constraint] = {}
        self.effects: dict[str, Effect] = {}
        self.scenes: dict[str, Scene] = {}
        self.files: list[Path] = []
        self._read = Reader()
        self._kinds: dict[str, str] = {"ground": "body"}
        if problem := name_problem("model", name):
            self._note(problem)
        if gravity is not None:
            self.gravity("gravity", gravity)

    # -- bodies and parameters ---------------------------------------------------------------

    def body(self, name: str, mass: Any = None, inertia: Any = None) -> Body:
        """A rigid body with its centre of mass at its origin.

        Parameters
        ----------
        name
            An identifier.
        mass, inertia
            Numbers in kg and kg m², pint quantities, parameters or expressions of them; may be
            left out where only kinematic scenes use the body.
        """
        values = []
        for value, unit, word in ((mass, "kg", "mass"), (inertia, "kg m^2", "inertia")):
            known = len(self.problems)
            read = self._read.value(value, unit, f"{word} of body '{name}'")
            values.append(read if len(self.problems) == known else None)
            if isinstance(values[-1], Parameter) and values[-1].name in self.parameters:
                declared = self.parameters[values[-1].name]
                self.parameters[declared.name] = replace(declared, sign="positive")
        body = Body(str(name), values[0], values[1], self.token)
        if self._claim("body", name):
            self.bodies[name] = body
        return body

    def parameter(
        self,
        name: str,
        value: Any,
        unit: str = "",
        sign: SignRule = "",
    ) -> Parameter:
        """A number that runs may change without a new build.

        Parameters
        ----------
        name
            An identifier.
        value
            The default: a number in `unit`, or a pint quantity that converts to it.
        unit
            A label in SI units such as ``"kg m^2"``; empty for a pure number. Values given at run
            time are in it.
        sign
            A rule that every value must obey; masses and inertias are positive by themselves.
        """
        symbol = Parameter(str(name), real=True)
        where = f"parameter '{name}'"
        unit = " ".join(unit.split())
        sign = self._read.choice(sign, ("", "positive", "nonnegative"), f"{where}, sign")
        if not quantities.known_unit(unit):
            self._note(f"{where}: the unit {unit!r} is not known; use SI names, 'kg m^2'.")
            unit = ""
        elif (factor := quantities.si_factor(unit)) != 1.0:
            self._note(
                f"{where}: {unit!r} is no SI unit (one of it is {factor:g} in SI); label the "
                f"parameter with the SI unit, and give the value as a quantity in {unit}."
            )
            unit = ""
        number = self._read.number(value, unit, where)
        if self._claim("parameter", name):
            self.parameters[name] = ParameterDeclaration(name, number, unit, sign)
        return symbol

    def depends_on(self, path: str | Path) -> Path:
        """Name a data file that the declaration reads: a change of it makes builds stale."""
        file = Path(path).resolve()
        if file.is_file():
            self.files.append(file)
        else:
            self._note(f"depends_on('{path}'): there is no file {file}.")
        return file

    # -- joints ------------------------------------------------------------------------------

    def revolute(self, name: str, i: Point, j: Point) -> Constraint:
        """Points `i` and `j` of two bodies coincide."""
        return self._joint(Revolute(name, *self._pair(name, i, j)))

    def translational(
        self,
        name: str,
        i: Point | Body,
        j: Point | Body,
        axis: tuple[Any, Any] = (1, 0),
        angle: Any = 0,
    ) -> Constraint:
        """Body `j` slides along `axis` of body `i`.

        Parameters
        ----------
        i, j
            Points on the line; a body means its centre of mass.
        axis
            Direction in the frame of body `i`.
        angle
            φ_j - φ_i, rad.
        """
        ax, ay = (self._read.value(a, "m", f"axis of '{name}'") for a in axis)
        offset = self._read.value(angle, "rad", f"angle of '{name}'")
        return self._joint(Translational(name, *self._pair(name, i, j), (ax, ay), offset))

    def revolute_revolute(
        self, name: str, i: Point, j: Point, length: Any, instead_of: Body | None = None
    ) -> Constraint:
        """A massless link of `length` between two points.

        With `instead_of`, the link acts in those scenes that leave this body out.
        """
        span = self._read.value(length, "m", f"length of '{name}'")
        return self._joint(RevoluteRevolute(name, *self._pair(name, i, j), span, instead_of))

    def absolute(
        self, name: str, on: Point | Body, letter: Literal["x", "y", "phi"], value: Any
    ) -> Constraint:
        """A point's global x or y, or a body's φ, keeps `value`."""
        letter = self._read.choice(letter, ("x", "y", "phi"), f"absolute '{name}'")
        number = self._read.value(value, UNITS[letter], f"value of '{name}'")
        point = self._point(name, on)
        return self._joint(Absolute(name, self.ground, point, letter, number))

    def constraint(self, name: str, *phi: Any) -> Constraint:
        """Plain equations: each expression of coordinates, parameters and t is held at zero."""
        equations = tuple(self._read.value(e, "", f"constraint '{name}'") for e in phi)
        return self._joint(ExpressionConstraint(name, equations, self._bodies_in(*equations)))

    def driver(self, name: str, driven: Any, law: Any) -> Constraint:
        """A coordinate, or any expression of coordinates, follows `law`, an expression of t."""
        left = self._read.value(driven, "", f"driver '{name}'")
        unit = UNITS[left.name.rpartition("_")[2]] if isinstance(left, Coordinate) else ""
        right = self._read.value(law, unit, f"law of driver '{name}'")
        element = Motion(name, left, right, self._bodies_in(left))
        if self._claim("driver", name):
            self.drivers[name] = element
        return element

    # -- effects -----------------------------------------------------------------------------

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

    def add(self, element: Constraint | Effect) -> Constraint | Effect:
        """An element of one's own: anything that answers `Constraint` or `Effect`."""
        if isinstance(element, Constraint):
            return self._joint(element)
        given: object = element
        if isinstance(given, Effect):
            return self._effect(given)
        self._note(
            f"model.add({element!r}): neither a Constraint nor an Effect; it needs kind, name, "
            "bodies, problems(), and statement() or potential() and forces()."
        )
        return element

    # -- scenes ------------------------------------------------------------------------------

    def scene(
        self,
        name: str,
        effects: Names = (),
        drivers: Names = (),
        *,
        without: Names = (),
        start: Values | None = None,
        guess: Values | None = None,
        parameters: Values | None = None,
        frozen: bool = False,
        analysis: Analysis = "dynamics",
    ) -> Scene:
        """Name what takes part in a question asked of the machine.

        Parameters
        ----------
        name
            An identifier.
        effects, drivers
            What acts, by name or by the object that its declaration returned.
        without
            Bodies that do not take part; joints and effects on them go with them.
        start
            Values that must hold at the beginning: ``{"crank.phi": π, "crank.omega": 30}``.
        guess
            Values from which assembly starts; what is named nowhere starts from 0.
        parameters
            Values that replace the declared defaults in this scene.
        frozen
            Fold the parameters into the code.
        analysis
            ``"kinematics"`` compiles neither masses nor forces.
        """
        where = f"scene '{name}'"
        absent = named(self._read, where, "body", without, self.bodies)
        scene = Scene(
            name=name,
            bodies=tuple(b for b in self.bodies if b not in absent),
            effects=named(self._read, where, "effect", effects, self.effects),
            drivers=named(self._read, where, "driver", drivers, self.drivers),
            start=states(self._read, where, self.bodies, start or {}),
            guess=states(self._read, where, self.bodies, guess or {}),
            parameters=overrides(self._read, where, self.parameters, parameters or {}),
            frozen=frozen,
            analysis=self._read.choice(analysis, ("dynamics", "kinematics"), f"{where}, analysis"),
        )
        if problem := name_problem("scene", name):
            self._note(problem)
        elif name in self.scenes:
            self._note(f"{where} is declared twice; give each scene its own name.")
        else:
            self.scenes[name] = scene
        return scene

    # -- helpers -----------------------------------------------------------------------------

    @property
    def problems(self) -> tuple[str, ...]:
        """What is wrong with the declaration so far; one sentence each."""
        return tuple(self._read.problems)

    def _note(self, problem: str) -> None:
        self._read.problems.append(problem)

    def _claim(self, kind: str, name: object) -> bool:
        if problem := name_problem(kind, name):
            self._note(problem)
            return False
        assert isinstance(name, str)
        if name in self._kinds:
            self._note(
                f"{kind} '{name}': the name is already that of a {self._kinds[name]}; "
                "give every element its own name."
            )
            return False
        self._kinds[name] = kind
        return True

    def _joint(self, element: Constraint) -> Constraint:
        if self._claim("joint", element.name):
            self.joints[element.name] = element
        return element

    def _effect(self, element: Effect) -> Effect:
        if self._claim("effect", element.name):
            self.effects[element.name] = element
        return element

    def _point(self, name: str, place: Any) -> Point:
        point = place.at(0, 0) if isinstance(place, Body) else place
        if not isinstance(point, Point):
            self._note(f"'{name}': {place!r} is neither a point nor a body; write body.at(x, y).")
            point = self.ground.at(0, 0)
        where = f"point of '{name}' on body '{point.body.name}'"
        sx, sy = (self._read.value(s, "m", where) for s in (point.sx, point.sy))
        return Point(point.body, sx, sy)

    def _pair(self, name: str, i: Any, j: Any) -> tuple[Point, Point]:
        return self._point(name, i), self._point(name, j)

    def _bodies_in(self, *expressions: Any) -> tuple[Body, ...]:
        owners = {
            s.name.rpartition("_")[0] for e in expressions for s in kinds(e, Coordinate, Velocity)
        }
        return tuple(body for name, body in self.bodies.items() if name in owners)
