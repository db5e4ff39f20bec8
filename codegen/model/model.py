"""The declaration of a machine: bodies, parameters, joints, drivers, effects and scenes.

A declaration never raises for a wrong element: every problem is noted, and `build` reports all
of them at once (`codegen.check`).
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from codegen.declare import quantities
from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.declare.interpolant import TableFunction, point_problems
from codegen.declare.names import name_problem
from codegen.declare.parameter import ParameterDeclaration, SignRule
from codegen.declare.scene import Analysis, Scene
from codegen.declare.scene_values import Names, Values, named, overrides, states
from codegen.declare.symbols import Parameter
from codegen.model.cams import Cams
from codegen.model.drivers import Drivers
from codegen.model.forces import Forces
from codegen.model.joints import Joints
from codegen.tables import fit


class Model(Joints, Cams, Drivers, Forces):
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
        super().__init__(name)
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

    def table(
        self,
        name: str,
        x: Sequence[Any],
        y: Sequence[Any],
        periodic: bool = False,
        units: tuple[str, str] = ("", ""),
    ) -> TableFunction:
        """A function through points, by a cubic spline with continuous second derivatives.

        Called with an expression, ``lift(cam.phi)`` or ``law(t)``, it may stand in motion laws,
        profiles, forces and constraints, with the derivatives that γ needs.

        Parameters
        ----------
        name
            An identifier.
        x, y
            At least four points, x strictly ascending: numbers in `units`, or pint quantities.
        periodic
            Whether the function repeats; the last point is the first one, a period later. One
            that does not repeat is undefined beyond its ends, where a run stops and says so.
        units
            SI units of x and y.
        """
        where = f"table '{name}'"
        at, values = (
            [self._read.finite(v, unit, f"{where}, {axis}[{k}]") for k, v in enumerate(given)]
            for given, unit, axis in ((x, units[0], "x"), (y, units[1], "y"))
        )
        known = len(self.problems)
        for problem in point_problems(at, values, periodic):
            self._note(f"{where}: {problem}")
        if self._claim("table", name) and len(self.problems) == known:
            return TableFunction(fit(name, at, values, periodic))
        return TableFunction(fit("none", (0.0, 1.0, 2.0, 3.0), (0.0,) * 4, periodic=False))

    def depends_on(self, path: str | Path) -> Path:
        """Name a data file that the declaration reads: a change of it makes builds stale."""
        file = Path(path).resolve()
        if file.is_file():
            self.files.append(file)
        else:
            self._note(f"depends_on('{path}'): there is no file {file}.")
        return file

    # -- elements of one's own ---------------------------------------------------------------

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
            Bodies that do not take part, with the joints and effects on them; or joints alone.
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
        absent = named(self._read, where, "body or joint", without, self.bodies | self.joints)
        scene = Scene(
            name=name,
            bodies=tuple(b for b in self.bodies if b not in absent),
            effects=named(self._read, where, "effect", effects, self.effects),
            drivers=named(self._read, where, "driver", drivers, self.drivers),
            opened=tuple(name for name in absent if name in self.joints),
            start=states(self._read, where, self._coordinates(), start or {}),
            guess=states(self._read, where, self._coordinates(), guess or {}),
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
