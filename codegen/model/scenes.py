"""The scenes of a declaration."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, cast

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Located, own_coordinates
from codegen.declare.names import name_problem, nearest
from codegen.declare.scene import ANALYSES, Analysis, Owner, Request, Scene
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
from codegen.declare.value_reader import Reader
from codegen.model.couplers import Form
from codegen.model.fidelities import NONE, Fidelities
from codegen.model.outputs import Outputs


class Scenes(Fidelities, Outputs):
    """The scenes of a declaration."""

    def scene(
        self,
        name: str,
        effects: Names = (),
        drivers: Names = (),
        *,
        extends: str | Scene | None = None,
        without: Names = (),
        couplers: Mapping[str | Body, Form] | None = None,
        fidelity: Mapping[Any, str] | None = None,
        start: Values | None = None,
        guess: Values | None = None,
        parameters: Values | None = None,
        frozen: bool | None = None,
        analysis: Analysis | None = None,
        outputs: Names | None = None,
    ) -> Scene:
        """Declare a scene: the elements that take part in a question.

        With the name alone it answers the scene that was declared under it, to be varied:
        ``model.scene("compressor").without("gas").with_("rub", fidelity="sticking")``.

        Parameters
        ----------
        name
            An identifier.
        effects, drivers
            Elements that act, by name or by the object that their declaration returned.
        extends
            Another scene: it has all that this one has, but for what is said here.
        without
            Bodies that do not take part, with the joints and effects on them; or joints, effects
            and drivers alone.
        couplers
            ``{"rod": "link"}`` or ``"lumped"``: how a coupler is taken, a body unless said.
        fidelity
            Effect, coupler or group of `alternatives` → how it is taken: a friction
            ``"sticking"`` or ``"regularised"``, a contact ``"penalty"`` or ``"rigid"``, a coupler
            as in `couplers`, any effect ``"none"``; as declared unless said.
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
            ``"dynamics"`` unless given. ``"kinematics"`` compiles neither masses nor forces,
            ``"equilibrium"`` nothing that only a motion needs.
        outputs
            Outputs in addition to the motion: ``"reactions"``, ``"energy"``, ``"powers"``, or
            those of one element, ``"reaction(A)"``, ``"power(gas)"``; all unless given, which
            ``"all"`` says in an extension. And what has to be named: ``"paths"`` of tracked points,
            ``"path(tip)"``; ``"works"``, ``"work(gas)"``, integrated along a simulation.
        """
        base = self.scenes.get(name)
        said = (effects, drivers, extends, without, couplers, fidelity, start, guess, parameters)
        bare = not any(bool(word) for word in said) and (frozen, analysis, outputs) == (None,) * 3
        if bare and base is not None and base.request != Request():
            return base
        where, read = f"scene '{name}'", self._read
        request, explicit = self._read_request(
            read, where, effects, drivers, without=without, couplers=couplers, fidelity=fidelity,
            start=start, guess=guess, parameters=parameters, frozen=frozen, analysis=analysis,
            outputs=outputs,
        )  # fmt: skip
        if extends is not None:
            request = self._extend(read, where, extends, request, explicit)
        scene = self._compose(read, name, request)
        if problem := name_problem("scene", name):
            self._note(problem)
        elif name in self.scenes:
            self._note(f"{where} is declared twice; give each scene its own name.")
        else:
            self.scenes[name] = scene
        return scene

    def _read_request(
        self, read: Reader, where: str, effects: Names, drivers: Names, **words: Any
    ) -> tuple[Request, frozenset[str]]:
        """The request of a scene, and its explicit keywords among those with a default."""
        known = self.bodies | self.joints | self.effects | self.drivers
        coordinates = self._coordinates()
        plain = {"frozen": False, "analysis": "dynamics", "outputs": None}
        explicit = {key: plain[key] if words[key] is None else words[key] for key in plain}
        analysis = read.choice(explicit["analysis"], ANALYSES, f"{where}, analysis")
        request = Request(
            effects=named(read, where, "effect", effects, self.effects),
            drivers=named(read, where, "driver", drivers, self.drivers),
            without=named(read, where, "body or joint", words["without"], known),
            fidelity=self._read_fidelities(read, where, words["fidelity"], words["couplers"]),
            start=states(read, where, coordinates, words["start"] or {}),
            guess=states(read, where, coordinates, words["guess"] or {}),
            parameters=overrides(read, where, self.parameters, words["parameters"] or {}),
            frozen=bool(explicit["frozen"]),
            analysis=analysis,
            outputs=self._read_outputs(read, where, explicit["outputs"]),
        )
        return request, frozenset(key for key in plain if words[key] is not None)

    def _extend(
        self,
        read: Reader,
        where: str,
        extends: str | Scene,
        request: Request,
        explicit: frozenset[str],
    ) -> Request:
        base = extends if isinstance(extends, Scene) else self.scenes.get(extends)
        if base is None:
            hint = nearest(str(extends), self.scenes)
            read.problems.append(f"{where} extends '{extends}', which is no scene; {hint}")
            return request
        inherited = base.request
        for group, choice in request.fidelity:
            others = {
                name
                for word, names in self.groups.get(group, {}).items()
                if word != choice
                for name in names
            }
            kept = tuple(e for e in inherited.effects if e not in others)
            inherited = replace(inherited, effects=kept)
        return self._drop_unused_starts(inherited.extended(request, explicit), request)

    def _drop_unused_starts(self, merged: Request, mine: Request) -> Request:
        """Drop inherited start values of elements that no longer take part."""
        scratch = self._compose(Reader(), "scratch", merged)
        present = {*scratch.bodies, *self.joints} - {*scratch.opened, *merged.without}
        renewed = {name for name, _ in (*mine.start, *mine.guess)}

        def fits(values: NamedValues) -> NamedValues:
            return tuple(
                (name, value)
                for name, value in values
                if name in renewed or name.rpartition(".")[0] in present
            )

        return replace(merged, start=fits(merged.start), guess=fits(merged.guess))

    def _compose(self, read: Reader, name: str, request: Request, **about: Any) -> Scene:
        """Resolve a request to its scene."""
        where = f"scene '{name}'"
        how = dict(request.fidelity)
        wanted = tuple(e for e in request.effects if e not in request.without)
        brought, others = self._chosen(read, where, how, wanted)
        gone = (*request.without, *others)
        absent = (*gone, *self._left_out(read, where, gone, how))
        idle = {e for e, word in how.items() if word == NONE}
        present = [b for b in self.bodies if b not in absent]
        acting = {*wanted, *brought, *self._brought(request.outputs, present)}
        acting -= idle | {*request.without}
        read.problems += [
            f"{where}: '{e}' has a fidelity but does not act; name it among the effects."
            for e in how
            if e in self.effects and e not in (*acting, *idle)
        ]
        driving = ({*request.drivers} | {*brought}) - {*request.without}
        return Scene(
            name=name,
            bodies=tuple(present),
            effects=tuple(e for e in self.effects if e in acting),
            drivers=tuple(d for d in self.drivers if d in driving),
            opened=tuple(n for n in dict.fromkeys(absent) if n in self.joints),
            fidelity=tuple((n, w) for n, w in how.items() if n in acting or n not in self.effects),
            start=request.start,
            guess=self._with_contacts(request.start, absent, request.guess),
            parameters=request.parameters,
            frozen=request.frozen,
            analysis=request.analysis,
            outputs=request.outputs,
            request=request,
            owner=cast(Owner, self),
            **about,
        )

    def _with_contacts(
        self, start: NamedValues, absent: tuple[str, ...], guess: NamedValues
    ) -> NamedValues:
        """The guess, with the places of contacts that nobody named."""
        named_ones = dict((*guess, *start))
        numbers: dict[sympy.Symbol, float] = {
            Parameter(p.name, real=True): p.value for p in self.parameters.values()
        }
        for q in self._coordinates():
            numbers[q] = named_ones.get(dotted(q), q.measure.neutral)
        found = dict(guess)
        for name, joint in self.joints.items():
            missing = [q for q in own_coordinates(joint) if dotted(q) not in named_ones]
            taking_part = name not in absent and not any(b.name in absent for b in joint.bodies)
            if missing and taking_part and isinstance(joint, Located):
                with suppress(TypeError, ValueError):  # what is wrong with it, `build` says
                    near = joint.near(numbers)
                    found |= {dotted(q): near[q] for q in missing}
        return tuple(found.items())
