"""Simulations with an accuracy target, measured: errors and counts, no seconds."""

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks import accuracy_targets, accuracy_targets_report, single_runs
from benchmarks.report import records
from runtime import load
from runtime.accuracy_target.runs import Quantities
from runtime.results.samples import plain


@pytest.fixture(scope="module")
def rows(request: pytest.FixtureRequest) -> list[accuracy_targets.Row]:
    """A bar that swings, built in a folder of its own."""
    folder: Path = request.config.cache.mkdir("benchmarks-asked")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(single_runs, "METHODS", ("dop853", "dopri5"))
        scenes = [("hard/pendulum", "bar", 10.0)]
        return list(
            accuracy_targets.measure(
                scenes, (1e-3, 1e-6, 1e-9), folder, 1, single_runs.GRID[2:20:2]
            )
        )


def test_true_errors_are_below_the_target(rows: list[accuracy_targets.Row]) -> None:
    assert [row.asked for row in rows] == [1e-3, 1e-6, 1e-9]
    for row in rows:
        assert row.counted
        assert row.true <= row.asked
        assert row.ratio == row.true / row.asked
        assert row.runs in {2, 3}
        assert row.horizon == 10.0
    assert rows[0].rtol > rows[1].rtol > rows[2].rtol


def test_the_cheapest_run_is_one_that_is_as_accurate(rows: list[accuracy_targets.Row]) -> None:
    row = rows[1]
    method, formulation, rtol = row.setting.split(", ")
    assert method in {"dop853", "dopri5"}
    assert formulation in single_runs.FORMULATIONS
    assert 1e-13 <= float(rtol) <= 1e-4


def test_sentences_follow_from_the_rows(rows: list[accuracy_targets.Row]) -> None:
    right, price, *rest = accuracy_targets_report.sentences(rows)
    assert right.startswith("The true error is below the target in 3 of 3 runs (100.0 %")
    assert "times the cheapest single run in the median" in price
    assert rest == []
    lost = replace(rows[2], outcome="INACCURATE", ratio=math.nan, cost=math.nan)
    vague = replace(rows[1], floor=1e-5)
    *_, ended, unknown = accuracy_targets_report.sentences([rows[0], lost, vague])
    assert "bar at 1e-09 (INACCURATE)" in ended
    assert unknown.endswith("agree no better: 1 of the runs.")
    assert "null" in json.dumps(plain(records([lost])), allow_nan=False)


def test_every_scene_that_is_measured_is_there() -> None:
    for model, scene, t_end in accuracy_targets.SCENES:
        assert t_end > 0.0
        assert load(model, scene).description.has_masses


def test_a_reference_that_ends_early_confirms_nothing() -> None:
    """Up to where it ended the two may agree; of what follows nobody knows."""
    t = np.linspace(0.0, 1.0, 5)
    none = np.zeros(0)
    quantities = Quantities(("x",), np.ones(1), np.zeros(1, dtype=np.int64))

    def run(count: int, failed: bool) -> Any:
        return SimpleNamespace(
            t=t[:count], failed=failed, series=lambda name: (np.sin(t[:count]), none)
        )

    whole, early = run(5, False), run(3, True)
    assert accuracy_targets.reference_difference(whole, whole, quantities) == 0.0
    assert accuracy_targets.reference_difference(whole, early, quantities) == np.inf
    assert accuracy_targets.reference_difference(early, whole, quantities) == np.inf
    assert accuracy_targets.reference_difference(whole, None, quantities) == np.inf
