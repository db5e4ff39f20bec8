"""Joints of a declaration that are released or engage in the course of a run."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import combinations
from typing import Any

import sympy

from codegen.declare.element import Constraint
from codegen.declare.returned_values import statement_of
from codegen.declare.scene import Scene, name_of
from codegen.declare.state import Connection
from codegen.declare.symbols import Coordinate, kinds, owners
from codegen.elements.forces.mass_flow import MASS_LAW
from codegen.errors import ModelError
from codegen.model.base import Declarations
from codegen.readers.values import nearest, shown

MOST = 4  # safety: joints of a scene that come and go; each set of them is a module of its own


class Connections(Declarations):
    """Joints that come and go."""

    def release(self, joint: Constraint | str, when: Any, until: Any = None) -> None:
        """Let a joint go once a condition begins to hold: a latch opens, a sling lets go.

        The constraint no longer acts; the run goes on with more degrees of freedom, from the same
        positions and velocities. Joints whose conditions begin to hold at one instant change
        together. Declare `release` before the scenes.

        Parameters
        ----------
        joint
            A joint, or its name; it acts at the start of a run.
        when
            A condition of t, q, q̇, states and parameters.
        until
            A condition under which the joint engages again, as with `engage`; while it holds, the
            joint is not released.
        """
        self._connect("release", joint, True, when, until)

    def engage(self, joint: Constraint | str, when: Any, until: Any = None) -> None:
        """Let a joint act once a condition begins to hold: a latch catches, a pin drops in.

        At this instant the motion must have closed the joint. An impact ends the velocities that
        the joint does not permit: M Δv + Φ_qᵀ Λ = 0, Φ_q (v + Δv) = ν, one impact of all joints
        that engage at one instant. `Result.reconnections` has the impulses. Declare `engage` before
        the scenes.

        Parameters
        ----------
        joint
            A joint, or its name; it does not act at the start of a run.
        when
            A condition of t, q, q̇, states and parameters.
        until
            A condition under which the joint is released again; while it holds, the joint does not
            engage.
        """
        self._connect("engage", joint, False, until, when)

    def _connect(
        self, word: str, joint: Any, acts_first: bool, released: Any, engaged: Any
    ) -> None:
        name, where = name_of(joint), f"{word} of joint"
        found = self.joints.get(name)
        if found is None or found.kind == MASS_LAW:
            kind = found.kind if found else self._kinds.get(name)
            hint = f"it is the name of a {kind}" if kind else nearest(name, self.joints)
            self._note(f"model.{word}: there is no joint '{name}'; {hint}")
            return
        if name in self.connections:
            self._note(f"{where} '{name}': it comes and goes already; give all in one call.")
        bodies = {body.name for body in self.joints[name].bodies} - {"ground"}
        late = [scene.name for scene in self.scenes.values() if bodies <= {*scene.bodies}]
        if late:
            self._note(f"{where} '{name}': declare it before scene '{late[0]}', where it acts.")
        if (released if acts_first else engaged) is None:
            self._note(f"{where} '{name}': when={shown(None)} is no condition; give one.")
        indicators = [
            None if when is None else self._read.gated(sympy.S.One, "", f"{where} '{name}'", when)
            for when in (released, engaged)
        ]
        released, engaged = indicators
        if None not in indicators:  # the condition of `until=` is the stronger one
            if acts_first:
                released *= 1 - engaged
            else:
                engaged *= 1 - released
        self.connections[name] = Connection(name, acts_first, released, engaged)

    def _connected_at_first(self) -> tuple[str, ...]:
        return tuple(name for name, one in self.connections.items() if one.acts_first)

    def _present(
        self, bodies: tuple[str, ...], absent: tuple[str, ...], among: Iterable[str] | None = None
    ) -> tuple[str, ...]:
        """Joints `among` others, or that come and go, with these bodies and without the absent."""
        known = {"ground", *bodies}
        return tuple(
            name
            for name in (self.connections if among is None else among)
            if name not in absent and {body.name for body in self.joints[name].bodies} <= known
        )

    def _connecting(self, scene: Scene) -> Iterator[sympy.Expr]:
        """What joints that come and go contain in a scene: conditions, coordinates of joints.

        The conditions are those that it watches, and later ones whose joints act by now. What they
        count is counted throughout a run, also while they do not act.
        """
        acting = {*self._present(scene.bodies, scene.inactive_joints, self.joints)}
        gone = {*self.connections} - {*scene.connected}
        for name in self._present(scene.bodies, scene.request.without):
            one = self.connections[name]
            watched = one.released if name in scene.connected else one.engaged
            for indicator in filter(None, (one.released, one.engaged)):
                if indicator is watched or not owners(indicator) & gone:
                    yield indicator
            with suppress(ModelError):  # reported by `build`
                statement = statement_of(self.joints[name])
                parts = sympy.Tuple(*statement.phi, *statement.bindings.values())
                yield from (q for q in kinds(parts, Coordinate) if owners(q) <= acting)

    def _changes(
        self, present: tuple[str, ...], connected: tuple[str, ...]
    ) -> Iterator[tuple[tuple[str, ...], tuple[str, ...]]]:
        """Joints that may change at one instant where `connected` act, and what acts afterwards.

        First each of them alone.
        """
        may = []
        for name in present:
            one = self.connections[name]
            if (one.released if name in connected else one.engaged) is not None:
                may.append(name)
        for count in range(1, len(may) + 1):
            for changed in combinations(may, count):
                after = {*connected} ^ {*changed}
                yield changed, tuple(joint for joint in self.connections if joint in after)

    def _reachable(
        self, present: tuple[str, ...], connected: tuple[str, ...]
    ) -> list[tuple[str, ...]]:
        """All sets of joints that may act in a run, those at its start first."""
        found = [connected]
        for known in found:  # which grows meanwhile
            found += [c for _, c in self._changes(present, known) if c not in found]
        return found

    def _connected_name(
        self, name: str, present: tuple[str, ...], connected: tuple[str, ...]
    ) -> str:
        """Name of a scene's sibling in which other joints act."""
        first = {*self._connected_at_first()}
        gone = [n for n in present if n in first - {*connected}]
        come = [n for n in present if n in {*connected} - first]
        name += f"_without_{'_'.join(gone)}" if gone else ""
        return name + (f"_with_{'_'.join(come)}" if come else "")
