"""No run is OK that a check at its end contradicts; angles without digits are refused."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import AssemblyError
from runtime.core.outcomes import Outcome
from runtime.dynamics import end_checks
from runtime.integrate.trajectory import Trajectory
from runtime.machine_facade import Machine


@pytest.mark.parametrize("power", [8, 10, 12, 14, 16])
def test_angles_whose_sine_has_no_digits_are_refused(pendulum: Machine, power: int) -> None:
    angle = next(row for row in pendulum.description.coordinates if not row.is_length)
    with pytest.raises(AssemblyError, match=rf"{angle.name} is 1e\+{power:02d} rad"):
        pendulum.simulate(1.0, guess={angle.name: 10.0**power})


@pytest.mark.parametrize("power", [3, 5, 7])
def test_angles_with_digits_keep_their_joints(pendulum: Machine, power: int) -> None:
    angle = next(row for row in pendulum.description.coordinates if not row.is_length)
    run = pendulum.simulate(1.0, guess={angle.name: 10.0**power})
    assert run.outcome is Outcome.OK
    assert run.samples.residual[:, 0].max() < 1e-8


def test_run_with_broken_joints_is_not_ok(pendulum: Machine) -> None:
    """A state handed over, which assembly has not seen, may have an angle of any size."""
    begin = pendulum.assemble()
    turns = np.where(pendulum.description.is_length, 0.0, 1e12)
    run = pendulum.simulate(0.5, start=replace(begin, q=begin.q + turns))
    assert run.outcome is Outcome.CONTRADICTED
    assert "constraints are not satisfied" in run.message
    assert "too few digits" in run.message


@pytest.mark.parametrize("correction", ["step", "projection", "baumgarte", "hybrid"])
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10])
def test_right_runs_are_not_contradicted(free: Machine, correction: str, rtol: float) -> None:
    run = free.simulate(1.0, rtol=rtol, correction=correction, method="dopri5")
    assert run.outcome is Outcome.OK


def test_run_whose_events_go_back_is_not_ok(gas: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Trajectory] = []

    def shuffled(run: Trajectory) -> str:
        seen.append(run)
        events = replace(run.events, t=run.events.t[::-1])
        return order(replace(run, events=events))

    order: Callable[[Trajectory], str] = end_checks._order_of_events
    monkeypatch.setattr(end_checks, "_order_of_events", shuffled)
    run = gas.simulate(1.0, guess={"crank.omega": 30.0})
    assert len(seen[0].events.t) > 1
    assert run.outcome is Outcome.CONTRADICTED
    assert "not in order" in run.message
