"""Projects 5.1 and 8.1: the film follower against the linkage in closed form."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from models.studies import film_follower
from models.studies.drawing import draw
from models.studies.film_follower import INERTIAS, SPEED, TORQUE, linkage, study, table
from models.studies.film_follower_figures import figures
from runtime import Outcome, load
from tests.models.linkages import (
    check_even,
    check_motion,
    check_power,
    check_slopes,
    energy_gap,
    loop_gap,
    residuals,
)


def test_the_closed_form_closes() -> None:
    check_slopes(linkage())
    assert loop_gap(linkage(), np.linspace(0, 2 * pi, 1001)) < 1e-14


def test_the_studies_follow_the_hook_of_the_model() -> None:
    from models.film_follower import hook

    assert abs(complex(hook.sx, hook.sy) - (film_follower.HOOK - 0.05)) < 1e-15


def test_it_moves_as_trigonometry_says() -> None:
    run = study().turn
    assert run.outcome is Outcome.OK
    check_motion(run, linkage(), SPEED)
    exact = linkage().point(1, film_follower.HOOK, SPEED * run.t)
    ours = film_follower.hook(run)
    assert np.abs(ours.at - exact.at).max() < 1e-11
    assert np.abs(ours.acceleration - SPEED**2 * exact.second).max() < 1e-9


@pytest.mark.parametrize("name", INERTIAS)
def test_the_driver_pays_for_the_energy(name: str) -> None:
    check_power(study().driven[name], linkage(INERTIAS[name]), SPEED)


@pytest.mark.parametrize("speed", [0.1, 100.0])
def test_the_torque_grows_with_the_square_of_the_speed(speed: float) -> None:
    machine = load("film_follower", "inverse_dynamics")
    instants = np.linspace(0.0, 2 * pi / speed, 73)
    run = machine.inverse_dynamics(instants, parameters={"drive_speed": speed})
    check_power(run, linkage(), speed)


def test_a_constant_torque_turns_it_from_rest() -> None:
    run = study().even
    assert run.outcome is Outcome.OK
    check_even(run, linkage(), TORQUE)


def test_the_motor_turns_it_as_the_equation_of_one_freedom_says() -> None:
    run, exact = study().motor, linkage()
    assert run.outcome is Outcome.OK
    assert max(residuals(run)) < 1e-10

    def rates(t: float, state: np.ndarray) -> tuple[float, float]:
        inertia, change = exact.inertia(state[0])
        torque = 5e-6 * (1 - state[1] / (4 * pi))
        return state[1], (torque - 0.5 * change * state[1] ** 2) / inertia

    instants = run.t[run.t <= 2.0]
    reduced = solve_ivp(rates, (0, 2.0), (0.0, 0.0), "DOP853", instants, rtol=1e-12, atol=1e-13)
    count = len(instants)
    assert np.abs(run.q("crank.phi")[:count] - reduced.y[0]).max() < 1e-8
    assert np.abs(run.v("crank.phi")[:count] - reduced.y[1]).max() < 1e-7


def test_the_work_of_the_motor_is_the_kinetic_energy() -> None:
    gap, works = energy_gap(load("film_follower", "motor"), np.linspace(0.0, 3.0, 201), {})
    assert abs(gap) < 1e-8 * works["motor_torque"]


def test_ours_is_the_exact_value() -> None:
    rows = table()
    assert len(rows) == 7
    for row in rows:
        assert row.ours == pytest.approx(row.exact, rel=1e-9), row


def test_the_figures_are_written(tmp_path: Path) -> None:
    written = draw(figures(), tmp_path)
    assert len(written) == 6
    assert "J₃ = 9.2e-08 kg m², as printed" in (tmp_path / "figure_p8_1_2.svg").read_text()
