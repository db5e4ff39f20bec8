"""Variations of scenes: elements left out or taken in, under a name that says so."""

import hashlib
from dataclasses import replace
from typing import Any

from codegen.declare.names import nearest
from codegen.declare.scene import Request, Scene
from codegen.declare.value_reader import Reader
from codegen.model.scenes import Scenes

WIDEST = 100
"""Letters of a name; a longer one is cut and distinguished by a hash, as it names a file."""

CHANGES = ("couplers", "start", "guess", "parameters", "frozen", "analysis", "outputs")


class Variations(Scenes):
    """``scene.without(...)`` and ``scene.with_(...)``."""

    def varied(
        self, scene: Scene, *, out: Any, taken: Any, fidelity: Any = None, **changes: Any
    ) -> Scene:
        """`scene` with elements left out or taken in; it is not declared.

        Parameters
        ----------
        out, taken
            Effects, drivers, joints and bodies, by name or object.
        fidelity, changes
            As in `scene`.
        """
        read, root = Reader(), scene.root or scene
        where = f"scene '{scene.name}', varied"
        gone, back = (tuple(str(getattr(e, "name", e)) for e in one) for one in (out, taken))
        known = self.bodies | self.joints | self.effects | self.drivers
        read.problems += [
            f"{where}: there is no '{name}' to {'leave out' if name in gone else 'take in'}; "
            f"{nearest(name, scene.effects if name in gone else known)}"
            for name in (*gone, *back)
            if name not in known and not (name in back and name in self.groups)
        ]
        read.problems += [
            f"{where}: '{name}' does not act in it, so it cannot be left out; "
            f"{nearest(name, (*scene.effects, *scene.drivers))}"
            for name in gone
            if name in self.effects | self.drivers and name not in scene.effects + scene.drivers
        ]
        read.problems += [
            f"{where}: with_ knows no {word}=; {nearest(word, (*CHANGES, 'fidelity'))}"
            for word in changes
            if word not in CHANGES
        ]
        words = {"without": [n for n in gone if n in known], "fidelity": fidelity}
        words |= {key: changes.get(key) for key in CHANGES}
        request, explicit = self._read_request(
            read,
            where,
            [n for n in back if n in self.effects],
            [n for n in back if n in self.drivers],
            **words,
        )
        returned = tuple(n for n in scene.request.without if n not in back)
        base = replace(scene.request, without=returned)
        merged = self._extend(read, where, replace(scene, request=base), request, explicit)
        merged = self._without_traces(merged, gone)
        spelled = scene.spelled if scene.root else f"{self.name}.scene({scene.name!r})"
        if gone:
            spelled += f".without({', '.join(map(repr, gone))})"
        if back or changes or fidelity:
            parts = [repr(name) for name in back]
            parts += [f"{k}={v!r}" for k, v in (("fidelity", fidelity), *changes.items()) if v]
            spelled += f".with_({', '.join(parts)})"
        name = self._variation_name(root, merged)
        variation = self._compose(read, name, merged, spelled=spelled, root=root)
        problems = (*scene.problems, *read.problems)
        return replace(variation, problems=tuple(dict.fromkeys(problems)))

    def _without_traces(self, request: Request, gone: tuple[str, ...]) -> Request:
        """The request without effects and drivers that are left out now."""
        chosen = {
            n for choices in self.groups.values() for names in choices.values() for n in names
        }
        forces = {n for n in gone if n in self.effects | self.drivers}
        return replace(
            request,
            effects=tuple(n for n in request.effects if n not in gone),
            drivers=tuple(n for n in request.drivers if n not in gone),
            without=tuple(n for n in request.without if n not in forces or n in chosen),
            fidelity=tuple((n, word) for n, word in request.fidelity if n not in gone),
        )

    def again(self, scene: Scene) -> Scene:
        """The same scene of this model, where `scene` is that of another of the same names."""
        if scene.owner is self:
            return scene
        read = Reader()
        about = {"spelled": scene.spelled, "root": scene.root}
        variation = self._compose(read, scene.name, scene.request, **about)
        return replace(variation, problems=(*scene.problems, *read.problems))

    def _variation_name(self, root: Scene, request: Request) -> str:
        """A name from the differences to the root scene."""
        before = root.request
        old, new = dict(before.fidelity), dict(request.fidelity)
        inside = {*before.effects, *before.drivers} - {*before.without}
        now = {*request.effects, *request.drivers} - {*request.without}
        order = [*self.bodies, *self.joints, *self.effects, *self.drivers]
        gone = [
            n for n in order if n in {*request.without} - {*before.without} or n in inside - now
        ]
        took = [
            n for n in order if n in now - inside or n in {*before.without} - {*request.without}
        ]
        took += [n for n in new if new[n] != old.get(n) and n not in took]
        name = root.name
        if gone:
            name += f"_without_{'_'.join(gone)}"
        if took:
            name += f"_with_{'_'.join(f'{n}_{new[n]}' if n in new else n for n in took)}"
        rest = [getattr(request, key) for key in CHANGES if key != "couplers"]
        if rest != [getattr(self._inherited(root, request), k) for k in CHANGES if k != "couplers"]:
            name += f"_{_hash(rest)}"
        name = name.replace("__", "_")
        return name if len(name) <= WIDEST else f"{name[: WIDEST - 9].rstrip('_')}_{_hash(name)}"

    def _inherited(self, root: Scene, request: Request) -> Request:
        """The request of the root with the same elements left out and taken in."""
        same = replace(
            root.request,
            effects=request.effects,
            drivers=request.drivers,
            without=request.without,
            fidelity=request.fidelity,
        )
        return self._drop_unused_starts(same, Request())


def _hash(value: object) -> str:
    return hashlib.sha256(repr(value).encode()).hexdigest()[:8]
