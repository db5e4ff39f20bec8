"""Accuracy targets where samples cut the steps: runs that are compared differ in their steps."""

from pathlib import Path

import numpy as np

from codegen import Model
from runtime import load


def test_runs_whose_steps_samples_bound_are_compared_with_shorter_steps(tmp_path: Path) -> None:
    model = Model("paced")
    arm = model.body("arm", mass=1.0, inertia=0.05)
    model.revolute("pin", model.ground.at(0, 0), arm.at(0, 0))
    torque = model.sampled("torque", 0.002, -2.0 * arm.phi - 0.1 * arm.omega, unit="N m")
    model.torque("drive", on=arm, value=torque)
    model.scene("turn", ["drive"], start={arm.phi: 1.0, arm.omega: 0.0})
    machine = load(model, folder=tmp_path)

    result = machine.simulate(0.4, 41, accuracy=1e-6)
    accuracy = result.accuracy
    assert accuracy is not None
    *_, other, delivered = accuracy.runs
    assert len(accuracy.runs) == 3
    assert delivered.rtol == other.rtol
    assert delivered.steps > 1.9 * other.steps
    assert "runs of two tolerances took the same steps" in accuracy.means
    exact = machine.simulate(0.4, 41, rtol=1e-13, max_step=2e-4)
    errors = np.abs(result.q("arm.phi") - exact.q("arm.phi"))
    assert errors.max() <= accuracy.estimated <= 1e-6
