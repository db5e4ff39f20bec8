"""Section 5.3: Hoeken's linkage against the linkage in closed form, and its lock-up."""

from math import acos, pi
from pathlib import Path

import numpy as np
import pytest

from models.studies.drawing import draw
from models.studies.four_bar import SPEED, TORQUE, linkage, study, table, tracer
from models.studies.four_bar_figures import figures
from models.studies.linkage import FourBar
from runtime import Outcome, load
from tests.models.linkages import check_even, check_motion, check_power, check_slopes, loop_gap


def test_the_closed_form_closes() -> None:
    check_slopes(linkage())
    assert loop_gap(linkage(), np.linspace(0, 2 * pi, 1001)) < 1e-14


def test_it_moves_as_trigonometry_says() -> None:
    run = study().turn
    assert run.outcome is Outcome.OK
    check_motion(run, linkage(), SPEED)
    assert np.abs(tracer(run).at - linkage().point(1, 5.0, SPEED * run.t).at).max() < 1e-10


def test_the_line_is_met_at_three_angles() -> None:
    height = tracer(study().turn).at.imag
    assert np.abs(height[[180, 360, 540]] - 4.0).max() < 1e-12
    assert height[180:541].min() > 4.0 - 1e-12


@pytest.mark.parametrize("speed", [0.1, SPEED, 100.0])
def test_the_driver_pays_for_kinetic_energy_and_weight(speed: float) -> None:
    machine = load("four_bar", "inverse_dynamics")
    instants = np.linspace(0.0, 2 * pi / speed, 361)
    run = machine.inverse_dynamics(instants, parameters={"drive_speed": speed})
    check_motion(run, linkage(), speed)
    check_power(run, linkage(), speed)


def test_a_constant_torque_turns_it_against_gravity() -> None:
    run = study().even
    assert run.outcome is Outcome.OK
    check_even(run, linkage(), TORQUE)


@pytest.mark.parametrize(
    "bars", [{"BC": 1.4, "CD": 1.4}, {"BC": 1.2, "CD": 1.5}, {"BC": 1.9, "CD": 1.05}]
)
def test_against_grashof_the_crank_locks_where_the_law_of_cosines_says(
    bars: dict[str, float],
) -> None:
    lengths = sorted((1.0, 2.0, *bars.values()))
    assert lengths[0] + lengths[3] > lengths[1] + lengths[2]
    machine = load("four_bar", "kinematics")
    run = machine.kinematics(np.linspace(0, 1, 361), parameters=bars)
    assert run.outcome is Outcome.LOCKED
    exact = FourBar(0, 2, 1.0, bars["BC"], bars["CD"], 1)
    angle = exact.locks()
    assert abs(run.q("crank.phi")[-1] - angle) < 1e-8
    assert abs(run.t[-1] - angle / (2 * pi)) < 1e-8
    said = float(run.message.partition("Locked up at t = ")[2].partition(" s:")[0])
    assert abs(said - angle / (2 * pi)) < 1e-8
    assert "driver crank_drive cannot go on" in run.message
    for joint in "ABCD":
        assert joint in run.message.partition("joints ")[2].partition(" stand")[0]
    # Until there it moves as the closed form says.
    phi = 2 * pi * run.t[:-1]
    assert np.abs(run.q("rocker.phi")[:-1] - exact.angle(2, phi).at).max() < 1e-10


def test_by_grashof_no_lock_up_is_found() -> None:
    assert np.isnan(linkage().locks())
    for bar in (1.51, 2.0, 10.0):
        machine = load("four_bar", "kinematics")
        run = machine.kinematics(np.linspace(0, 1, 181), parameters={"BC": bar, "CD": bar})
        assert run.outcome is Outcome.OK
        check_motion(run, linkage(bar), SPEED)


def test_a_linkage_locks_folded_too() -> None:
    """B may not come nearer to D than BC - CD: the crank stops on its way to them."""
    exact = FourBar(0, 2, 1.0, 2.9, 1.2, 1)
    begun = {"crank.x": -0.5, "coupler.x": 1.66, "coupler.y": 1.15, "coupler.phi": 0.41,
             "rocker.x": 1.83, "rocker.y": 0.58, "rocker.phi": 1.86}  # fmt: skip
    run = load("four_bar", "kinematics").kinematics(
        np.linspace(0.5, 1.0, 181), parameters={"BC": 2.9, "CD": 1.2}, guess=begun, t_start=0.5
    )
    assert run.outcome is Outcome.LOCKED
    assert abs(run.q("crank.phi")[-1] - (2 * pi - exact.locks())) < 1e-8
    assert abs(exact.locks() - acos((1 + 4 - 1.7**2) / 4)) < 1e-15


def test_ours_is_the_exact_value() -> None:
    rows = table()
    assert len(rows) == 9
    for row in rows:
        assert row.ours == pytest.approx(row.exact, rel=1e-9), row


def test_the_figures_are_written(tmp_path: Path) -> None:
    written = draw(figures(), tmp_path)
    assert len(written) == 6
    assert "locked at φ₁ = 135.2349°" in (tmp_path / "figure_5_3_3.svg").read_text()
