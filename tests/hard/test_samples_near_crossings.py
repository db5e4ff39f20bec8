"""Samples beside a singular position: no further off than rounding takes a state there."""

import numpy as np
import pytest

from runtime import load


@pytest.mark.parametrize("rtol", [1e-9, 1e-11, 1e-13])
def test_loops_that_stay_parallelograms(rtol: float) -> None:
    """All cranks turn alike, and the couplers do not turn at all."""
    machine = load("hard/n_four_bar", "fall")
    instant = machine.simulate(1.0, rtol=rtol, progress=False).singular[0].time
    apart = np.concatenate([[0.0], np.logspace(-6.0, -1.3, 41)])
    run = machine.simulate(1.0, np.unique([instant - apart, instant + apart]), rtol=rtol)
    tau = np.maximum(np.abs(run.t - instant), 2e-4)  # nearer, no further off than there
    for name in ("coupler_1", "coupler_2"):
        assert (np.abs(run.series(f"{name}.omega")[0]) < 1e-15 / tau**2).all()
        assert (np.abs(run.series(f"{name}.phi")[0]) < 1e-15 / tau).all()
    turned = run.series("crank_2.omega")[0] - run.series("crank_0.omega")[0]
    assert (np.abs(turned) < 1e-15 / tau**2).all()
