"""Variations of scenes: elements left out or taken in, under a name that says so."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

from codegen.declare.scene import Request, Scene, name_of
from codegen.declare.value_reader import Reader
from codegen.model.scenes import Scenes
from codegen.readers.values import KindError, nearest, plain_number, shown

WIDEST = 100  # letters of a name, which names a file; a longer one is cut and told apart by a hash

CHANGES = ("couplers", "start", "guess", "parameters", "frozen", "analysis", "outputs")


class Variations(Scenes):
    """``scene.without(...)`` and ``scene.with_(...)``."""

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
                leave = name in removed
                hint = nearest(name, scene.effects if leave else known)
                verb = "leave out" if leave else "take in"
                read.note(f"{where}: there is no '{name}' to {verb}; {hint}")
        acting = (*scene.effects, *scene.drivers)
        for name in removed:
            if name in self.effects | self.drivers and name not in acting:
                hint = nearest(name, acting)
                read.note(f"{where}: '{name}' does not act in it, so it cannot be left out; {hint}")
        for word in changes:
            if word not in CHANGES:
                hint = nearest(word, (*CHANGES, "fidelity"))
                read.note(f"{where}: with_ knows no {word}=; {hint}")
        effects, drivers = ([n for n in added if n in of] for of in (self.effects, self.drivers))
        words = {key: changes.get(key) for key in CHANGES} | {"fidelity": fidelity}
        words["without"] = [n for n in removed if n in known]
        request, explicit = self._read_request(read, where, effects, drivers, **words)
        returned = tuple(n for n in scene.request.without if n not in added)
        base = replace(scene.request, without=returned)
        merged = self._extend(read, where, replace(scene, request=base), request, explicit)
        merged = self._remove_elements(merged, tuple(removed))
        expression = scene.expression if scene.root else f"{self.name}.scene({scene.name!r})"
        if removed:
            expression += f".without({', '.join(map(_written, removed))})"
        if added or changes or fidelity:
            parts = [*map(_written, added)]
            words = {"fidelity": fidelity} | changes
            parts += [f"{k}={_written(v)}" for k, v in words.items() if v is not None]
            expression += f".with_({', '.join(parts)})"
        name = self._variation_name(root, merged)
        variation = self._compose(read, name, merged, expression=expression, root=root)
        problems = (*scene.problems, *read.problems)
        return replace(variation, problems=tuple(dict.fromkeys(problems)))

    def _remove_elements(self, request: Request, removed: tuple[str, ...]) -> Request:
        """The request without effects and drivers that are left out now."""
        choices = chain.from_iterable(group.values() for group in self.groups.values())
        chosen = {*chain.from_iterable(choices)}
        forces = {n for n in removed if n in self.effects | self.drivers}
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
        order = [*self.bodies, *self.joints, *self.effects, *self.drivers]
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
        keys, inherited = CHANGES[1:], self._drop_unused(same, Request())
        rest = [getattr(request, key) for key in keys]
        if rest != [getattr(inherited, key) for key in keys]:
            name += f"_{_hash(rest)}"
        name = name.replace("__", "_")
        return name if len(name) <= WIDEST else f"{name[: WIDEST - 9].rstrip('_')}_{_hash(name)}"


def _hash(value: object) -> str:
    return hashlib.sha256(repr(value).encode()).hexdigest()[:8]


def _written(value: Any) -> str:
    """A keyword's value in the comment that says how a scene was varied: names and numbers."""
    if value is None or isinstance(value, bool):
        return str(value)
    if isinstance(value, str) or isinstance(getattr(value, "name", None), str):
        return repr(name_of(value))
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_written(k)}: {_written(v)}' for k, v in value.items())}}}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_written, value))}]"
    try:
        return repr(plain_number(value))
    except KindError:
        return shown(value)
