"""The scenes of a declaration."""

from collections.abc import Mapping

from codegen.declare.body import Body
from codegen.declare.names import name_problem
from codegen.declare.scene import Analysis, Scene
from codegen.declare.scene_values import Names, Values, named, overrides, states
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
            Values from which assembly starts; what is named nowhere starts from 0.
        parameters
            Values that replace the declared defaults in this scene.
        frozen
            Fold the parameters into the code.
        analysis
            ``"kinematics"`` compiles neither masses nor forces.
        """
        where = f"scene '{name}'"
        absent = (
            *named(self._read, where, "body or joint", without, self.bodies | self.joints),
            *self._left_out(where, couplers or {}),
        )
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
