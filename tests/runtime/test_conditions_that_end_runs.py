"""Runs that end where a condition begins to hold; latches, and values that events renew."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Not, Piecewise, sin

from codegen import Model, build, t
from codegen.errors import InputError, ModelError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

G = 9.81
METHODS = ("dop853", "dopri5", "radau5", "bdf")


def thrown(name: str) -> tuple[Model, dict[object, float]]:
    model = Model(name, gravity=(0, -G))
    ball = model.particle("ball", 1.0)
    return model, {ball.x: 0.0, ball.y: 2.0, ball.vx: 1.0, ball.vy: 0.0}


@pytest.fixture(scope="module")
def falling(workshop: Path) -> Machine:
    model, start = thrown("until_landed")
    ball = model.bodies["ball"]
    conditions = {"landed": ball.y < 0, "far": ball.x > 100}
    model.scene("falls", ["gravity"], start=start, until=conditions)
    return load(model, folder=workshop)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("method", METHODS)
def test_a_run_ends_where_its_condition_begins(
    falling: Machine, method: str, formulation: str
) -> None:
    r = falling.simulate(5.0, method=method, formulation=formulation, rtol=1e-10)
    assert (r.outcome, r.ended_by) == (Outcome.OK, "landed")
    assert_allclose([r.t[-1], r.q("ball.y")[-1]], [np.sqrt(4 / G), 0.0], atol=1e-9)
    assert "'landed' began to hold" in r.message
    assert_allclose(r.at(0.3).q("ball.y"), 2 - G * 0.09 / 2, atol=1e-9)


def test_the_last_instant_is_a_sample_besides_those_asked_for(falling: Machine) -> None:
    r = falling.simulate(5.0, [0.1, 0.2, 1.0, 2.0], rtol=1e-10)
    assert_allclose(r.t, [0.1, 0.2, np.sqrt(4 / G)])
    assert falling.simulate(0.1, [0.1]).ended_by == ""


def test_one_that_holds_at_the_start_ends_the_run_there(falling: Machine) -> None:
    r = falling.simulate(5.0, start={"ball.y": -1.0})
    assert (r.ended_by, r.t[-1]) == ("landed", 0.0)


def test_conditions_of_the_time_and_of_several(workshop: Path) -> None:
    model, start = thrown("until_both")
    ball = model.bodies["ball"]
    model.scene("late", ["gravity"], start=start, until={"late": t > 0.25})
    model.scene("both", ["gravity"], start=start, until={"both": (ball.y < 1.9) & (ball.x > 0.4)})
    assert_allclose(load(model, "late", folder=workshop).simulate(1.0).t[-1], 0.25)
    assert_allclose(load(model, "both", folder=workshop).simulate(1.0).t[-1], 0.4, atol=1e-9)


def test_what_a_condition_renews_needs_a_value_and_has_no_delay() -> None:
    model, start = thrown("renewed_wrong")
    ball = model.bodies["ball"]
    model.sampled("u", when=ball.y < 1)
    model.sampled("w", when=ball.y < 1, value=ball.x, delay=0.1)
    state = model.state("s", rate=1.0)
    model.scene("a", [state], start=start, guess={state: 2.0})
    with pytest.raises(ModelError) as caught:
        build(model, compile=False)
    text = str(caught.value)
    for part in ("'u': when= without value=", "'w': delay= is of a clock"):
        assert part in text, part


def test_a_guess_of_a_state_is_refused() -> None:
    model, start = thrown("guessed_state")
    state = model.state("s", rate=1.0)
    model.scene("a", [state], start=start, guess={state: 2.0})
    with pytest.raises(ModelError, match=r"guess names 's'.*give it in start="):
        build(model, compile=False)


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_that_bounces_has_touched_its_floor(workshop: Path, method: str) -> None:
    model, start = thrown("until_bounced")
    ball = model.bodies["ball"]
    model.contact("floor", model.ground, ball, direction=(0, 1), restitution=0.5)
    conditions = {
        "touches": ball.y <= 0,
        "falls": (ball.y <= 0) & (ball.vy < 0),
        "again": (ball.y <= 0) & (ball.x > 1),
        "below": ball.y < 0,
    }
    for name, condition in conditions.items():
        model.scene(name, ["gravity", "floor"], start=start, until={"landed": condition})
    first = np.sqrt(4 / G)
    for name, end in {"touches": first, "falls": first, "again": 2 * first}.items():
        r = load(model, name, folder=workshop).simulate(1.5, method=method, rtol=1e-10)
        assert (r.outcome, r.ended_by) == (Outcome.OK, "landed"), name
        assert_allclose(r.t[-1], end, atol=1e-9)
    assert load(model, "below", folder=workshop).simulate(1.5, method=method).ended_by == ""


def test_conditions_that_are_none() -> None:
    model, _ = thrown("until_wrong")
    ball = model.bodies["ball"]
    model.scene("a", until={"ball": ball.y < 0, "x y": ball.y < 1, "plain": ball.y, "none": None})
    with pytest.raises(ModelError) as caught:
        build(model, compile=False)
    text = str(caught.value)
    for part in ("'ball' is the name of a", "x y", "'plain'", "'none' is None"):
        assert part in text, part


@pytest.mark.parametrize("method", METHODS)
def test_a_latch_remembers(workshop: Path, method: str) -> None:
    model = Model("latched")
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    pushed = model.latch("pushed", when=mass.x > 0.3, reset=t > 1.0)
    model.force("push", mass, fx=3.0, when=pushed)
    model.force("drag", mass, fx=-0.5, when=Not(pushed))
    model.scene("runs", ["push", "drag"], start={mass.x: 0.0, mass.vx: 1.0})
    r = load(model, folder=workshop).simulate(1.5, [0.1, 0.9, 1.5], method=method, rtol=1e-11)
    begin = 2 - np.sqrt(4 - 1.2)  # t - t²/4 = 0.3
    v = 1 - 0.5 * begin
    v1, x1 = v + 3 * (1 - begin), 0.3 + v * (1 - begin) + 1.5 * (1 - begin) ** 2
    assert_allclose(r.q("mass.x")[-1], x1 + v1 * 0.5 - 0.25 * 0.25, atol=1e-9)
    assert_allclose(r.y("pushed"), [0, 1, 0], atol=1e-14)


def test_a_value_that_events_renew(workshop: Path) -> None:
    model = Model("counting")
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    model.driver("shake", mass.x, sin(3 * t))
    count = model.sampled("count", when=mass.x > 0, value=lambda n: n + 1)
    last = model.sampled("last", when=mass.x > 0, value=t, unit="s")
    model.scene("runs", [count, last], drivers=["shake"])
    r = load(model, folder=workshop).simulate(10.0, [10.0], rtol=1e-9)
    period = 2 * np.pi / 3
    assert r.y("count")[-1] == 1 + np.floor(10 / period)
    assert_allclose(r.y("last")[-1], 4 * period, atol=1e-8)


def test_a_latch_in_a_potential_or_a_law_is_refused() -> None:
    model = Model("latch_in_law")
    mass = model.particle("mass", 1.0)
    on = model.latch("on", when=mass.x > 1)
    model.potential("stored", Piecewise((mass.x, on), (0, True)))
    model.scene("runs", ["stored"])
    with pytest.raises(ModelError, match="velocity on_value"):
        build(model, compile=False)


@pytest.fixture(scope="module")
def pendulum(workshop: Path) -> Machine:
    model = Model("until_overloaded", gravity=(0, -G))
    bob = model.particle("bob", 1.0)
    model.distance("rod", model.ground.at(0, 0), bob, 1.0)
    model.scene("swings", ["gravity"], start={bob.x: 1.0, bob.vy: 0.0}, guess={bob.y: 0.0})
    return load(model, folder=workshop)


def test_a_run_ends_where_a_reaction_grows_too_large(pendulum: Machine) -> None:
    name = "rod.fx"
    sign = np.sign(pendulum.simulate(0.3, [0.3], rtol=1e-11).series(name)[0][0])
    limit = {"overload": (name, ">" if sign > 0 else "<", sign * 20.0)}
    r = pendulum.simulate(3.0, rtol=1e-11, until=limit)
    assert (r.ended_by, r.outcome) == ("overload", Outcome.OK)
    assert_allclose(-3 * G * r.q("bob.y")[-1], 20.0, rtol=1e-9)
    assert_allclose(abs(r.series(name)[0][-1]), 20.0, rtol=1e-9)
    assert not pendulum.simulate(3.0, until={"never": ("total", ">", 1e3)}).ended_by


def test_a_run_that_ended_by_an_output_says_how_it_goes_on(pendulum: Machine) -> None:
    r = pendulum.simulate(3.0, until={"low": ("bob.y", "<", -0.5)})
    assert pendulum.simulate(1.0, start=r).t[0] == r.t[-1]


def test_a_controller_with_a_memory_is_asked_once(workshop: Path) -> None:
    """The second of the two runs has the answers of the first."""
    model = Model("until_with_memory")
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    model.force("push", mass, fx=model.sampled("u", 0.1, unit="N"))
    model.scene("runs", ["push"], start={mass.x: 0.0, mass.vx: 0.0})
    machine, calls = load(model, folder=workshop), list[float]()

    def push(sample: object) -> float:
        calls.append(sample.t)  # type: ignore[attr-defined]
        return float(len(calls))

    r = machine.simulate(1.0, controllers={"u": push}, until={"far": ("mass.x", ">", 0.3)})
    assert r.ended_by == "far"
    assert len(calls) == 11  # that at the end among them
    place = speed = time = 0.0  # a force of k + 1 N from 0.1 k s on
    while (after := place + speed * 0.1 + (calls.index(time) + 1) * 0.005) < 0.3:
        place, speed = after, speed + (calls.index(time) + 1) * 0.1
        time = calls[calls.index(time) + 1]
    a = calls.index(time) + 1.0
    end = time + (np.sqrt(speed**2 + 2 * a * (0.3 - place)) - speed) / a
    assert_allclose(r.t[-1], end, rtol=1e-9)
    assert_allclose(r.y("u")[-1], a)


def test_conditions_on_outputs_that_are_none(
    pendulum: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_run(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("runtime.dynamics.output_conditions.simulate_until", no_run)
    for wrong in ({}, ("rod.fx", ">", 3.0), {"": ("rod.fx", ">", 3.0)},
                  {"a": ("rod.fx", "==", 3.0)}, {"a": ("rod.fx", ["<"], 3.0)}):  # fmt: skip
        with pytest.raises(InputError, match=r"until=.*write until="):
            pendulum.simulate(1.0, until=wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"until=a.*'rod\.fx = 3' is no condition; write"):
        pendulum.simulate(1.0, until={"a": "rod.fx = 3"})
    with pytest.raises(InputError, match=r"'rod\.fz'"):
        pendulum.simulate(1.0, until={"a": ("rod.fz", ">", 3.0)})


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("until", ["place", "count", "asked", "asked for a count"])
def test_a_sample_where_a_run_ends_is_taken(workshop: Path, until: str, formulation: str) -> None:
    model = Model(f"until_a_sample_by_{until.partition(' ')[0]}")
    mark, cart = model.particle("mark", 1.0), model.particle("cart", 1.0)
    count = model.sampled("count", 0.1, lambda count: count + 1)
    at, most = model.parameter("at", 1.0), model.parameter("most", 10.5)
    model.force("push", cart, fx=count)
    conditions = {"place": {"there": mark.x > at}, "count": {"there": count > most}}
    model.scene("run", ["push"], start=dict.fromkeys((mark.x, mark.y, mark.vy, cart.x, cart.y,
                cart.vx, cart.vy), 0) | {mark.vx: 1}, until=conditions.get(until, {}))  # fmt: skip
    machine = load(model, folder=workshop)
    for k in range(1, 13):
        for end in (0.1 * k, 0.1 * k + 0.05):
            asked = {
                "asked": ("mark.x", ">", 0.1 * k),
                "asked for a count": ("count", ">", k + 0.5),
            }
            limit = {"until": {"there": asked[until]}} if until in asked else {}
            settings = {"formulation": formulation, **limit}
            values = {"place": {"at": 0.1 * k}, "count": {"most": k + 0.5}}.get(until, {})
            r = machine.simulate(end, parameters=values, **settings)
            assert r.t[-1] == pytest.approx(0.1 * k, rel=1e-14)
            assert (r.ended_by, r.y("count")[-1], r.a("cart.x")[-1]) == ("there", k + 1, k + 1)
            assert r.resume(2.0).y("count")[[0, -1]].tolist() == [k + 1, 21]
