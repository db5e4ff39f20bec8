"""The scenes of a declaration."""

from collections.abc import Mapping
from contextlib import suppress

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Located, own_coordinates
from codegen.declare.names import name_problem
from codegen.declare.scene import Analysis, Scene
from codegen.declare.scene_values import (
    NamedValues,
    Names,
    Values,
    dotted,
    named,
    overrides,
    states,
)
from codegen.declare.symbols import Parameter
from codegen.model.couplers import Couplers, Form


class Scenes(Couplers):
    """What takes part in the questions asked of a machine."""

    def scene(
        self,
        name: str,
        effects: Names = (),
        drivers: Names = (),
        *,
        without: Names = (),
        couplers: Mapping[str | Body, Form] | None = None,
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
        couplers
            ``{"rod": "link"}`` or ``"lumped"``: how a coupler is taken, a body unless said.
        start
            Values that must hold at the beginning: ``{"crank.phi": π, "crank.omega": 30}``.
        guess
            Values from which assembly starts; what is named nowhere starts from 0, the place of a
            contact from where it is for the values of the bodies.
        parameters
            Values that replace the declared defaults in this scene.
        frozen
            Fold the parameters into the code.
        analysis
            ``"kinematics"`` compiles neither masses nor forces.
        """
        where = f"scene '{name}'"
        gone = named(self._read, where, "body or joint", without, self.bodies | self.joints)
        absent = (*gone, *self._left_out(where, gone, couplers or {}))
        known = states(self._read, where, self._coordinates(), start or {})
        given = states(self._read, where, self._coordinates(), guess or {})
        scene = Scene(
            name=name,
            bodies=tuple(b for b in self.bodies if b not in absent),
            effects=named(self._read, where, "effect", effects, self.effects),
            drivers=named(self._read, where, "driver", drivers, self.drivers),
            opened=tuple(name for name in absent if name in self.joints),
            start=known,
            guess=self._with_contacts(known, absent, given),
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

    def _with_contacts(
        self, start: NamedValues, absent: tuple[str, ...], guess: NamedValues
    ) -> NamedValues:
        """The guess, with the places of contacts that nobody named."""
        named_ones = dict((*guess, *start))
        numbers: dict[sympy.Symbol, float] = {
            Parameter(p.name, real=True): p.value for p in self.parameters.values()
        }
        for q in self._coordinates():
            numbers[q] = named_ones.get(dotted(q), 0.0)
        found = dict(guess)
        for name, joint in self.joints.items():
            missing = [q for q in own_coordinates(joint) if dotted(q) not in named_ones]
            taking_part = name not in absent and not any(b.name in absent for b in joint.bodies)
            if missing and taking_part and isinstance(joint, Located):
                with suppress(TypeError, ValueError):  # what is wrong with it, `build` says
                    near = joint.near(numbers)
                    found |= {dotted(q): near[q] for q in missing}
        return tuple(found.items())
