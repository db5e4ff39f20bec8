"""Accelerations, wrenches and efforts of a mechanism in space against Newton's and Euler's laws.

`Statics` takes them from the lowered equations, which the interpreter evaluates, and looks at what
the build found of redundant rows: at the drawing, on the motion, and elsewhere along the freedoms.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from codegen.driver import translate
from codegen.generated_files.generated_file import Clock
from codegen.lower.interpreter import evaluate
from runtime.mechanism.spins import spins
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import SpatialState
from tests.random_mechanisms.spatial_declaration import coordinates, declare
from tests.random_mechanisms.spatial_dynamics import (
    DenseError,
    SpatialDense,
    SpatialSolution,
    moved,
)
from tests.random_mechanisms.spatial_friction import friction, slide
from tests.random_mechanisms.spatial_generator import SOUND, RandomSpatialMechanism

MET = 1e-9  # of accelerations and reactions in a state that both are given
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
PLACES = 3  # positions along the freedoms
AWAY = 0.3  # m and rad: their distance from the drawing


def counted(dense: SpatialDense, state: SpatialState, solved: SpatialSolution) -> dict[str, Any]:
    """Joint coordinate → its value, rate and second rate, by the dense equations."""
    e, found = solved.system, dict[str, Any]()
    v, a = (np.hstack(pair).ravel() for pair in ((state.v, state.w), (solved.r, solved.w)))

    def add(name: str, of: Any, row: int) -> None:
        by = of.by[row, :-1].ravel()
        found[name] = of.value[row], by @ v, by @ a + of.second[row]

    for k, joint in enumerate(dense.layout.angles):
        add(f"{joint}.angle", e.turns, k)
    for driver in dense.mechanism.joints:
        if isinstance(driver, parts.SlideDriver):
            add(f"{driver.joint}.slide", e.scalars, dense.layout.rows[driver.name].start)
        if isinstance(driver, parts.Rack):  # on which the slide is the ratio times the angle
            angle = found[f"{driver.joint}.angle"]
            found[f"{driver.driven}.slide"] = tuple(driver.ratio * x for x in angle)
    for law in dense.frictions:
        joint: Any = dense.mechanism.joint(law.joint)
        if not isinstance(joint, parts.Revolute):
            add(f"{law.joint}.slide", slide(dense.layout, joint, state), 0)
    return found


def differences(
    dense: SpatialDense, state: SpatialState, t: float, p: Any, a: Any,
    rows: Sequence[Any], reaction: Callable[[str, str], float],
) -> Iterator[float]:  # fmt: skip
    """Of accelerations (n, 7) and of wrenches and forces, and what is missing in Newton's law.

    Parts of the largest value, or of 1. `p` are the Euler parameters, (n, 4), and `rows`
    are those of the module's reactions.
    """
    solved = dense.solve(state, t)
    spin = spins(p, a[:, 3:])
    size = max(1.0, float(np.abs([solved.r, solved.w]).max()))
    yield float(np.abs(a[:, :3] - solved.r).max()) / size
    yield float(np.abs(spin - solved.body_w).max()) / size
    e = solved.system
    accelerations = np.concatenate([solved.r, solved.w], axis=1).ravel()
    missing = (e.mass @ accelerations - e.force).reshape(-1, 6)
    largest = max(1.0, float(np.abs(e.jacobian.T @ solved.lam).max()))
    for joint in dense.mechanism.joints:
        known = dense.reaction(joint.name, state, solved)
        if isinstance(joint, parts.ALONG):
            (component,) = (row[1] for row in rows if row[0] == joint.name)
            force = reaction(joint.name, component)
            row = dense.layout.rows[joint.name].start
            missing -= force * e.jacobian[row].reshape(-1, 6)
            if known.determined.all():
                effort = dense.effort(joint.name, solved)
                largest = max(largest, abs(effort))
                yield abs(force - effort) / largest
            continue
        wrench = np.array([reaction(joint.name, c) for c in WRENCH])
        expected = np.concatenate([known.force, known.torque])
        largest = max(largest, float(np.abs(wrench).max()))
        yield float(np.abs((wrench - expected)[known.determined]).max(initial=0.0)) / largest
        for body, sign in ((joint.j, 1.0), (joint.i, -1.0)):
            if body != parts.GROUND:
                moment = wrench[3:] + np.cross(known.point - state.r[body], wrench[:3])
                missing[body] -= sign * np.concatenate([wrench[:3], moment])
    yield float(np.abs(missing).max()) / largest
    for law in dense.frictions:
        by = dense.reaction(law.joint, state, solved)
        _, told = friction(dense.layout, law, state, by.force, by.torque)
        hinge = isinstance(dense.mechanism.joint(law.joint), parts.Revolute)
        yield abs(reaction(law.name, "torque" if hinge else "force") - told) / largest


class Statics:
    """The lowered equations of a machine beside the dense ones."""

    def __init__(self, machine: RandomSpatialMechanism) -> None:
        self.machine = machine
        self.dense = SpatialDense(machine.parts)
        model = declare(self.dense.mechanism, f"space_{machine.seed}")
        clock = Clock({}, lambda stage: None, model.name)
        _, self.lowered, self.findings = translate(model, model.scenes["run"], clock)

    def states(self, on_motion: int) -> list[tuple[float, SpatialState]]:
        """Consistent states with their instants: on the motion, and elsewhere at t = 0."""
        found = self.machine.states(on_motion)
        start, rank = found[0][1], 6 * self.dense.n - self.machine.freedoms
        for k in range(PLACES if self.machine.freedoms else 0):
            way = self.dense.random_velocity(k)
            step = np.concatenate([way.v, way.w], axis=1).ravel()
            step *= AWAY / np.abs(step).max()
            try:
                place = self.dense.closed(moved(start, step), 0.0, rank)
            except DenseError:
                continue
            if self.dense.least_singular_value(place, rank) > SOUND:
                found.append((0.0, place))
        return found

    def complaints(self, states: list[tuple[float, SpatialState]]) -> Iterator[str]:
        """All that differs at states by more than rounding."""
        found = self.findings.degrees_of_freedom, len(self.findings.dependent)
        for k, (t, state) in enumerate(states):
            known = self.dense.freedoms(state, t)
            if found != known:
                yield f"state {k}: freedoms and redundant rows are {found}, not {known}"
            apart = self.difference(state, t)
            if not apart < MET:
                yield f"state {k}: {apart:.1e} apart"

    def difference(self, state: SpatialState, t: float) -> float:
        """The largest difference at a state, of residuals, accelerations or reactions."""
        q, v = coordinates(state)
        bodies, own = len(q), counted(self.dense, state, self.dense.solve(state, t))
        names = [row[0] for row in self.lowered.description.coordinates][bodies:]
        assert {*names} == {*own}
        places, rates, seconds = np.array([own[name] for name in names]).reshape(-1, 3).T
        q, v = np.append(q, places), np.append(v, rates)
        arguments = {"t": t, "q": q.tolist(), "v": v.tolist(), "p": [], "modes": []}

        def written(kernel: str) -> dict[str, Any]:
            out = evaluate(self.lowered.program, kernel, arguments, math)
            return {name: np.array([x[k] for k in range(len(x))]) for name, x in out.items()}

        phi = np.abs(written("constraints")["phi"]).max()
        solved = written("accelerations")
        a, arguments["lam"] = solved["a"], solved["lam"].tolist()
        own_apart = np.abs(a[bodies:] - seconds).max(initial=0.0) / max(1.0, np.abs(a).max())
        a = a[:bodies].reshape(-1, 7)
        p, rates = (x[:bodies].reshape(-1, 7)[:, 3:] for x in (q, v))
        norm = np.abs(np.sum(p * a[:, 3:] + rates**2, axis=1)).max()  # of p, twice differentiated
        values = written("reactions").get("out", ())
        rows = self.lowered.description.reactions
        named = {row[:2]: k for k, row in enumerate(rows)}

        def reaction(joint: str, letter: str) -> float:
            return float(values[named[joint, letter]])

        return max(phi, norm, own_apart, *differences(self.dense, state, t, p, a, rows, reaction))
