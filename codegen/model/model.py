"""The declaration of a machine: bodies, parameters, joints, drivers, effects and scenes.

A declaration never raises for a wrong element: every problem is noted, and `build` reports all
of them at once (`codegen.check`).
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

from codegen.declare import quantities
from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.declare.names import name_problem
from codegen.declare.parameter import ParameterDeclaration, SignRule
from codegen.declare.scene import Analysis, Scene
from codegen.declare.scene_values import Names, Values, named, overrides, states
from codegen.declare.symbols import Parameter
from codegen.model.drivers import Drivers
from codegen.model.forces import Forces
from codegen.model.joints import Joints


class Model(Joints, Drivers, Forces):
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
