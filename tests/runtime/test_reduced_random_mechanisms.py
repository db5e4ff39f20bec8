"""A sample of `tests.random_mechanisms.reduced_runs`."""

from pathlib import Path

import pytest

from tests.random_mechanisms import Scales, random_mechanism
from tests.random_mechanisms.reduced_runs import compare

PASSING = (4, 9)
"""Seeds of mechanisms that pass dead centres of their loops."""


@pytest.mark.parametrize("seed", PASSING)
def test_reduced_runs_pass_dead_centres(seed: int, workshop: Path) -> None:
    """They end where those in all coordinates do, with the same motion."""
    found = compare(random_mechanism(seed, scales=Scales()), 4.0, workshop)
    assert found.verdict == "ok", str(found)
    assert found.changes > 0
    assert found.reached > 2.0
