"""Sliding and sticking against closed forms and an independent reduction."""

from itertools import pairwise

import numpy as np
import pytest

from models.hard.suite import guide
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from tests.hard.result_readings import held, work
from tests.runtime.integrate.systems import ACCURATE

G = 9.81


# J = 225: the gas holds the machine.


@pytest.mark.parametrize("method", ACCURATE)
def test_light_flywheel_stalls_and_stands_still(method: str) -> None:
    machine = load("slider_crank", "compressor")
    run = machine.simulate(10.0, rtol=1e-10, parameters={"J1": 225.0}, method=method)
    assert run.outcome is Outcome.OK
    stall = run.events[-1]
    assert (stall.name, stall.what) == ("gas: slider_vx > 0", "holds")
    assert abs(stall.time - 0.114906810) < 1e-9
    phi = machine.coordinates.index("crank.phi")
    assert abs(stall.q[phi] - 5.796224666) < 1e-9
    after = run.t > stall.time
    assert np.abs(run.samples.v[after]).max() < 1e-13
    assert np.abs(run.samples.a[after]).max() < 1e-9
    assert np.ptp(run.samples.q[after], axis=0).max() < 1e-11
    # 42 205 of 42 205 + 214 653 N m.
    np.testing.assert_allclose(run.share("gas: slider_vx > 0")[after], 0.1643, atol=5e-5)
    assert np.isnan(run.share("gas: slider_vx > 0")[~after]).all()
    assert run.stats["steps"] < 2000


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-12])
def test_stall_at_every_tolerance(rtol: float) -> None:
    run = load("slider_crank", "compressor").simulate(1.0, rtol=rtol, parameters={"J1": 225.0})
    assert run.outcome is Outcome.OK
    assert [e.what for e in run.events] == ["ceased", "holds"]
    assert abs(run.events[-1].time - 0.114906810) < max(1e-9, rtol)


# A block on a belt.


def cycles(count: int, m: float, k: float, kinetic: float, static: float, v: float) -> np.ndarray:
    """Instants at which the block tears loose and is caught, in turn."""
    w, u = np.sqrt(k / m), (static - kinetic) * m * G / k
    slides, rides = 2.0 * (np.pi - np.arctan(u * w / v)) / w, 2.0 * u / v
    steps = [static * m * G / (k * v), *(slides if i % 2 else rides for i in range(1, count))]
    return np.cumsum(steps)


@pytest.mark.parametrize("method", ACCURATE)
@pytest.mark.parametrize(
    ("chosen", "t_end"),
    [({}, 30.0), ({"static": 0.8}, 60.0), ({"speed": 1.0, "stiffness": 1000.0}, 10.0)],
)
def test_block_rides_and_slides_as_the_closed_form_says(
    method: str, chosen: dict[str, float], t_end: float
) -> None:
    start = {"block.vx": chosen.get("speed", 0.1)}
    run = load("hard/belt_block").simulate(
        t_end, rtol=1e-12, method=method, parameters=chosen, start=start
    )
    assert run.outcome is Outcome.OK
    values = {"mass": 1.0, "stiffness": 100.0, "kinetic": 0.2, "static": 0.3, "speed": 0.1} | chosen
    due = cycles(
        len(run.events), values["mass"], values["stiffness"], values["kinetic"], values["static"],
        values["speed"],
    )  # fmt: skip
    assert len(run.events) > 20
    assert [e.what for e in run.events[:4]] == ["ceased", "holds", "ceased", "holds"]
    np.testing.assert_allclose([e.time for e in run.events], due, rtol=0, atol=1e-9)


def test_block_that_rides_is_pushed_by_as_much_as_the_spring_pulls() -> None:
    run = load("hard/belt_block").simulate(10.0, np.linspace(0.0, 10.0, 2001), rtol=1e-11)
    rides = held(run, "belt")
    assert 0.2 < rides.mean() < 0.9
    force = run.reaction("belt", "force")
    np.testing.assert_allclose(force[rides], 100.0 * run.q("block.x")[rides], atol=1e-10)
    np.testing.assert_allclose(np.abs(force[~rides]), 0.2 * G, atol=1e-12)
    assert 0.2 * G < np.abs(force).max() <= 0.3 * G + 1e-9
    np.testing.assert_allclose(run.v("block.x")[rides], 0.1, atol=1e-13)
    np.testing.assert_allclose(run.power("belt"), force * run.v("block.x"), atol=1e-12)


def test_block_without_static_excess_comes_to_rest_in_the_room() -> None:
    """With one coefficient it is caught at once, and rides for ever where friction balances it."""
    run = load("hard/belt_block").simulate(
        20.0, rtol=1e-11, parameters={"static": 0.2, "kinetic": 0.2}
    )
    assert run.outcome is Outcome.OK
    assert abs(run.q("block.x")[-1] - 0.2 * G / 100.0) < 0.011
    assert run.stats["steps"] < 1000


# Friction in a guide.


@pytest.mark.parametrize("method", EXPLICIT)
def test_guide_sticks_and_slides_as_the_reduction_does(method: str) -> None:
    phi, due = guide.motion(10.0, np.pi / 2)
    run = load("hard/guide_friction", "rocking").simulate(10.0, rtol=1e-12, method=method)
    assert run.outcome is Outcome.OK
    words = {"holds": "sticks", "began": "+", "ceased": "-"}
    assert [words[e.what] for e in run.events] == [what for _, what in due]
    assert [what for _, what in due].count("sticks") >= 3
    np.testing.assert_allclose([e.time for e in run.events], [t for t, _ in due], atol=2e-9)
    assert abs(run.q("crank.phi")[-1] - phi[0]) < 1e-8


def test_guide_bears_what_statics_says() -> None:
    run = load("hard/guide_friction", "rocking").simulate(
        10.0, np.linspace(0.0, 10.0, 1001), rtol=1e-11
    )
    rests = held(run, "rub")
    assert rests.sum() > 50
    phi, force, normal = run.q("crank.phi"), *(run.reaction("rub", x) for x in ("force", "normal"))
    for k in np.flatnonzero(rests)[::10]:
        due = guide.forces(guide.torque(run.t[k]), phi[k], 0.0, None)
        assert force[k] == pytest.approx(due.friction, abs=1e-8)
        assert normal[k] == pytest.approx(abs(due.normal), abs=1e-8)
    assert np.all(np.abs(force) <= 0.3 * normal + 1e-9)
    assert np.abs(run.samples.v[rests]).max() < 1e-12


@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-11])
def test_crank_runs_down_and_stays(rtol: float) -> None:
    run = load("hard/guide_friction", "running_down").simulate(10.0, rtol=rtol)
    assert run.outcome is Outcome.OK
    assert [e.what for e in run.events] == ["began", "ceased", "began", "holds"]
    after = run.t > run.events[-1].time
    assert np.ptp(run.q("crank.phi")[after]) < 1e-11
    energy = run.energy()
    assert np.all(np.diff(energy) < 1e-4)  # friction never drives


def test_books_close_over_sticking_and_slipping() -> None:
    machine = load("hard/guide_friction", "rocking")
    run = machine.simulate(10.0, rtol=1e-12)
    edges = [0.0, *(e.time for e in run.events), 10.0]
    gap, gained = 0.0, 0.0
    for begin, end in pairwise(edges):
        if end - begin > 1e-9:
            # Samples inside the piece only: the force jumps at its ends.
            inside = begin + (end - begin) * np.linspace(1e-9, 1.0 - 1e-9, 401)
            piece = machine.simulate(10.0, inside, rtol=1e-12)
            done, energy = work(piece), piece.energy()
            gap = max(gap, abs(energy[-1] - energy[0] - done[-1]))
            gained = max(gained, np.ptp(energy))
    assert gained > 1.0
    assert gap < 1e-7 * gained


def test_books_close_while_the_belt_carries_the_block() -> None:
    run = load("hard/belt_block").simulate(
        2.9, np.linspace(0.0, 2.9, 201), rtol=1e-12, parameters={"static": 3.0}
    )
    assert held(run, "belt").all()
    np.testing.assert_allclose(run.energy()[::2] - run.energy()[0], work(run), atol=1e-10)
    assert work(run)[-1] == pytest.approx(0.5 * 100.0 * 0.29**2, rel=1e-11)
