"""The scenes of a declaration."""

from collections.abc import Mapping, Set
from contextlib import suppress
from dataclasses import replace
from typing import Any, cast

from codegen.declare.body import Body
from codegen.declare.element import Constraint
from codegen.declare.returned_kinds import memoize_methods
from codegen.declare.returned_values import own_coordinates, place_near
from codegen.declare.scene import Analysis, Owner, Request, Scene, name_of
from codegen.declare.state import WatchedCondition
from codegen.declare.symbols import Coordinate, dotted
from codegen.declare.value_reader import NamedValues, Names, Reader, Values
from codegen.errors import ModelError
from codegen.model.bodies import Form
from codegen.model.connections import MOST
from codegen.model.fidelities import NONE
from codegen.model.scene_requests import ONE, SceneRequests
from codegen.readers.values import name_problem, nearest, shown

UNCHANGED = ("parameters", "until", "frozen", "analysis")
"""Fields that a scene takes from its request as they are."""


def without_values_of(request: Request, gone: Set[str], renewed: Set[str] = frozenset()) -> Request:
    """The request without outputs, start values and guesses of what is gone, but for `renewed`."""

    def fits(values: NamedValues) -> NamedValues:
        owned = ((*pair, pair[0].rpartition(".")[0] or pair[0]) for pair in values)
        return tuple((n, x) for n, x, owner in owned if n in renewed or owner not in gone)

    asked = ((word, ONE.match(word)) for word in request.outputs or ())
    outputs = tuple(word for word, one in asked if one is None or one[2] not in gone)
    return replace(
        request, start=fits(request.start), guess=fits(request.guess),
        outputs=None if request.outputs is None else outputs,
    )  # fmt: skip


class Scenes(SceneRequests):
    """The scenes of a declaration."""

    @memoize_methods
    def scene(
        self, name: str, effects: Names = (), drivers: Names = (), *,
        extends: str | Scene | None = None, without: Names = (),
        couplers: Mapping[str | Body, Form] | None = None,
        fidelity: Mapping[Any, str] | None = None, start: Values | None = None,
        guess: Values | None = None, parameters: Values | None = None, frozen: bool | None = None,
        analysis: Analysis | None = None, outputs: Names | None = None,
        until: Mapping[str, Any] | None = None,
    ) -> Scene:  # fmt: skip
        """Declare a scene: the elements that take part in a question.

        With the name alone it answers the scene that was declared under it, to be varied:
        ``model.scene("compressor").without("gas").with_("rub", fidelity="sticking")``.

        Parameters
        ----------
        effects, drivers
            Elements that act, by name or by the object that their declaration returned.
        extends
            Another scene, whose elements and values this one has too, unless stated here.
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
            Values from which assembly starts. A coordinate without one starts from 0, the place of
            a contact from its place for the values of the bodies.
        parameters
            Values that replace the declared defaults in this scene.
        frozen
            Fold the parameters into the code.
        analysis
            ``"dynamics"`` unless given. ``"kinematics"`` compiles neither masses nor forces,
            ``"equilibrium"`` nothing that only a motion needs.
        until
            Conditions that end a run, by name: ``{"landed": ball.y < 0}``. A run ends at the
            instant at which one begins to hold, located as events are.
        outputs
            Outputs in addition to the motion: ``"reactions"``, ``"energy"``, ``"powers"``, or
            those of one element, ``"reaction(A)"``, ``"power(gas)"``; these three unless given,
            which ``"default"`` says in an extension or a list. The others have to be named:
            ``"force(strut)"``, and ``torque``, ``length``, ``angle``, ``rate``, ``deflection``,
            ``gap``, ``penetration`` and ``potential`` in the same way; ``"point(tip)"``, tracked;
            ``"work(gas)"``, integrated along a simulation. ``"forces"``, ``"points"``,
            ``"works"`` and so on are those of all elements, and ``"all"`` is everything.
        """
        base = self.scenes.get(str(name))
        values = (effects, drivers, extends, without, couplers, fidelity, start, guess, parameters)
        bare = all(map(_is_empty, (*values, until))) and _none_of(frozen, analysis, outputs)
        if bare and base is not None and base.request != Request():
            return base
        where, read = f"scene '{name}'", self._read
        request, explicit = self._read_request(
            read, where, effects, drivers, without=without, couplers=couplers, fidelity=fidelity,
            start=start, guess=guess, parameters=parameters, frozen=frozen, analysis=analysis,
            outputs=outputs, until=until,
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
            self._put_siblings(scene)
        return scene

    def _put_siblings(self, scene: Scene) -> None:
        """Declare the scenes in which a run goes on once other joints act."""
        present = self._present(scene.bodies, scene.request.without)
        if len(present) > MOST:
            self._note(
                f"scene '{scene.name}': {len(present)} joints come and go, {', '.join(present)}; "
                f"{MOST} are the most. Leave some of them out by without=."
            )
            return
        for connected in self._reachable(present, scene.connected)[1:]:
            sibling = self.reconnected(scene, connected)
            if sibling.name in self.scenes:
                self._note(f"scene '{sibling.name}' follows from '{scene.name}'; rename it.")
            else:
                self.scenes[sibling.name] = sibling

    def reconnected(self, scene: Scene, connected: tuple[str, ...]) -> Scene:
        """The scene in which a run goes on where other joints act of those that come and go."""
        connected = tuple(name for name in self.connections if name in connected)
        request = replace(scene.request, connected=connected)
        present = self._present(scene.bodies, scene.request.without)
        first = self._connected_name("", present, scene.connected)
        name = self._connected_name(scene.name.removesuffix(first), present, connected)
        about = {"expression": scene.expression, "root": scene.root}
        return self._compose(Reader(), name, request, **about)

    def watched(self, scene: Scene) -> tuple[WatchedCondition, ...]:
        """The conditions that a run in a scene watches."""
        if scene.analysis != "dynamics":
            return ()
        present, connected = self._present(scene.bodies, scene.request.without), scene.connected
        of_joints = (
            self.connections[name].watched(name in connected, self.reconnected(scene, after).name)
            for name, after in self._neighbours(present, connected)
        )
        of_states = (one for name in scene.states for one in self.states[name].conditions)
        return (*scene.until, *of_states, *filter(None, of_joints))

    def _extend(
        self,
        read: Reader,
        where: str,
        extends: str | Scene,
        request: Request,
        explicit: frozenset[str],
    ) -> Request:
        named = name_of(extends)
        base = extends if isinstance(extends, Scene) else self.scenes.get(named)
        if base is None:
            read.note(
                f"{where} extends {shown(extends)}, which is no scene; "
                f"{nearest(named, self.scenes)}"
            )
            return request
        if cast(object, base.owner) is not self:
            read.note(f"{where} extends scene '{base.name}' of another model.")
            return request
        inherited = base.request
        for group, choice in request.fidelity:
            choices = self.groups.get(group, {})
            others = {n for word, names in choices.items() if word != choice for n in names}
            inherited = replace(
                inherited, effects=tuple(e for e in inherited.effects if e not in others)
            )
        return self._drop_unused(inherited.extended(request, explicit), request)

    def _drop_unused(self, merged: Request, mine: Request) -> Request:
        """Drop inherited start values and outputs of elements that no longer take part."""
        scratch = self._compose(Reader(), "scratch", merged)
        acting = {*scratch.bodies, *scratch.states, *scratch.effects, *scratch.drivers}
        acting |= {*self.joints} - {*scratch.inactive_joints, *merged.without}
        known = {*self.elements} - acting
        fewer = without_values_of(merged, known, {n for n, _ in (*mine.start, *mine.guess)})
        return fewer if mine.outputs is None else replace(fewer, outputs=merged.outputs)

    def _compose(self, read: Reader, name: str, request: Request, **about: Any) -> Scene:
        """Resolve a request to its scene."""
        where = f"scene '{name}'"
        how = dict(request.fidelity)
        named = tuple(e for e in request.effects if e not in request.without)
        included, excluded = self._group_members(read, where, how, named)
        removed = (*request.without, *excluded)
        absent = (*removed, *self._absent_bodies(read, where, removed, how))
        first, acts = self._connected_at_first(), request.connected
        connected = tuple(n for n in (first if acts is None else acts) if n not in absent)
        absent += tuple(n for n in self.connections if n not in connected)
        idle = {e for e, word in how.items() if word == NONE}
        present = [b for b in self.bodies if b not in absent]
        acting = {*named, *included, *self._output_points(request.outputs, present)}
        gone = {n for n in self.connections if n not in connected}
        acting -= idle | {*request.without}
        rubbing = self._rubbing_in(acting, gone, how)
        acting -= rubbing
        read.problems += [
            f"{where}: '{e}' has a fidelity but does not act; name it among the effects."
            for e in how
            if e in self.effects and e not in (*acting, *idle)
        ]
        kept = without_values_of(request, gone | rubbing)
        driving = ({*request.drivers} | {*included}) - {*request.without}
        scene = Scene(
            name=name,
            bodies=tuple(present),
            effects=tuple(e for e in self.effects if e in acting),
            drivers=tuple(d for d in self.drivers if d in driving),
            connected=connected,
            inactive_joints=tuple(n for n in dict.fromkeys(absent) if n in self.joints),
            fidelity=tuple((n, w) for n, w in how.items() if n in acting or n not in self.effects),
            start=kept.start,
            guess=self._locate_contacts(request.start, absent, kept.guess),
            outputs=kept.outputs,
            request=request,
            owner=cast(Owner, self),
            **{key: getattr(request, key) for key in UNCHANGED},
            **about,
        )
        return replace(scene, states=self._states_of(scene, named)) if self.states else scene

    def _locate_contacts(
        self, start: NamedValues, absent: tuple[str, ...], guess: NamedValues
    ) -> NamedValues:
        """The guess, with places for the contacts that it does not name."""
        known = dict((*guess, *start))
        places = dict(guess)
        idle = frozenset(absent)
        for name, joint in self.joints.items():
            if name not in idle and not any(b.name in idle for b in joint.bodies):
                with suppress(ModelError):  # reported by `build`
                    places |= {dotted(q): at for q, at in self._place(joint, known).items()}
        return tuple(places.items())

    def place_of(self, joint: Constraint, known: NamedValues) -> dict[Coordinate, float]:
        """Where a joint expects those of its own coordinates whose values are not `known`."""
        return self._place(joint, dict(known))

    def _place(self, joint: Constraint, values: Mapping[str, float]) -> dict[Coordinate, float]:
        """The same, with the known values by name."""
        if not hasattr(joint, "near"):
            return {}
        missing = [q for q in own_coordinates(joint) if dotted(q) not in values]
        if not missing:
            return {}
        places = {q: values.get(dotted(q), q.measure.neutral) for q in self._coordinates()}
        return place_near(joint, missing, self.defaults | places)


def _none_of(*values: object) -> bool:
    """Whether all were left out."""
    return all(value is None for value in values)


def _is_empty(value: object) -> bool:
    """Whether a keyword was left out, or given as a list or mapping of nothing."""
    return value is None or (type(value) in (tuple, list, dict) and not value)
