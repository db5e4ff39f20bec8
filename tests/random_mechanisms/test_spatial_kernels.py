"""Accelerations, wrenches and efforts of random mechanisms in space, by the lowered equations.

The reference are Newton's and Euler's equations of `SpatialDense`, at the drawing and on the way.
"""

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen.driver import translate
from codegen.generated_files.generated_file import Clock
from codegen.lower.interpreter import evaluate
from runtime.mechanism.spins import spins
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import SpatialState
from tests.random_mechanisms.spatial_declaration import coordinates, declare
from tests.random_mechanisms.spatial_dynamics import SpatialDense, SpatialSolution
from tests.random_mechanisms.spatial_generator import random_spatial_mechanism

MET = 1e-9
SEEDS: dict[tuple[str | None, str | None], tuple[int, ...]] = {
    ("tree", "free"): (0, 1, 2, 3, 4, 5),
    ("tree", "partly"): (3, 4),
    ("tree", "wholly"): (1,),
    ("one loop", "free"): (0, 3, 5, 9),
    (None, None): (1, 2, 4, 6, 8, 16, 17),  # one to three loops; but for 17, some rows follow
}
CASES = [(seed, *kind) for kind, seeds in SEEDS.items() for seed in seeds]


@pytest.mark.parametrize(("seed", "family", "driven"), CASES)
def test_kernels_agree_with_newton_and_euler(
    seed: int, family: str | None, driven: str | None
) -> None:
    machine = random_spatial_mechanism(seed, family, driven)
    dense = SpatialDense(machine.parts)
    model = declare(machine.parts, f"space_{seed}")
    clock = Clock({}, lambda stage: None, model.name)
    _, lowered, findings = translate(model, model.scenes["run"], clock)
    freedoms, redundant = dense.freedoms(machine.state)
    assert len(findings.dependent) == redundant
    assert findings.degrees_of_freedom == freedoms
    for t, state in machine.states(2):
        check(dense, lowered, state, t)


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
    return found


def check(dense: SpatialDense, lowered: Any, state: Any, t: float) -> None:
    """Compare everything at one state."""
    solved = dense.solve(state, t)
    q, v = coordinates(state)
    own = counted(dense, state, solved)
    names = [row[0] for row in lowered.description.coordinates][len(q) :]
    assert {*names} == {*own}
    places, rates, seconds = np.array([own[name] for name in names]).reshape(-1, 3).T
    bodies, q, v = len(q), np.append(q, places), np.append(v, rates)
    arguments = {"t": t, "q": q.tolist(), "v": v.tolist(), "p": [], "modes": []}

    def written(kernel: str, *arrays: str) -> list[Any]:
        out = evaluate(lowered.program, kernel, arguments, math)
        return [np.array([out[name][k] for k in range(len(out[name]))]) for name in arrays]

    (phi,) = written("constraints", "phi")
    assert np.abs(phi).max() < 1e-12
    a, lam = written("accelerations", "a", "lam")
    size = MET * max(1.0, float(np.abs(a).max()))
    assert_allclose(a[bodies:], seconds, rtol=0.0, atol=size)
    a, arguments["lam"] = a[:bodies].reshape(-1, 7), lam.tolist()
    p, rates = (x[:bodies].reshape(-1, 7)[:, 3:] for x in (q, v))
    assert_allclose(np.sum(p * a[:, 3:] + rates**2, axis=1), 0.0, atol=MET)
    assert_allclose(a[:, :3], solved.r, rtol=0.0, atol=size)
    assert_allclose(spins(p, a[:, 3:]), solved.body_w, rtol=0.0, atol=size)
    (values,) = written("reactions", "out")
    found = {row[:2]: values[k] for k, row in enumerate(lowered.description.reactions)}
    for joint in dense.mechanism.joints:
        if isinstance(joint, parts.DRIVERS):
            ((component, effort),) = (
                (c, x) for (name, c), x in found.items() if name == joint.name
            )
            expected = dense.effort(joint.name, solved)
            assert effort == pytest.approx(expected, rel=MET, abs=MET), (joint.name, component)
            continue
        reaction = dense.reaction(joint.name, state, solved)
        expected = np.concatenate([reaction.force, reaction.torque])
        wrench = [found[joint.name, f"{w}{c}"] for w in "ft" for c in "xyz"]
        size = MET * max(1.0, float(np.abs(expected).max()))
        known = reaction.determined
        assert_allclose(
            np.array(wrench)[known], expected[known], rtol=0.0, atol=size, err_msg=joint.name
        )
