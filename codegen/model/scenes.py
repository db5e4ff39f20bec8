"""The scenes of a declaration, and their variations, under names that say what is varied."""

import hashlib
from collections.abc import Iterator, Mapping, Set
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from typing import Any, cast

from codegen.declare.body import Body
from codegen.declare.element import Constraint
from codegen.declare.returned_values import memoize_methods, own_coordinates, place_near
from codegen.declare.scene import Analysis, Owner, Request, Scene, name_of, written
from codegen.declare.state import WatchedCondition
from codegen.declare.symbols import Coordinate, dotted, owners
from codegen.declare.value_reader import NamedValues, Names, Reader, Values
from codegen.errors import ModelError
from codegen.model.bodies import Form
from codegen.model.connections import MOST
from codegen.model.scene_requests import NONE, ONE, SceneRequests
from codegen.readers.values import name_problem, nearest, shown

UNCHANGED = ("parameters", "expressions", "frozen", "analysis", "unknown")
"""Fields that a scene takes from its request as they are."""


def without_values_of(request: Request, gone: Set[str], renewed: Set[str] = frozenset()) -> Request:
    """The request without outputs, start values and guesses of what is gone, but for `renewed`."""

    def fits(values: NamedValues) -> NamedValues:
        owned = ((*pair, pair[0].rpartition(".")[0] or pair[0]) for pair in values)
        return tuple((n, x) for n, x, owner in owned if n in renewed or owner not in gone)

    asked = ((word, ONE.match(word)) for word in request.outputs or ())
    named = ((word, one[2] if one else word.rpartition(".")[0]) for word, one in asked)
    outputs = tuple(word for word, owner in named if owner not in gone)
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
        """Declare a scene: the elements that act, start values and outputs.

        With the name alone it returns the declared scene of this name, from which others follow:
        ``model.scene("compressor").without("gas").with_("rub", fidelity="sticking")``.

        Parameters
        ----------
        effects, drivers
            Elements that act, by name or by the object that their declaration returned.
        extends
            A scene whose entries hold here as well: effects and drivers are added to them; a value
            replaces the value of its name, ``{}`` empties a mapping, and outputs replace outputs.
        without
            Bodies that take no part, with joints and effects on them; joints, effects, drivers.
        couplers
            Coupler → ``"link"``, ``"lumped"`` or ``"body"``, which is the default.
        fidelity
            Effect, coupler or group of `alternatives` → its fidelity, by default as declared: a
            friction ``"sticking"`` or ``"regularised"``, a contact ``"penalty"`` or ``"rigid"``, a
            coupler as in `couplers`, any effect ``"none"``.
        start
            Values that must hold at the beginning: ``{"crank.phi": π, "crank.omega": 30}``.
        guess
            Values from which assembly starts. A coordinate without one starts from 0, and the place
            of a contact from its place at the bodies' start values.
        parameters
            Values that replace the declared defaults in this scene.
        frozen
            Fold the parameters into the code.
        analysis
            ``"dynamics"``, the default; ``"kinematics"``, without masses and forces; or
            ``"equilibrium"``, without the kernels that only a motion needs.
        until
            Conditions that end a run, by name: ``{"landed": ball.y < 0}``. A run ends at the
            instant at which one begins to hold, which is located like an event.
        outputs
            Outputs in addition to the motion: ``"reactions"``, ``"energy"``, ``"powers"``, or those
            of one element, ``"reaction(A)"``, ``"power(gas)"``. By default, and by ``"default"`` in
            a list, these are the three groups without the powers of effects with a potential. Other
            outputs are ``"force(strut)"``, and ``torque``, ``length``, ``angle``, ``rate``,
            ``deflection``, ``gap``, ``penetration`` and ``potential`` in the same way;
            ``"point(tip)"`` of a tracked point; ``"work(gas)"``, which a simulation integrates.
            ``"forces"`` and other plurals name those of all elements, and ``"all"`` everything.
            More are ``"acceleration(tip)"``, ``"global_reaction(A)"``, and ``"shaking"``, the force
            and moment on the ground. A mapping, alone or in a list, has expressions in SI units, or
            pairs ``(expression, unit)``: ``{"load": abs(model.series("A.fx")) / 1000}``.
        """
        base = self.scenes.get(str(name))
        words = (effects, drivers, extends, without, couplers, fidelity, start, guess, parameters)
        bare = all(v is None for v in (frozen, analysis, outputs)) and all(
            map(_is_empty, (*words, until))
        )
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
        of_joints = (
            self.connections[joints[0]].watched(joints[0] in scene.connected, name)
            for joints, name in self._followers(scene)
            if len(joints) == 1
        )
        of_states = (one for name in scene.states for one in self.states[name].conditions)
        return (*scene.until, *of_states, *filter(None, of_joints))

    def together(self, scene: Scene) -> tuple[tuple[tuple[str, ...], str], ...]:
        """Several joints that may come or go at one instant → the scene in which a run goes on."""
        if scene.analysis != "dynamics":
            return ()
        return tuple(row for row in self._followers(scene) if len(row[0]) > 1)

    def _followers(self, scene: Scene) -> Iterator[tuple[tuple[str, ...], str]]:
        """Joints that may change at one instant, and the name of the scene that follows."""
        present = self._present(scene.bodies, scene.request.without)
        for joints, after in self._changes(present, scene.connected):
            yield joints, self.reconnected(scene, after).name

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
        if mine.outputs is not None or mine.expressions:
            return replace(fewer, outputs=merged.outputs)
        needed = ((one, one.owners & known - {*self.joints}) for one in merged.expressions)
        return replace(fewer, expressions=tuple(one for one, lost in needed if not lost))

    def _compose(self, read: Reader, name: str, request: Request, **about: Any) -> Scene:
        """Resolve a request to its scene."""
        where = f"scene '{name}'"
        how = dict(request.fidelity)
        named = tuple(e for e in request.effects if e not in request.without)
        included, excluded = self._group_members(read, where, how, named)
        removed = (*request.without, *excluded)
        absent = (*removed, *self._absent_bodies(read, where, removed, how, request.analysis))
        first, acts = self._connected_at_first(), request.connected
        connected = tuple(n for n in (first if acts is None else acts) if n not in absent)
        absent += tuple(n for n in self.connections if n not in connected)
        idle = {e for e, word in how.items() if word == NONE}
        present = [b for b in self.bodies if b not in absent]
        acting = {*named, *included, *self._output_points(request, present)}
        gone = {n for n in self.connections if n not in connected}
        acting -= idle | {*request.without} - {*self.joints}
        rubbing = self._rubbing_in(acting, gone, how)
        acting -= rubbing
        read.problems += [
            f"{where}: '{e}' has a fidelity but does not act; name it among the effects."
            for e in how
            if e in self.effects and e not in (*acting, *idle)
        ]
        kept = without_values_of(request, gone | rubbing)
        until = tuple(one for one in request.until if not owners(one.indicator) & gone)
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
            until=until,
            request=request,
            owner=cast(Owner, self),
            **{key: getattr(request, key) for key in UNCHANGED},
            **about,
        )
        if self.states:
            scene = replace(scene, states=self._states_of(scene, named))
        return self._counting(scene)

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
                    places |= {dotted(q): at for q, at in self.place_of(joint, known).items()}
        return tuple(places.items())

    def place_of(self, joint: Constraint, values: Mapping[str, float]) -> dict[Coordinate, float]:
        """Where a joint expects those of its own coordinates whose values are not known."""
        if not hasattr(joint, "near"):
            return {}
        missing = [q for q in own_coordinates(joint) if dotted(q) not in values]
        if not missing:
            return {}
        places = {q: values.get(dotted(q), q.measure.neutral) for q in self._coordinates()}
        return place_near(joint, missing, self.defaults | places)

    def varied(
        self, scene: Scene, *, out: Any, taken: Any, fidelity: Any = None, **changes: Any
    ) -> Scene:
        """`scene` with elements `out` left out and `taken` taken in; it is not declared.

        Elements are named or given as objects; `fidelity` and `changes` are as in `scene`.
        """
        read, root = Reader(), scene.root or scene
        where, known = f"scene '{scene.name}', varied", self.elements
        removed = read.names(out, "elements", where, known)
        added = read.names(taken, "elements", where, known)
        for name in (*removed, *added):
            if name not in known and not (name in added and name in self.groups):
                ways = (scene.effects, "leave out"), (known, "take in")
                names, verb = ways[name not in removed]
                read.note(f"{where}: there is no '{name}' to {verb}; {nearest(name, names)}")
        acting = (*scene.effects, *scene.drivers)
        for name in removed:
            if name in self.effects_alone | self.drivers and name not in acting:
                hint = nearest(name, acting)
                read.note(f"{where}: '{name}' does not act in it, so it cannot be left out; {hint}")
        for word in changes:
            if word not in CHANGES:
                hint = nearest(word, (*CHANGES, "fidelity"))
                read.note(f"{where}: with_ knows no {word}=; {hint}")
        tables = self.effects_alone, self.drivers
        effects, drivers = ([n for n in added if n in of] for of in tables)
        words = {key: changes.get(key) for key in CHANGES} | {"fidelity": fidelity}
        words["without"] = [n for n in removed if n in known]
        request, explicit = self._read_request(read, where, effects, drivers, **words)
        returned = tuple(n for n in scene.request.without if n not in added)
        base = replace(scene.request, without=returned)
        merged = self._extend(read, where, replace(scene, request=base), request, explicit)
        merged = self._remove_elements(merged, tuple(removed))
        expression = scene.expression if scene.root else f"{self.name}.scene({scene.name!r})"
        if removed:
            expression += f".without({', '.join(map(written, removed))})"
        if added or changes or fidelity:
            parts = [*map(written, added)]
            words = {"fidelity": fidelity} | changes
            parts += [f"{k}={written(v)}" for k, v in words.items() if v is not None]
            expression += f".with_({', '.join(parts)})"
        name = self._variation_name(root, merged)
        variation = self._compose(read, name, merged, expression=expression, root=root)
        problems = (*scene.problems, *read.problems)
        return replace(variation, problems=tuple(dict.fromkeys(problems)))

    def _remove_elements(self, request: Request, removed: tuple[str, ...]) -> Request:
        """The request without effects and drivers that are left out now."""
        choices = chain.from_iterable(group.values() for group in self.groups.values())
        chosen = {*chain.from_iterable(choices)}
        forces = {n for n in removed if n in self.effects_alone | self.drivers}
        return replace(
            request,
            effects=tuple(n for n in request.effects if n not in removed),
            drivers=tuple(n for n in request.drivers if n not in removed),
            without=tuple(n for n in request.without if n not in forces or n in chosen),
            fidelity=tuple((n, word) for n, word in request.fidelity if n not in removed),
        )

    def recompose(self, scene: Scene) -> Scene:
        """The same scene of this model, where `scene` is that of another of the same names."""
        if scene.owner is self:
            return scene
        read = Reader()
        about = {"expression": scene.expression, "root": scene.root}
        variation = self._compose(read, scene.name, scene.request, **about)
        return replace(variation, problems=(*scene.problems, *read.problems))

    def _variation_name(self, root: Scene, request: Request) -> str:
        """A name from the differences to the root scene."""
        before = root.request
        old, new = dict(before.fidelity), dict(request.fidelity)
        out_before, out_now = {*before.without}, {*request.without}
        acted = {*before.effects, *before.drivers} - out_before
        acting = {*request.effects, *request.drivers} - out_now
        order = [*self.bodies, *self.joints, *self.effects_alone, *self.drivers]
        removed = [n for n in order if n in (out_now - out_before) | (acted - acting)]
        added = [n for n in order if n in (out_before - out_now) | (acting - acted)]
        added += [n for n in new if new[n] != old.get(n) and n not in added]
        name = root.name
        if removed:
            name += f"_without_{'_'.join(removed)}"
        if added:
            name += f"_with_{'_'.join(f'{n}_{new[n]}' if n in new else n for n in added)}"
        # the root's request with the same elements, against which other changes are told apart
        names = ("effects", "drivers", "without", "fidelity")
        same = replace(before, **{key: getattr(request, key) for key in names})
        keys = CHANGES[1:] + ("expressions",) * bool(request.expressions or before.expressions)
        inherited = self._drop_unused(same, Request())
        rest = [getattr(request, key) for key in keys]
        if rest != [getattr(inherited, key) for key in keys]:
            name += f"_{_hash(rest)}"
        name = name.replace("__", "_")
        return name if len(name) <= WIDEST else f"{name[: WIDEST - 9].rstrip('_')}_{_hash(name)}"


def _is_empty(value: object) -> bool:
    """Whether a keyword was left out, or given as a list or mapping of nothing."""
    return value is None or (type(value) in (tuple, list, dict) and not value)


WIDEST = 100  # letters of a name, which names a file; a longer one is cut and told apart by a hash

CHANGES = ("couplers", "start", "guess", "parameters", "frozen", "analysis", "outputs")


def _hash(value: object) -> str:
    return hashlib.sha256(repr(value).encode()).hexdigest()[:8]
