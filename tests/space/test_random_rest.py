"""Random machines with springs: rest positions, and their energy, by the dense equations."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import minimize

from runtime import load
from runtime.core.outcomes import Outcome
from runtime.statics.equilibrium import METHODS, Stability
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_declaration import declare
from tests.random_mechanisms.spatial_dynamics import SpatialDense, moved
from tests.random_mechanisms.spatial_generator import random_spatial_mechanism
from tests.space.rotations import rotation


def sprung(seed: int, family: str) -> parts.SpatialMechanism:
    """Its gravity and springs, and two springs from the ground to each body."""
    mechanism = random_spatial_mechanism(seed, family, "free").parts
    random, kept = np.random.default_rng([seed, 77]), (parts.Gravity, parts.Spring)
    effects = [
        replace(e, damping=0.0, actuator=parts.REST) if isinstance(e, parts.Spring) else e
        for e in mechanism.effects
        if isinstance(e, kept)
    ]
    for k, body in enumerate(mechanism.bodies):
        for side in "ab":
            at = np.array(body.r) + 0.3 * random.normal(size=3)
            up = at + random.normal(size=3) + (0.0, 0.0, 1.0)
            stiffness, free = float(random.uniform(20, 80)), 0.6 * float(np.linalg.norm(up - at))
            ends: Any = tuple(up.tolist()), tuple(at.tolist())
            effects.append(parts.Spring(f"hold{k}{side}", parts.GROUND, k, *ends, stiffness, free))
    return replace(mechanism, effects=tuple(effects))


@pytest.mark.parametrize(("seed", "family"), [(6, "tree"), (9, "tree"), (4, "one loop")])
def test_rest_is_a_minimum_of_the_energy(seed: int, family: str, workshop: Path) -> None:
    mechanism = sprung(seed, family)
    dense = SpatialDense(mechanism)
    machine = load(declare(mechanism, f"rest_{seed}"), folder=workshop)
    for method in METHODS:
        rest = machine.equilibrium(method=method, progress=False)
        assert rest.outcome is Outcome.OK
        q = rest.samples.q[0].reshape(-1, 7)
        turned = np.array([rotation(p) for p in q[:, 3:]])
        state = replace(dense.at_drawing, r=q[:, :3], R=turned)
        at = dense.system(state, 0.0)
        assert np.abs(at.phi).max(initial=0.0) < 1e-12
        motions = null_space(at.jacobian, rcond=1e-8)
        assert np.abs(motions.T @ at.force).max() < 1e-12 * np.abs(at.force).max()

        def energy(x: Any, state: Any = state, motions: Any = motions) -> float:
            return dense.system(dense.closed(moved(state, motions @ x)), 0.0).potential

        pushed = np.random.default_rng(seed).normal(size=motions.shape[1]) * 1e-2
        least = minimize(energy, pushed, method="BFGS", options={"gtol": 1e-6})
        assert energy(pushed) > at.potential
        assert least.fun == pytest.approx(at.potential, rel=1e-9)
        assert np.abs(least.x).max() < 1e-5
        assert rest.stability is Stability.STABLE
