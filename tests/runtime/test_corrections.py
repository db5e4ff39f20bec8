"""Ways back onto the constraints: each keeps what it promises, and all move the machine alike."""

import numpy as np
import pytest

from codegen.errors import InputError
from runtime import load

ANGLE = "crank.phi"
KEPT = ("step", "stage", "projection", "hybrid")


@pytest.fixture(scope="module")
def machine():
    return load("four_bar", scene="constant_torque")


@pytest.fixture(scope="module")
def sharp(machine):
    run = machine.simulate(3.0, t_eval=np.linspace(0.0, 3.0, 31), rtol=1e-12, progress=False)
    return run.q(ANGLE)


def run_with(machine, correction, rtol=1e-9, **options):
    return machine.simulate(
        3.0, t_eval=np.linspace(0.0, 3.0, 31), rtol=rtol, correction=correction, progress=False,
        **options,
    )  # fmt: skip


@pytest.mark.parametrize("correction", [*KEPT, "baumgarte"])
def test_the_motion_is_the_same(machine, sharp, correction):
    options = {"time_scale": 0.02} if correction in ("baumgarte", "hybrid") else {}
    run = run_with(machine, correction, **options)
    error = np.abs(run.q(ANGLE) - sharp).max() / np.abs(sharp).max()
    assert error < 100 * 1e-9  # a step's tolerance, over some hundred steps


@pytest.mark.parametrize("correction", ["step", "stage", "projection"])
def test_corrected_steps_are_on_the_constraints(machine, correction):
    run = machine.simulate(3.0, rtol=1e-6, correction=correction, progress=False)
    assert run.samples.residual[:, 0].max() < 1e-13
    assert run.samples.residual[:, 1].max() < 1e-10


def test_hybrid_corrects_where_the_drift_exceeds_the_tolerance(machine):
    rtol = 1e-5
    run = machine.simulate(3.0, rtol=rtol, correction="hybrid", time_scale=10.0, progress=False)
    assert 0 < run.stats["returns"] < run.stats["steps"]
    assert run.samples.residual[:, 0].max() <= 2.0 * rtol


def test_baumgarte_drifts_and_pulls_back(machine):
    loose = machine.simulate(3.0, rtol=1e-5, correction="baumgarte", time_scale=3.0, progress=False)
    tight = machine.simulate(
        3.0, rtol=1e-5, correction="baumgarte", time_scale=0.03, progress=False
    )
    assert loose.stats["returns"] == tight.stats["returns"] == 1  # at the start
    drift = loose.samples.residual[:, 0].max(), tight.samples.residual[:, 0].max()
    assert drift[1] < 0.2 * drift[0]
    assert 1e-9 < drift[0] < 1e-1


def test_unknown_correction_is_refused(machine):
    with pytest.raises(InputError, match="correction = 'nudge' must be one of step, stage"):
        machine.simulate(1.0, correction="nudge", progress=False)


def test_every_choice_of_independent_coordinates_is_told(machine):
    run = machine.simulate(3.0, progress=False)
    assert len(run.partitions) == run.stats["repartitions"] + 1 > 20
    times = [choice.time for choice in run.partitions]
    assert times == sorted(times)
    names = {choice.independent for choice in run.partitions}
    assert all(len(chosen) == 1 and chosen[0] in machine.coordinates.names for chosen in names)
    for before, after in zip(run.partitions, run.partitions[1:], strict=False):
        assert before.independent != after.independent
