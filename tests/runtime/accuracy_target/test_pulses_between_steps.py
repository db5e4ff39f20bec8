"""Forces that act for an instant: two runs that step over one agree to the last digit."""

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from codegen.generated_files.generated_file import write_if_changed
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

TEXT = """
from sympy import exp

from codegen import Model, t

model = Model("pulse")
instant = model.parameter("instant", 50.0, unit="s")
p = model.body("p", mass=2.0, inertia=1.0)
slow = model.body("slow", mass=1.0, inertia=1.0)
model.translational("guide", model.ground, p, axis=(1, 0))
model.translational("other_guide", model.ground, slow, axis=(0, 1))
model.force("pulse", p.at(0, 0), 10 * exp(-((10 * (t - instant)) ** 2)))
model.spring("spring", model.ground.at(0, -1), slow, 0.01, free_length=1.5)
start = {p.x: 0.0, p.vx: 0.0, slow.y: 0.0, slow.vy: 0.0}
model.scene("alone", ["pulse"], start=start)
model.scene("beside", ["pulse", "spring"], start=start)
"""


def machine(workshop: Path, scene: str) -> Machine:
    path = workshop / "models" / "pulse.py"
    write_if_changed(path, TEXT)
    return load(path, scene, folder=workshop)


@pytest.mark.parametrize("scene", ["alone", "beside"])
def test_a_pulse_between_the_steps_of_both_runs_is_found(workshop: Path, scene: str) -> None:
    found = machine(workshop, scene).simulate(100.0, accuracy=1e-6, progress=False)
    assert found.outcome is Outcome.OK
    gained = 10.0 * 0.1 * sqrt(pi) / 2.0
    assert found.series("p.vx")[0][-1] == pytest.approx(gained, rel=1e-6)
    assert found.series("p.x")[0][-1] == pytest.approx(50.0 * gained, rel=1e-6)
    assert 0.0 < found.accuracy.estimated < 1e-6


def test_no_estimate_is_zero(workshop: Path) -> None:
    """Nothing moves before the pulse, and both runs say so exactly."""
    found = machine(workshop, "alone").simulate(10.0, accuracy=1e-6, progress=False).accuracy
    assert all(row.error > 0.0 for row in found.quantities)
    assert found.estimated > 0.0
    assert "alike in both, to the last digit, also with steps of at most 0.00" in found.means
    assert found.runs[-1].steps >= 1000
    assert np.isfinite(found.estimated)
