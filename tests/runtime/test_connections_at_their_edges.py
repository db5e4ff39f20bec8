"""States, latches and joints that come and go, at the edges of what is declared for them."""

import json
from html import escape
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import And, Not

from codegen import Model, t
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.show.html_report import page

G = 9.81


def falling(model: Model) -> None:
    """A particle that falls from 1 m, with a count, a latch and a clock."""
    ball = model.particle("ball", 1.0)
    model.absolute("rail", ball, "x", 0.0)
    count = model.sampled("count", when=ball.y > 0.5, value=lambda n: n + 1)
    model.latch("on", when=ball.vy < 0)
    clock = model.sampled("clock", 0.5, lambda n: n + 1)
    start, named = {ball.y: 1.0, ball.vy: -0.1}, ["gravity", count, "on", clock]
    model.scene("falls", named, start=start)
    model.scene("stops", named, start=start, until={"low": ball.y < 2})


@pytest.mark.parametrize("times", [None, "steps", [0.0, 0.3]])
@pytest.mark.parametrize("scene", ["falls", "stops"])
def test_the_first_sample_has_what_begins_with_it(
    workshop: Path, scene: str, times: object
) -> None:
    model = Model("first_sample", gravity=(0, -G))
    falling(model)
    r = load(model, scene, folder=workshop).simulate(0.4, times)
    assert [r.y(name)[0] for name in ("count", "on", "clock")] == [1, 1, 1]
    assert r.at(0.0).y("count") == 1
    assert r.ended_by == ("low" if scene == "stops" else "")


def test_clocks_and_counts_of_a_file_go_on_behind_a_release(workshop: Path) -> None:
    """Each part of a run begins with the clocks and conditions that the part before it left."""
    model = Model("clocks_in_a_file")
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    brake = model.constraint("brake", mass.x - 0.2 * t)
    model.release(brake, when=t > 0.5)
    clock = model.sampled("clock", 0.1, t, delay=0.25, unit="s")
    count = model.sampled("count", when=mass.x > 0.05, value=lambda n: n + 1)
    model.force("push", mass, fx=1 + clock)
    model.scene("moves", ["push", count], start={mass.x: 0.0, mass.vx: 0.2})
    machine = load(model, folder=workshop)
    r = machine.simulate(1.0, rtol=1e-10)
    times = [0.45, 0.51, 0.59, 0.6, 0.77]
    r.save(workshop / "clocks.nc")
    back = load_result(workshop / "clocks.nc", machine)
    assert_allclose(r.at(times).y("clock"), [0.2, 0.2, 0.3, 0.3, 0.5], rtol=1e-15)
    assert back.at(times).samples.v.tobytes() == r.at(times).samples.v.tobytes()


def endless(speed: float) -> Model:
    """A ball that is caught as it begins to fall, and let go as it no longer does."""
    model = Model(f"endless_catch_{speed > 0:d}", gravity=(0, -G))
    ball = model.particle("ball", 1.0)
    model.absolute("rail", ball, "x", 0.0)
    catch = model.constraint("catch", ball.y)
    model.engage(catch, when=ball.vy < -speed, until=ball.vy >= 0)
    model.scene("falls", ["gravity"], start={ball.y: 0.0, ball.vy: 0.0})
    return model


@pytest.mark.parametrize("speed", [0.0, 1e-6])
def test_joints_without_end_are_told_in_short(workshop: Path, speed: float) -> None:
    r = load(endless(speed), folder=workshop).simulate(1.0, rtol=1e-10)
    assert r.outcome is Outcome.ZENO
    assert len(r.reconnections) < 100
    assert len(r.message) < 900
    assert f"… {len(r.reconnections) - 4} more changes, in `reconnections` …" in r.message
    assert f"without end, {len(r.reconnections)} times, the last 'catch'" in r.message


def test_a_joint_engages_at_the_origin(workshop: Path) -> None:
    """A ball that is caught where nothing is away from the origin, and let go again."""
    model = Model("caught_at_the_origin", gravity=(0, -G))
    ball = model.particle("ball", 1.0)
    model.absolute("rail", ball, "x", 0.0)
    catch = model.constraint("catch", ball.y)
    model.engage(catch, when=ball.y < 0, until=t > 0.6)
    falling = {ball.y: 1.0, ball.vy: 0.0}
    model.scene("falls", ["gravity"], start=falling)
    machine = load(model, folder=workshop)
    r = machine.simulate(1.0, [0.5, 0.7, 1.0], rtol=1e-10)
    assert [one.action for one in r.reconnections] == ["engage", "release"]
    assert_allclose(r.reconnections[0].impulse["force"], np.sqrt(2 * G), rtol=1e-12)
    assert_allclose(r.q("ball.y"), [0, -G * 0.01 / 2, -G * 0.16 / 2], atol=1e-12)
    assert f"Reached t = 1 s in {r.stats['steps']} steps." in r.message
    short = machine.simulate(0.4, [0.4], rtol=1e-10).stats["steps"]
    assert r.stats["steps"] < 6 * short  # its tolerances are not those of a machine without size
    r.save(workshop / "origin.nc")
    back = load_result(workshop / "origin.nc", machine).at(0.9)
    assert back.samples.q.tobytes() == r.at(0.9).samples.q.tobytes()


def test_counts_of_coordinates_are_without_integrals(workshop: Path) -> None:
    model = Model("counted", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.driver("turn", bob.phi, t)
    charge = model.state("charge", lambda y: bob.omega - y)
    model.scene("turns", ["gravity", charge], drivers=["turn"])
    model.scene("twice", ["gravity", charge], start={bob.omega: 1.0, bob.phi: 0.0})
    r = load(model, "turns", folder=workshop).simulate(0.1)
    assert "4 coordinates" not in r.message + repr(r) + page(r)
    assert "charge.integral" not in r.message + repr(r) + page(r)


def test_what_happened_to_joints_is_shown(workshop: Path) -> None:
    model = Model("shown_joints", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.release(hinge, when=bob.phi > 0.5)
    start = {bob.phi: 0.0, bob.omega: 7.0}
    model.scene("swing", ["gravity"], start=start, until={"high": Not(bob.phi < 2)})
    r = load(model, folder=workshop).simulate(1.5)
    (change,) = r.reconnections
    assert "joints       1 change, in .reconnections" in repr(r)
    assert escape(str(change)) in page(r)
    facts = json.loads(json.dumps(r.facts(), allow_nan=False))
    assert facts["ended_by"] == "high"
    assert facts["reconnections"] == [{
        "time": change.time, "joint": "hinge", "action": "release", "impulse": {},
        "energy_lost": 0.0, "units": {}, "opposite": False,
    }]  # fmt: skip


def test_a_latch_stays_as_it_is_where_a_joint_is_released(workshop: Path) -> None:
    """Set at 0.1 s and reset at 0.3 s, while the condition that set it goes on to hold."""
    model = Model("latch_and_release")
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    brake = model.constraint("brake", mass.x)
    model.release(brake, when=t > 0.5)
    model.latch("on", when=t > 0.1, reset=And(t > 0.3, t < 0.4))
    model.scene("moves", ["on"])
    machine = load(model, folder=workshop)
    r = machine.simulate(1.0, [0.2, 0.45, 0.7])
    assert [one.action for one in r.reconnections] == ["release"]
    assert_allclose(r.y("on"), [1, 0, 0], atol=1e-15)
    again = machine.simulate(1.0, [1.0], start=r.state(0.45))
    assert_allclose(again.y("on"), 0, atol=1e-15)


@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_two_joints_engage_by_one_condition(workshop: Path, method: str) -> None:
    """The first holds the condition at its boundary; the second engages nonetheless."""
    model = Model("engage_by_one_condition")
    a, b = (model.body(name, mass=m, inertia=0.5) for name, m in (("a", 2.0), ("b", 1.0)))
    model.translational("rail", model.ground.at(0, 0), a.at(0, 0), (1, 0))
    model.absolute("level", b, "y", 0.0)
    for name, equation in (("hook", b.x - a.x), ("turn", b.phi - a.phi)):
        model.engage(model.constraint(name, equation), when=a.x > b.x)
    model.scene("meet", start={a.x: 0.0, a.vx: 3.0, b.x: 1.0, b.vx: 0.0, b.phi: -1.0, b.omega: 3.0})
    r = load(model, folder=workshop).simulate(1.0, [1.0], method=method, rtol=1e-10)
    assert [one.joint for one in r.reconnections] == ["hook", "turn"]
    assert_allclose([one.time for one in r.reconnections], 1 / 3, atol=1e-9)
    assert_allclose([r.v("a.vx")[0], r.v("b.vx")[0], r.v("b.omega")[0]], [2, 2, 0], atol=1e-9)


def test_a_run_starts_with_the_joints_of_its_state(workshop: Path) -> None:
    """Behind a release, a catch or both, a run from a state is the one that it was taken from."""
    model = Model("starts_where_joints_act")
    place = model.parameter("place", 0.0, "m")
    particle = model.particle("p", mass=1.0)
    model.absolute("rail", particle, "y", 0.0)
    model.release(model.constraint("pin", particle.x - place), when=t > 1)
    model.engage(model.constraint("end", particle.x - 0.5), when=particle.x > 0.5)
    model.force("push", particle, fx=2.0)
    model.scene("s", ["push"], start={particle.x: 0.0})
    machine = load(model, "s", folder=workshop)
    whole = machine.simulate(3.0)  # x = (t - 1)² until it is caught
    saved = workshop / "starts_where_joints_act.nc"
    for instant, x, joint in [(0.5, 0.0, "pin"), (1.5, 0.25, "pin"), (2.0, 0.5, "end")]:
        state = whole.state(instant)
        assert_allclose(state["p.x"], x, atol=1e-12)
        again = machine.simulate(3.0, start=state)
        assert_allclose(again.q("p.x"), whole.at(again.t).q("p.x"), atol=1e-10)
        assert_allclose(again.q("p.x")[-1], 0.5, atol=1e-12)
        assert f"'{state.scene}'" in again.message
        assert (f"with_{joint}" in state.scene) == (joint == "end")
    assert whole.state(2.0).scene == "s_without_pin_with_end"
    half = machine.simulate(1.5)
    half.save(saved)
    for first in (half, load_result(saved, machine=machine)):
        new = load(model, "s", folder=workshop)  # which has no other scene yet
        then = new.simulate(1.7, start=first, parameters={"place": 0.1})  # which only 'pin' needs
        assert_allclose(then.q("p.x")[-1], 0.49, atol=1e-10)
    later = workshop / "starts_where_no_joint_acts.nc"
    then.save(later)
    assert_allclose(load_result(later, machine=machine).at(1.6).q("p.x"), 0.36, atol=1e-10)
