"""Projects 5.2 and 8.2: the web cutter against the linkage in closed form; every cut located."""

from math import pi
from pathlib import Path

import numpy as np
import pytest

from models.studies.drawing import draw
from models.studies.web_cutter import (
    FORCE,
    GAIN,
    LINKAGE,
    LOWER,
    SPEED,
    UPPER,
    WEB,
    cut,
    cuts,
    cuts_of_motor,
    gap,
    study,
    table,
    tips,
)
from models.studies.web_cutter_figures import figures
from runtime import Outcome, load
from tests.models.linkages import (
    check_motion,
    check_power,
    check_slopes,
    energy_gap,
    loop_gap,
    residuals,
)


def test_the_closed_form_closes() -> None:
    check_slopes(LINKAGE)
    assert loop_gap(LINKAGE, np.linspace(0, 2 * pi, 1001)) < 1e-14


def test_the_studies_follow_the_knives_of_the_model() -> None:
    from models.web_cutter import lower, upper

    assert complex(upper.sx, upper.sy) == UPPER
    assert complex(lower.sx, lower.sy) == LOWER


def test_it_moves_as_trigonometry_says() -> None:
    run = study().turn
    assert run.outcome is Outcome.OK
    check_motion(run, LINKAGE, SPEED)
    upper, lower = tips(run)
    exact = gap(SPEED * run.t)
    assert np.abs((upper.at - lower.at).imag - exact.at).max() < 1e-14
    assert np.abs((upper.velocity - lower.velocity).imag - SPEED * exact.first).max() < 1e-12


@pytest.mark.parametrize("name", ["cutting", "idle"])
def test_the_driver_pays_for_energy_and_cut(name: str) -> None:
    check_power(study().driven[name], LINKAGE, SPEED)


def test_the_force_acts_between_the_two_angles_and_nowhere_else() -> None:
    run = study().driven["cutting"]
    phi = SPEED * run.t
    begin, end = cut()
    acts = (phi > begin) & (phi < end)
    power = run.power("cut_above") + run.power("cut_below")
    assert 30 < acts.sum() < 45
    assert np.abs(power[~acts]).max() == 0.0
    wanted = FORCE * SPEED * gap(phi[acts]).first
    assert np.abs(power[acts] - wanted).max() < 1e-10 * np.abs(wanted).max()
    # On the way back the gap is as small, and opens.
    opening = (np.abs(gap(phi).at - WEB / 2) < WEB / 2) & (gap(phi).first > 0)
    assert opening.sum() > 30
    assert np.abs(power[opening]).max() == 0.0


def test_force_times_closing_is_the_torque_of_the_cut() -> None:
    runs = study().driven
    found = [runs[n].reaction("crank_drive", "torque") for n in ("cutting", "idle")]
    power = runs["cutting"].power("cut_above") + runs["cutting"].power("cut_below")
    assert np.abs((found[0] - found[1]) * SPEED + power).max() < 1e-10 * np.abs(power).max()


def test_every_cut_is_located() -> None:
    run = study().running
    assert run.outcome is Outcome.OK
    assert max(residuals(run)) < 1e-10
    found, exact = cuts(run), cuts_of_motor()
    assert np.abs(np.array(found) - np.array(exact)).max() < 1e-9
    crank = run.description.coordinates.index("crank.phi")
    begin, end = cut()
    for turn, (first, last) in enumerate(found):
        at = {e.time: e.q[crank] for e in run.events}
        assert abs(at[first] - 2 * pi * turn - begin) < 1e-11
        assert abs(at[last] - 2 * pi * turn - end) < 1e-11


@pytest.mark.parametrize("web", [1e-5, 1e-3, 0.01])
def test_a_cut_takes_force_times_thickness_at_any_speed(web: float) -> None:
    machine = load("web_cutter", "running")
    chosen = {"web_thickness": web}
    ((begin, end),) = cuts(machine.simulate(0.5, rtol=1e-12, parameters=chosen))
    gap, works = energy_gap(machine, graded(begin, end), chosen)
    assert works["cut_above"] + works["cut_below"] == pytest.approx(-FORCE * web, rel=1e-9)
    assert abs(gap) < 1e-8 * FORCE * web


def graded(begin: float, end: float) -> np.ndarray:
    """Edges that crowd at the beginning, where the motor gives way within a millisecond."""
    return begin + (end - begin) * np.linspace(0.0, 1.0, 201) ** 3


def test_the_motor_pays_for_two_turns_without_a_web() -> None:
    machine = load("web_cutter", "running")
    gap, _ = energy_gap(machine, graded(0.0, 2.0), {"cut_force": 0.0})
    run = machine.simulate(2.0, np.linspace(0.0, 2.0, 501), rtol=1e-11)
    assert abs(gap) < 1e-8 * np.ptp(run.energy("potential"))
    torque = GAIN * (SPEED - run.v("crank.phi"))
    assert np.abs(torque * run.v("crank.phi") - run.power("motor")).max() < 1e-10


@pytest.mark.parametrize("gain", [1.0, 4.0])
def test_a_motor_too_weak_stands_still_in_the_web(gain: float) -> None:
    """It stands where force times slope of the gap exceeds all that the motor has at rest."""
    run = load("web_cutter", "running").simulate(1.0, parameters={"motor_gain": gain})
    assert run.outcome is Outcome.OK
    stop = run.events[-1]
    assert stop.name.startswith("cut_above")
    assert stop.what == "holds"
    assert np.abs(run.v("crank.phi")[run.t > stop.time]).max() < 1e-12
    assert 0.0 < run.share(stop.name)[-1] < 1.0
    phi = run.q("crank.phi")[-1]
    assert cut()[0] < phi < cut()[1]
    weight = float(LINKAGE.potential(phi)[1])
    assert -FORCE * float(gap(phi).first) + weight > gain * SPEED > weight


def test_a_motor_that_can_at_rest_gets_through() -> None:
    needed = max(-FORCE * gap(phi).first + LINKAGE.potential(phi)[1] for phi in cut()) / SPEED
    assert 4.9 < needed < 5.0
    run = load("web_cutter", "running").simulate(1.0, parameters={"motor_gain": 1.01 * needed})
    assert run.outcome is Outcome.OK
    ((begin, end),) = cuts(run)
    assert end - begin > 0.1


def test_ours_is_the_exact_value() -> None:
    rows = table()
    assert len(rows) == 11
    for row in rows:
        assert row.ours == pytest.approx(row.exact, rel=1e-9), row


def test_the_figures_are_written(tmp_path: Path) -> None:
    written = draw(figures(), tmp_path)
    assert len(written) == 8
    assert "upper knife" in (tmp_path / "figure_p8_2_1.svg").read_text()
