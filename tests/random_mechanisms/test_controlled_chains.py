"""Random chains with states, samples, latches and connections against dense matrices and SciPy.

Many more by hand: `python -m tests.random_mechanisms.controlled_chain_campaign 0 60`.
"""

from pathlib import Path

import numpy as np
import pytest

from tests.random_mechanisms.controlled_chain_campaign import judge, reference
from tests.random_mechanisms.controlled_chain_motion import ControlledMotion
from tests.random_mechanisms.controlled_chains import Lock, controlled_chain

SEEDS = {37: ["release"], 41: ["engage", "release", "unlock"], 77: [], 102: ["engage", "unlock"]}


@pytest.mark.parametrize("seed", SEEDS)
def test_a_controlled_chain_moves_as_its_equations_say(seed: int, tmp_path: Path) -> None:
    chain = controlled_chain(seed)
    motion = reference(chain)
    assert [word for _, word in motion.changes] == SEEDS[seed]
    assert judge(chain, tmp_path, ("dop853",), motion=motion) == []


def test_the_reference_keeps_its_joints_closed_and_its_energy() -> None:
    """Without dampers, motors and controllers the energy changes by the lock's impact alone."""
    chain = controlled_chain(41)
    plain = {"motor": None, "integral": None, "controller": None, "latch": None, "release": None}
    chain = type(chain)(**{**vars(chain), **plain, "damping": 0.0 * chain.damping,
                           "lock": Lock(0, chain.lock.angle, None)})  # fmt: skip
    times = np.linspace(chain.begin, chain.end, 200)
    motion = ControlledMotion(chain).run(times)
    ((engaged, word),) = motion.changes
    assert word == "engage"
    masses, n = np.column_stack([chain.mass, chain.mass, chain.inertia]).ravel(), 3 * chain.rods
    energies, behind = [], []
    for t, (y, _) in motion.samples.items():
        height = (chain.mass * y[1:n:3]).sum()
        energies.append((masses * y[n:-2] ** 2).sum() / 2 + 9.81 * height)
        behind.append(t > engaged)
        tip = chain.length[0] * np.array([np.cos(y[2]), np.sin(y[2])])
        assert np.abs(y[:2] - tip / 2).max() < 1e-8
    for side in (True, False):
        assert np.ptp(np.array(energies)[np.array(behind) == side]) < 1e-8
