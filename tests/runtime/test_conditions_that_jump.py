"""Conditions whose quantity jumps through zero, as the rate of a length that vanishes."""

from math import exp
from pathlib import Path

import numpy as np
import pytest
from sympy import Abs, Piecewise, sqrt

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate.recording_buffers import Recording
from runtime.machine_facade import Machine

RATE = 2.0  # N s/m, of a line that is taut where it lengthens, over 1 kg


@pytest.fixture(scope="module")
def line(workshop: Path) -> Machine:
    model = Model("line_past_its_anchor")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    model.spring(
        "line", model.ground.at(0, 0), block,
        force=lambda _, speed: Piecewise((RATE * speed, speed > 0), (0, True)),
    )  # fmt: skip
    model.scene("s", ["line"], start={block.vx: 1.0}, guess={block.x: -1.0})
    return load(model, "s", folder=workshop)


@pytest.mark.parametrize("start", [-1.0, -1.01])
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "bdf"])
def test_a_length_that_passes_zero_changes_the_sign_of_its_rate(
    line: Machine, start: float, method: str
) -> None:
    """The rate of |x| goes from -1 to 1 m/s and is never 0."""
    run = line.simulate(3.0, start={"block.x": start}, method=method, progress=False)
    assert run.outcome is Outcome.OK
    assert [event.time for event in run.events] == [pytest.approx(-start, abs=1e-9)]
    ended = (1 - exp(-RATE * (3.0 + start))) / RATE
    assert run.q("block.x")[-1] == pytest.approx(ended, abs=1e-7)


def test_a_rate_of_the_wrong_sign_is_an_event_missed(
    line: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside the place where it jumps, and where it is as large as ever, tolerances explain it."""
    recorded = Recording.samples

    def never_on(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        times, y, modes = recorded(recording)
        return times, y, 0 * modes

    monkeypatch.setattr(Recording, "samples", never_on)
    run = line.simulate(3.0, progress=False)
    assert run.outcome is Outcome.CONTRADICTED
    assert "an event was missed" in run.message


def test_an_end_that_moves_fast_in_a_piece_of_time_is_seen(workshop: Path) -> None:
    """The end of the damper goes 0.1 m in 1 ms; before, that piece of it passes the block."""
    model = Model("line_whose_end_ramps")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    end = Piecewise((-1.0, t < 1), (-1 - 100 * (t - 1), t < 1.001), (-1.1, True))
    model.spring(
        "line", model.ground.at(end, 0), block,
        force=lambda _, speed: Piecewise((20 * speed, speed > 0), (0, True)),
    )  # fmt: skip
    model.scene("s", ["line"], start={block.x: 0.0, block.vx: 0.0})
    run = load(model, "s", folder=workshop).simulate(1.5, progress=False)
    assert run.outcome is Outcome.OK
    pulled = 1 - exp(-0.02)  # of the speed of the end
    moved = -100 * (0.001 - pulled / 20) - 100 * pulled * 0.499
    assert run.q("block.x")[-1] == pytest.approx(moved, abs=1e-7)


@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_a_quantity_that_has_a_number_on_one_side_alone(workshop: Path, method: str) -> None:
    """Pieces of |x - 1.3| make conditions of a root, which has none before."""
    model = Model("pushed_by_a_root")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    beyond = block.x - 1.3
    model.force("push", block, fx=0.7, when=beyond / sqrt(Abs(beyond)) > 0)
    model.scene("s", ["push"], start={block.x: 0.0, block.vx: 1.0})
    run = load(model, "s", folder=workshop).simulate(4.0, method=method, progress=False)
    assert run.outcome is Outcome.OK
    assert run.q("block.x")[-1] == pytest.approx(4.0 + 0.7 * 2.7**2 / 2, abs=1e-7)
