"""What contacts and frictions refuse, and what results say of them."""

from pathlib import Path

import numpy as np
import pytest

from codegen.errors import AnalysisError, InputError, ParameterError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from tests.hard.result_readings import held


@pytest.fixture
def ball() -> Machine:
    return load("hard/bouncing_ball", "dropped")


def test_overlap_at_the_start_names_contact_and_gap(ball: Machine) -> None:
    with pytest.raises(InputError, match=r"gap of 'plate' is -0\.01 in SI units: bodies overlap"):
        ball.simulate(1.0, start={"ball.y": 0.09})
    run = ball.simulate(1.0, start={"ball.y": 0.1 - 1e-11})
    assert held(run, "plate").all()


@pytest.mark.parametrize(("e", "shown"), [(1.2, "1.2"), (1.0000001, "1.0000001")])
def test_restitution_that_gains_is_refused(ball: Machine, e: float, shown: str) -> None:
    with pytest.raises(
        ParameterError, match=f"contact 'plate': the restitution restitution is {shown}"
    ):
        ball.simulate(1.0, parameters={"restitution": e})


def test_static_coefficient_below_the_kinetic_one_is_refused() -> None:
    machine = load("hard/belt_block")
    with pytest.raises(
        ParameterError, match=r"friction 'belt': the static coefficient static is 0\.1, below"
    ):
        machine.simulate(1.0, parameters={"static": 0.1})
    assert machine.simulate(1.0, parameters={"static": 0.2}).outcome is Outcome.OK


def test_analyses_that_know_no_contact_refuse(ball: Machine) -> None:
    with pytest.raises(AnalysisError, match="or stops are closed, and this scene has plate"):
        ball.equilibrium()
    with pytest.raises(AnalysisError, match="inverse dynamics does not decide"):
        ball.inverse_dynamics([0.0, 1.0])
    with pytest.raises(AnalysisError, match="friction in belt sticks"):
        load("hard/belt_block").equilibrium()


def test_results_hold_modes_and_shares(ball: Machine, tmp_path: Path) -> None:
    run = ball.simulate(2.0, np.linspace(0.0, 2.0, 21))
    (name,) = run.data["switch"].values
    assert name.startswith("plate: ")
    assert run.data["switch_kind"].values.tolist() == ["contact"]
    assert run.data["share"].dims == run.data["mode"].dims == ("time", "switch")
    # The typical force is the weight: nothing of it is left to the free fall.
    np.testing.assert_allclose(run.share("plate")[-3:], 0.0, atol=1e-12)
    assert run.mode(name).tolist() == run.data["mode"].values[:, 0].tolist()
    with pytest.raises(InputError, match=r"no condition 'plato'; nearest: plate"):
        run.share("plato")
    page = run.save(tmp_path / "ball.html").read_text()
    assert "plate touches" in page
    assert "plate rests" in page
