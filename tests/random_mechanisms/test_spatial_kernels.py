"""Accelerations, wrenches and efforts of random mechanisms in space, by the lowered equations.

The reference are Newton's and Euler's equations of `SpatialDense`, at the drawing and on the way.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen.derive.equations import derive
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import lower
from runtime.mechanism.spins import spins
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_declaration import UNDECLARED, coordinates, declare
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_generator import (
    RandomSpatialMechanism,
    random_spatial_mechanism,
)

MET = 1e-9
SEEDS = {  # of mechanisms without redundant rows
    ("tree", "free"): (0, 1, 2, 3, 4, 5, 6, 8, 9, 11),
    ("tree", "partly"): (3, 4, 8, 11),
    ("tree", "wholly"): (1,),
    ("one loop", "free"): (0, 3, 5, 9, 11, 12),
    ("two loops", "free"): (3,),
}
CASES = [(seed, *kind) for kind, seeds in SEEDS.items() for seed in seeds]


def without_angles(machine: RandomSpatialMechanism) -> parts.SpatialMechanism:
    """Its parts but those that need angles of joints."""
    joints = tuple(j for j in machine.parts.joints if not isinstance(j, UNDECLARED))
    effects = tuple(e for e in machine.parts.effects if not isinstance(e, UNDECLARED))
    return replace(machine.parts, joints=joints, effects=effects)


@pytest.mark.parametrize(("seed", "family", "driven"), CASES)
def test_kernels_agree_with_newton_and_euler(seed: int, family: str, driven: str) -> None:
    machine = random_spatial_mechanism(seed, family, driven)
    mechanism = without_angles(machine)
    dense = SpatialDense(mechanism)
    model = declare(mechanism, f"space_{seed}")
    lowered = lower(derive(model, model.scenes["run"]))
    for t, state in machine.states(2):
        check(dense, lowered, replace(state, turned=state.turned[:0]), t)


def check(dense: SpatialDense, lowered: Any, state: Any, t: float) -> None:
    """Compare everything at one state."""
    solved = dense.solve(state, t)
    assert len(solved.system.jacobian) == solved.system.rank
    q, v = coordinates(state)
    arguments = {"t": t, "q": q.tolist(), "v": v.tolist(), "p": [], "modes": []}

    def written(kernel: str, *arrays: str) -> list[Any]:
        out = evaluate(lowered.program, kernel, arguments, math)
        return [np.array([out[name][k] for k in range(len(out[name]))]) for name in arrays]

    (phi,) = written("constraints", "phi")
    assert np.abs(phi).max() < 1e-12
    a, lam = written("accelerations", "a", "lam")
    a, arguments["lam"] = a.reshape(-1, 7), lam.tolist()
    p, rates = q.reshape(-1, 7)[:, 3:], v.reshape(-1, 7)[:, 3:]
    assert_allclose(np.sum(p * a[:, 3:] + rates**2, axis=1), 0.0, atol=MET)
    size = MET * max(1.0, float(np.abs(a).max()))
    assert_allclose(a[:, :3], solved.r, rtol=0.0, atol=size)
    assert_allclose(spins(p, a[:, 3:]), solved.body_w, rtol=0.0, atol=size)
    (values,) = written("reactions", "out")
    found = {row[:2]: values[k] for k, row in enumerate(lowered.description.reactions)}
    for joint in dense.mechanism.joints:
        if isinstance(joint, parts.DRIVERS):
            continue
        reaction = dense.reaction(joint.name, state, solved)
        expected = np.concatenate([reaction.force, reaction.torque])
        wrench = [found[joint.name, f"{w}{c}"] for w in "ft" for c in "xyz"]
        size = MET * max(1.0, float(np.abs(expected).max()))
        assert_allclose(wrench, expected, rtol=0.0, atol=size, err_msg=joint.name)
