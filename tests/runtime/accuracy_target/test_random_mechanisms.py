"""A sample of `tests.random_mechanisms.accuracy_runs`."""

from pathlib import Path

import numpy as np
import pytest

from runtime import load
from tests.random_mechanisms import Scales, accuracy_runs, random_mechanism

COST = 8.0  # right-hand sides of all runs, over those of the cheapest single one


@pytest.mark.parametrize(("seed", "horizons"), [(1, 1.0), (2, 1.0), (9, 2.0)])
def test_targets_are_met_at_a_bounded_cost(
    seed: int, horizons: float, workshop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(accuracy_runs, "METHODS", ("dop853", "dopri5"))
    mechanism = random_mechanism(seed, scales=Scales())
    machine = load(mechanism.model(), mechanism.scene, folder=workshop)
    targets = (1e-4, 1e-6)
    found = list(accuracy_runs.judge(machine, horizons * mechanism.horizon, targets, ["cartesian"]))
    assert [one.target for one in found] == list(targets)
    for one in found:
        assert one.met, str(one)
        assert np.isfinite(one.cost)
        assert one.cost <= COST, str(one)
