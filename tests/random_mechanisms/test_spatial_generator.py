"""Random mechanisms in space: closed at the drawing, solvable, the same in any process."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_generator import (
    DRIVEN,
    FAMILIES,
    RandomSpatialMechanism,
    random_spatial_mechanism,
)
from tests.random_mechanisms.spatial_motion import motion

SEEDS = 9
FINGERPRINT = (
    "from tests.random_mechanisms.test_spatial_generator import fingerprint; print(fingerprint(1))"
)


def fingerprint(seeds: int) -> str:
    """Of the first mechanisms, to the last digit."""
    text = "".join(repr(random_spatial_mechanism(seed).parts) for seed in range(seeds))
    return hashlib.sha256(text.encode()).hexdigest()


@pytest.fixture(scope="module")
def machines() -> list[RandomSpatialMechanism]:
    """The families in turn."""
    return [random_spatial_mechanism(k, FAMILIES[k % len(FAMILIES)]) for k in range(SEEDS)]


def test_states_meet_the_constraints_and_the_equations(
    machines: list[RandomSpatialMechanism],
) -> None:
    """Φ = 0, J v = ν, J a = γ, M a + Jᵀ λ = Q, at the drawing and on the way."""
    for machine in machines:
        dense = SpatialDense(machine.parts)
        assert np.abs(dense.system(dense.at_drawing, 0.0).phi).max(initial=0.0) < 1e-13
        for t, state in machine.states(2):
            solved = dense.solve(state, t)
            e = solved.system
            assert len(e.jacobian) - e.rank == machine.redundant
            assert 6 * dense.n - e.rank == machine.freedoms
            velocity = np.concatenate([state.v, state.w], axis=1).ravel()
            a = np.concatenate([solved.r, solved.w], axis=1).ravel()
            residuals = (
                e.phi, e.jacobian @ velocity - e.nu, e.jacobian @ a - e.gamma,
                e.mass @ a + e.jacobian.T @ solved.lam - e.force,
            )  # fmt: skip
            assert max(np.abs(r).max(initial=0.0) for r in residuals) < 1e-9


def test_reactions_hold_every_body_by_newton_and_euler(
    machines: list[RandomSpatialMechanism],
) -> None:
    """The wrenches of all joints, and the applied ones, give the accelerations."""
    for machine in machines:
        dense = SpatialDense(machine.parts)
        solved = dense.solve(machine.state)
        a = np.concatenate([solved.r, solved.w], axis=1).ravel()
        missing = (solved.system.mass @ a - solved.system.force).reshape(-1, 6)
        for joint in machine.parts.joints:
            reaction = dense.reaction(joint.name, machine.state, solved)
            of = joint
            if isinstance(joint, parts.AngleDriver | parts.SlideDriver):
                of = machine.parts.joint(joint.joint)
            ends = (
                [(of.body, 1.0)]
                if isinstance(of, parts.PointDriver)
                else [(of.j, 1.0), (of.i, -1.0)]
            )  # type: ignore[attr-defined]
            for body, sign in ends:
                if body != parts.GROUND:
                    arm = reaction.point - machine.state.r[body]
                    moment = reaction.torque + np.cross(arm, reaction.force)
                    missing[body] -= sign * np.concatenate([reaction.force, moment])
        np.testing.assert_allclose(missing, 0.0, atol=1e-9)


def test_all_kinds_come(machines: list[RandomSpatialMechanism]) -> None:
    """Every family and drive, with and without redundant rows, every joint."""
    assert {m.family for m in machines} == {*FAMILIES}
    assert {m.driven for m in machines} == {*DRIVEN}
    assert {m.redundant > 0 for m in machines} == {True, False}
    kinds = {type(joint) for m in machines for joint in m.parts.joints}
    assert len(kinds) == 11, kinds


def test_a_hash_seed_changes_nothing(root: Path) -> None:
    """Two processes with other hash seeds make the same mechanisms as this one."""
    environment = os.environ | {"PYTHONHASHSEED": "4711"}
    command = [sys.executable, "-c", FINGERPRINT]
    answer = subprocess.run(
        command, cwd=root, env=environment, capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == fingerprint(1)


@pytest.mark.parametrize("seed", [1, 5])
def test_motions_converge(seed: int) -> None:
    """A tolerance a hundred times larger changes little."""
    machine = random_spatial_mechanism(seed)
    dense, span = SpatialDense(machine.parts), [0.0, machine.horizon]
    one, other = (motion(dense, machine.state, span, rtol)[-1] for rtol in (1e-12, 1e-10))
    np.testing.assert_allclose(one.r, other.r, atol=1e-8)
    np.testing.assert_allclose(one.R, other.R, atol=1e-8)
    assert np.abs(dense.system(one, span[1]).phi).max() < 1e-13
