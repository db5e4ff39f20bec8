"""Accelerations, wrenches and efforts of random mechanisms in space, by the lowered equations.

The reference are Newton's and Euler's equations of `SpatialDense`, at the drawing and on the way.
"""

import pytest

from tests.random_mechanisms.spatial_generator import OTHER, random_spatial_mechanism
from tests.random_mechanisms.spatial_statics import Statics

SEEDS: dict[tuple[str | None, str | None], tuple[int, ...]] = {
    ("tree", "free"): (0, 1, 2, 3, 4, 5),
    ("tree", "partly"): (3, 4),
    ("tree", "wholly"): (1,),
    ("one loop", "free"): (0, 2, 3, 5, 9),
    ("two loops", "free"): (2, 14),
    (OTHER, None): (2, 4, 8, 11, 17),
    (None, None): (1, 2, 4, 6, 8, 16, 17),  # one to three loops; but for 17, some rows follow
}
CASES = [(seed, *kind) for kind, seeds in SEEDS.items() for seed in seeds]


@pytest.mark.parametrize(("seed", "family", "driven"), CASES)
def test_kernels_agree_with_newton_and_euler(
    seed: int, family: str | None, driven: str | None
) -> None:
    machine = random_spatial_mechanism(seed, family, driven)
    statics = Statics(machine)
    assert [*statics.complaints(statics.states(2))] == []
