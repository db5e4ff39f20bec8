"""The outputs of a scene in addition to the motion: the words of ``outputs=``."""

import re
from collections.abc import Iterable
from typing import Any

from codegen.declare.body import Body, Point
from codegen.declare.names import nearest
from codegen.declare.path_points import TrackedPoint, tracked
from codegen.declare.value_reader import Reader
from codegen.model.base import Declarations

ALL = ("reactions", "energy", "powers")
"""Outputs of a scene that names none."""
GROUPS = (*ALL, "paths", "works")
ONE = re.compile(r"(reaction|power|path|work)\((\w+)\)\Z")


class Outputs(Declarations):
    """Reads the outputs that a scene asks for."""

    def track(self, name: str, point: Point | Body) -> TrackedPoint:
        """A point whose path a scene may ask for, by ``outputs=["path(NAME)"]`` or ``"paths"``.

        Parameters
        ----------
        point
            A point of a body; a body means its centre of mass.
        """
        element = TrackedPoint(name, self._point(name, point))
        self._effect(element)
        return element

    def _brought(self, outputs: tuple[str, ...] | None, bodies: Iterable[str]) -> tuple[str, ...]:
        """Points whose paths are outputs: all on the bodies that take part, or the named ones."""
        points = tracked(self.effects.values())
        words, present = outputs or (), set(bodies)
        reachable = [n for n in points if {b.name for b in self.effects[n].bodies} <= present]
        if "paths" in words:
            return tuple(reachable)
        return tuple(name for name in reachable if f"path({name})" in words)

    def _read_outputs(self, read: Reader, where: str, outputs: Any) -> tuple[str, ...] | None:
        """The words in a fixed order, each once; None for all that there is."""
        if outputs is None or outputs == "all":
            return None
        if not isinstance(outputs, str | Iterable):
            read.problems.append(
                f"{where}: outputs={outputs!r} is no list; write outputs=['energy', 'power(gas)']."
            )
            return None
        words = []
        for word in (outputs,) if isinstance(outputs, str) else outputs:
            if problem := self._output_problem(word):
                read.problems.append(f"{where}: {problem}")
            else:
                words.append(str(word))
        order = (*GROUPS, *sorted(set(words) - set(GROUPS)))
        return tuple(word for word in order if word in words)

    def _output_problem(self, word: Any) -> str | None:
        if word in GROUPS:
            return None
        match = ONE.match(word) if isinstance(word, str) else None
        points = tracked(self.effects.values())
        acting = [n for n in (*self.joints, *self.drivers, *self.effects) if n not in points]
        if match is None:
            kinds = ("reaction", "power", "work")
            words = [*GROUPS, *(f"{group}({n})" for group in kinds for n in acting)]
            words += [f"path({n})" for n in points]
            return f"no output {word!r}; {nearest(str(word), words)}"
        group, name = match.groups()
        if group == "path" and name not in points:
            hint = nearest(name, points) if points else "declare it with model.track(...)."
            return f"no output '{word}', as there is no tracked point '{name}'; {hint}"
        if group != "path" and name not in acting:
            return f"no output '{word}', as there is no '{name}'; {nearest(name, acting)}"
        return None
