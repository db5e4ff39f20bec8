"""Section 5.5: sliders driven by gears, against closed forms."""

from collections.abc import Callable
from itertools import pairwise
from math import pi
from pathlib import Path

import numpy as np
import pytest

from models.studies.drawing import draw
from models.studies.gear_slider import (
    CRANK,
    DRIVERS,
    OFFSET,
    OFFSETS,
    PLANET,
    RATIO,
    ROD,
    SPEED,
    TORQUE,
    TURNS,
    G,
    planetary,
    speed,
    stroke,
    study,
    table,
    torque,
    train,
)
from models.studies.gear_slider_figures import figures
from models.studies.one_freedom import Mover, inertia, potential
from models.studies.paths import path
from models.studies.quick_return import extremes
from runtime import Outcome, Result, load
from tests.models.linkages import residuals

LIMIT = 1e-10
both = pytest.mark.parametrize("name", DRIVERS)


# -- the closed forms ----------------------------------------------------------------------------


@pytest.mark.parametrize("movers", [train, planetary])
def test_the_closed_forms_are_their_own_derivatives(
    movers: Callable[[np.ndarray], list[Mover]],
) -> None:
    theta = np.linspace(-pi, pi, 100_001)
    step = theta[1] - theta[0]
    bodies = movers(theta)
    pairs = [pair for body in bodies for track in body[2:] for pair in pairwise(track)]
    for value, rate in (*pairs, inertia(bodies), potential(bodies, G)):
        difference = np.diff(value) - step * 0.5 * (rate[1:] + rate[:-1])
        assert np.abs(difference).max() < 10 * step**3


def test_the_closed_forms_close() -> None:
    theta = np.linspace(-pi, pi, 721)
    slider = train(theta)[-1].centre.at
    assert np.abs(slider.imag - OFFSET).max() < 1e-16
    assert np.abs(np.abs(slider - CRANK * np.exp(1j * theta)) - ROD).max() < 1e-15
    line = planetary(theta)[-1].centre.at
    assert np.abs(line - 2 * PLANET * np.cos(theta)).max() < 1e-16


# -- kinematics ----------------------------------------------------------------------------------


@both
def test_it_moves_as_the_closed_form(name: str) -> None:
    run = study().moved[name]
    assert run.outcome is Outcome.OK
    assert max(residuals(run)) < LIMIT
    ratio = 1 / RATIO if name == "train" else 1.0
    bodies = (train if name == "train" else planetary)(ratio * SPEED * run.t)
    for body, mover in zip(run.description.bodies, bodies, strict=True):
        ours, rate = path(run, body), ratio * SPEED
        turned = (run.q(f"{body}.phi"), run.v(f"{body}.phi"), run.a(f"{body}.phi"))
        for place, found in ((mover.centre, ours), (mover.angle, turned)):
            for power, (value, exact) in enumerate(zip(found, place, strict=True)):
                wanted = exact * rate**power
                # What stands still or turns evenly has zeros to compare with.
                assert np.abs(value - wanted).max() <= LIMIT * max(1.0, np.abs(wanted).max())


@pytest.mark.parametrize("offset", OFFSETS)
def test_the_stroke_is_that_of_crank_and_rod_in_line(offset: float) -> None:
    left, right = extremes(study().offsets[offset].q("slider.x"))
    assert abs(right - left - stroke(offset)) < 1e-12
    assert (abs(stroke(offset) - 2 * CRANK) < 1e-15) is (offset == 0)


def test_two_turns_of_the_pinion_are_one_of_the_wheel() -> None:
    run = study().moved["train"]
    assert np.abs(run.q("pinion.phi") - RATIO * run.q("wheel.phi")).max() < 1e-13
    assert abs(run.q("slider.x")[-1] - run.q("slider.x")[0]) < 1e-13
    assert abs(run.q("wheel.phi")[-1] + 2 * pi) < 1e-13


def test_the_planet_guides_its_slider() -> None:
    """No joint holds the slider on its line: the gears do."""
    machine = load("gear_slider", "planetary_kinematics")
    assert "guide" in machine.description.left_out.names
    assert (len(machine.coordinates), len(machine.constraints)) == (9, 9)
    run = study().moved["planetary"]
    assert np.abs(run.q("slider.y")).max() < 1e-15
    assert np.abs(run.q("slider.x") - 2 * PLANET * np.cos(SPEED * run.t)).max() < 1e-14


# -- inverse dynamics ----------------------------------------------------------------------------


@both
def test_the_torque_pays_for_the_change_of_energy(name: str) -> None:
    run = study().driven[name]
    found, exact = run.reaction(DRIVERS[name], "torque"), torque(name, run.t)
    assert np.abs(found - exact).max() < LIMIT * np.abs(exact).max()
    # Simpson's rule on the power between two energies: one half of the run.
    power, h = run.power(DRIVERS[name])[:721], run.t[1]
    assert np.abs(power - found[:721] * SPEED).max() < LIMIT * np.abs(power).max()
    work = h / 3 * (power[0] + power[-1] + 4 * power[1:-1:2].sum() + 2 * power[2:-2:2].sum())
    gained = run.energy()[720] - run.energy()[0]
    assert work == pytest.approx(gained, abs=1e-9 * np.ptp(run.energy()))


def test_the_torque_on_the_carrier_is_elementary() -> None:
    """Planetary: the slider's inertia, m (2 R ω)² sin φ cos φ, and the weights on the carrier."""
    run = study().driven["planetary"]
    phi = SPEED * run.t
    weights = G * PLANET * (0.2 / 2 + 0.9) * np.cos(phi)
    exact = (2 * PLANET * SPEED) ** 2 * np.sin(phi) * np.cos(phi) + weights
    assert np.abs(run.reaction("carrier_drive", "torque") - exact).max() < 1e-12


def test_the_teeth_bear_what_turns_the_wheel() -> None:
    """At constant speed the pinion passes the motor's torque on: T = R F about its centre."""
    run = study().driven["train"]
    tangential = run.reaction("mesh", "fy")
    driving = run.reaction("pinion_drive", "torque")
    assert np.abs(np.abs(tangential) * 0.05 - np.abs(driving)).max() < 1e-12
    assert np.abs(run.reaction("mesh", "fx")).max() < 1e-12
    # Towards the wheel is -y, so that across it is +x: a pinion turning left pushes it there.
    assert np.abs(tangential * 0.05 - driving).max() < 1e-12


# -- dynamics ------------------------------------------------------------------------------------


def test_the_train_runs_as_the_theorem_of_energy_says() -> None:
    run = study().running
    assert run.outcome is Outcome.OK
    assert max(residuals(run)) < LIMIT
    gained = run.energy() - run.energy()[0] - TORQUE * run.q("pinion.phi")
    assert np.abs(gained).max() < LIMIT * np.ptp(run.energy())
    # Squares, as a root at rest makes 1e-9 of a rounding error.
    turning, exact = run.v("wheel.phi"), speed(run.q("wheel.phi"))
    assert (turning <= 0).all()
    assert np.abs(turning**2 - exact**2).max() < LIMIT * (exact**2).max()
    assert abs(run.q("pinion.phi")[-1] - 2 * pi * TURNS) < 1e-8


def test_the_gears_do_not_slip_in_ten_turns() -> None:
    run: Result = study().running
    assert np.abs(run.q("pinion.phi") - RATIO * run.q("wheel.phi")).max() < 1e-10


# -- the study -----------------------------------------------------------------------------------


def test_ours_is_the_exact_value() -> None:
    rows = table()
    assert len(rows) == 10
    for row in rows:
        assert row.book is None
        assert abs(row.ours - row.exact) < 1e-10 * max(1e-3, abs(row.exact)), row


def test_the_figures_are_written(tmp_path: Path) -> None:
    written = draw(figures(), tmp_path)
    assert [p.stem for p in written if p.suffix == ".png"] == [f"figure_5_5_{k}" for k in (1, 2, 3)]
    assert "The planetary gear" in (tmp_path / "figure_5_5_1.svg").read_text()
