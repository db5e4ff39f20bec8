"""The outputs of a scene in addition to the motion: the words of ``outputs=``."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from codegen.declare.body import Body, Point
from codegen.declare.element import EXERTED, QUANTITIES, Effect, Reported, label
from codegen.declare.value_reader import Reader
from codegen.drawing import shapes
from codegen.model.base import TRACKED, Declarations, Place, declares
from codegen.readers.names import nearest
from codegen.readers.values import KindError, entries, shown

ALL = ("reactions", "energy", "powers")  # outputs of a scene that names none
GROUPS = (*ALL, "points", "works", *(f"{quantity}s" for quantity in QUANTITIES))
SINGLE = ("reaction", "power", "point", "work", *QUANTITIES)
ONE = re.compile(rf"({'|'.join(SINGLE)})\((\w+)\)\Z")
OF_ANALYSIS = {
    "dynamics": GROUPS,
    "equilibrium": tuple(group for group in GROUPS if group not in ("powers", "works")),
    "kinematics": ("points", *(f"{word}s" for word in QUANTITIES if word not in EXERTED)),
}
"""Analysis → the groups of outputs that a scene for it may have, which ``"all"`` means."""


@dataclass(frozen=True, eq=False)
class TrackedPoint(Effect):
    """A point of a body, r + A s', as an effect without a force that reports where it is."""

    kind = TRACKED
    name: str
    point: Point

    def reported(self, bodies: tuple[Body, ...]) -> Reported:
        """Its global coordinates, m, and their rates, m/s."""
        at = self.point
        return ("x", "m", at.x), ("y", "m", at.y), ("vx", "m/s", at.vx), ("vy", "m/s", at.vy)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The point, with its path."""
        return (shapes.Trace(self.point),)

    def problems(self) -> list[str]:
        """A point of the ground does not move."""
        if self.point.body.fixed:
            return [f"{label(self)} is a point of the ground; give one of a body."]
        return []


class Outputs(Declarations):
    """Reads the outputs that a scene asks for."""

    @declares(TrackedPoint)
    def track(self, name: str, point: Place) -> TrackedPoint:
        """A point whose place a scene may ask for, by ``outputs=["point(NAME)"]`` or ``"points"``.

        Parameters
        ----------
        point
            A point of a body; a body means its centre of mass.
        """

    @property
    def points(self) -> frozenset[str]:
        """Names of the tracked points."""
        return frozenset(self._tracked())

    def _tracked(self) -> list[str]:
        """Names of the tracked points."""
        return [name for name, effect in self.effects.items() if effect.kind == TRACKED]

    def _output_points(
        self, outputs: tuple[str, ...] | None, bodies: Iterable[str]
    ) -> tuple[str, ...]:
        """Points that are outputs: all on the bodies that take part, or the named ones."""
        words, present = outputs or (), set(bodies)
        return tuple(
            name
            for name in self._tracked()
            if "points" in words or f"point({name})" in words
            if {body.name for body in self.effects[name].bodies} <= present
        )

    def _read_outputs(
        self, read: Reader, where: str, outputs: Any, analysis: Any
    ) -> tuple[str, ...] | None:
        """The words in a fixed order, each once; None for those of a scene that names none."""
        if outputs is None or (isinstance(outputs, str) and outputs == "default"):
            return None
        try:
            given = [outputs] if isinstance(outputs, str) else entries(outputs)
        except KindError:
            what = shown(outputs)
            read.note(
                f"{where}: outputs={what} is no list; write outputs=['energy', 'power(gas)']."
            )
            return None
        words = list[str]()
        for word in given:
            if isinstance(word, str) and word in ("all", "default"):
                words += OF_ANALYSIS.get(analysis, GROUPS) if word == "all" else ALL
            elif problem := self._output_problem(word):
                read.note(f"{where}: {problem}")
            else:
                words.append(str(word))
        order = (*GROUPS, *sorted(set(words) - set(GROUPS)))
        return tuple(word for word in order if word in words)

    def _output_problem(self, given: Any) -> str | None:
        word = given if isinstance(given, str) else shown(given)
        if word in GROUPS:
            return None
        match = ONE.match(word)
        points = self._tracked()
        acting = [n for n in (*self.joints, *self.drivers, *self.effects) if n not in points]
        if match is None:
            words = [f"{group}({n})" for group in ("reaction", "power", "work") for n in acting]
            words += [f"{quantity}({n})" for quantity in QUANTITIES for n in self.effects]
            words += [f"point({n})" for n in points]
            return f"no output {shown(given)}; {nearest(word, ('all', 'default', *GROUPS, *words))}"
        group, name = match.groups()
        if group == "point" and name not in points:
            hint = nearest(name, points) if points else "declare it with model.track(...)."
            return f"no output '{word}', as there is no tracked point '{name}'; {hint}"
        if group != "point" and name not in acting:
            return f"no output '{word}', as there is no '{name}'; {nearest(name, acting)}"
        return None
