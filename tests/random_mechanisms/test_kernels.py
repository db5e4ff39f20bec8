"""Generated kernels of random mechanisms against dense algebra, in any units, masses far apart."""

from dataclasses import replace

import numpy as np
import pytest

from tests.random_mechanisms import FAMILIES, RandomMechanism, Scales, random_mechanism
from tests.random_mechanisms.dense_dynamics import Dense
from tests.random_mechanisms.kernel_comparison import Generated, differences

MET = 1e-10  # what accelerations, multipliers and reactions have to agree to
FAR_UNITS = [
    Scales(1e-12, 1.0, 1.0),
    Scales(1e12, 1.0, 1.0),
    Scales(1.0, 1e-12, 1.0),
    Scales(1.0, 1e12, 1.0),
    Scales(1e-6, 1e6, 1e-3),
]


def worst(machine: RandomMechanism) -> float:
    """The largest difference in the pose of the start; no constraint is taken for dependent."""
    generated, dense = Generated(machine), Dense(machine.parts, machine.scales.length)
    q, v = machine.q, machine.v
    order = [dense.names.index(name) for name in generated.names]
    a, lam = np.zeros(len(order)), np.zeros(len(generated.rows))
    modes = np.zeros(len(generated.module["SWITCHES"]), dtype=int)
    arguments = 0.0, q[order], v[order], generated.p, modes, a, lam
    assert generated.call("accelerations", *arguments) == 0
    return differences(machine, generated, dense, q, v, 0.0).worst


def remade(machine: RandomMechanism, mass: float, inertia: float) -> RandomMechanism:
    """The machine with every other body's mass and every inertia multiplied."""
    bodies = tuple(
        replace(
            body,
            mass=body.mass * (mass if k % 2 else 1.0),
            inertia=None if body.inertia is None else body.inertia * inertia,
        )
        for k, body in enumerate(machine.parts.bodies)
    )
    return replace(machine, parts=replace(machine.parts, bodies=bodies))


@pytest.mark.parametrize("family", FAMILIES)
def test_kernels_agree_with_dense_algebra(family: str) -> None:
    """With rubbing joints, stops, and whatever else the seeds bring."""
    friction = "sticking" if family in ("tree", "parallel") else None
    assert worst(random_mechanism(31, family, friction=friction, contacts="yielding")) < MET


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("scales", FAR_UNITS, ids=str)
def test_units_do_not_matter(scales: Scales, seed: int) -> None:
    """Nanometres and light minutes, attograms and megatons."""
    assert worst(random_mechanism(seed, scales=scales)) < MET


@pytest.mark.parametrize("inertia", [1e-12, 1e-6, 1e6, 1e12])
@pytest.mark.parametrize("mass", [1e-6, 1.0, 1e6])
def test_masses_far_apart_cost_no_digits(mass: float, inertia: float) -> None:
    """Point masses and flywheels: no pivot is weak, for all constraints are independent."""
    for seed in (1, 4):
        machine = random_mechanism(seed, driven="free", friction="none", scales=Scales())
        assert worst(remade(machine, mass, inertia)) < MET
