"""Runs that go on where joints came or went, and past conditions that ended them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import pi

from codegen import Model, t
from codegen.errors import InputError
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.dynamics import resumption as resumption_of_parts
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.runtime.same_bits import same

G = 9.81
METHODS = ("dop853", "dopri5", "radau5", "bdf")


@pytest.fixture(scope="module")
def towed(workshop: Path) -> Machine:
    """A tow that couples at 0.4 m and lets go at 1.1 m, with clocks, counts and works."""
    model = Model("resumed_tow")
    a, b = (model.particle(name, 1.0) for name in ("a", "b"))
    for mass in (a, b):
        model.absolute(f"rail_{mass.name}", mass, "y", 0.0)
    hook = model.constraint("hook", b.x - a.x - 0.0)
    model.engage(hook, when=a.x > b.x, until=a.x > 1.1)
    model.spring("tie", model.ground.at(3, 0), a, stiffness=9.0, free_length=1.0, damping=0.2)
    model.force("drag", b, fx=-0.3 * b.vx)
    count = model.sampled("count", when=a.vx > 0.01, value=lambda n: n + 1)
    clock = model.sampled("clock", 0.1, t, delay=0.25, unit="s")
    model.scene(
        "runs", ["tie", "drag", count, clock],
        start={a.x: 0.0, a.vx: 0.0, b.x: 0.4, b.vx: 0.0},
        outputs=["energy", "powers", "works", "reaction(hook)"],
    )  # fmt: skip
    return load(model, folder=workshop)


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("method", METHODS)
def test_a_run_goes_on_through_changes_of_joints(
    towed: Machine, method: str, formulation: str
) -> None:
    settings = {"method": method, "formulation": formulation, "rtol": 1e-9}
    times = np.linspace(0.0, 2.0, 41)
    whole = towed.simulate(2.0, times, **settings)  # type: ignore[arg-type]
    assert [one.action for one in whole.reconnections] == ["engage", "release"]
    caught, freed = (one.time for one in whole.reconnections)
    ends = (0.2, 0.5 * (caught + freed), 0.9 * freed, freed + 0.2)
    for end in ends:
        begun = towed.simulate(end, times[times <= end], **settings)  # type: ignore[arg-type]
        then = begun.resume(2.0, times[times >= end])
        assert (then.outcome, then.t[-1]) == (Outcome.OK, 2.0)
        same(whole, then)
        assert then.stats["steps"] == whole.stats["steps"]
        assert [*begun.reconnections, *then.reconnections] == [*whole.reconnections]
        assert then.message.startswith(f"Resumed at t = {end:.9g} s. ")
        assert ("Joint 'hook' was released" in then.message) is (end < freed)
        inside = np.linspace(0.0, 2.0, 23)
        same(whole.at(inside), then.at(inside))


def test_one_goes_on_several_times(towed: Machine, tmp_path: Path) -> None:
    times = np.linspace(0.0, 2.0, 41)
    whole = towed.simulate(2.0, times)
    r = towed.simulate(times[4], [times[4]])
    for k, end in enumerate(times[[10, 16, 20, 28, 40]].tolist()):
        r = r.resume(end, times[(times >= r.t[-1]) & (times <= end)])
        if k % 2:
            r.save(tmp_path / f"tow_{k}.nc")
            back = load_result(tmp_path / f"tow_{k}.nc", towed)
            assert back.t.tolist() == r.t.tolist()
            assert (back.message, back.reconnections) == (r.message, r.reconnections)
            r = back
        same(whole, r)
    assert r.t[-1] == 2.0
    assert_allclose(r.y("count")[-1], whole.y("count")[-1])


@pytest.mark.parametrize(("t_eval", "count"), [(7, 7), ("steps", None), ([1.9], 1), (None, 501)])
def test_instants_of_what_goes_on(towed: Machine, t_eval: object, count: int | None) -> None:
    """Of those at the ends of steps there are as many as of the whole run behind 0.2 s, and 0.2."""
    r = towed.simulate(0.2, [0.1]).resume(2.0, t_eval)  # type: ignore[arg-type]
    assert r.t[-1] == (1.9 if isinstance(t_eval, list) else 2.0)
    assert r.t[0] == (1.9 if isinstance(t_eval, list) else 0.2)
    whole = towed.simulate(2.0, "steps")
    assert len(r.t) == (count or 1 + np.count_nonzero(whole.t > 0.2))
    assert (np.diff(r.t) > 0).all()
    assert_allclose(r.works["drag"], whole.at(r.t).works["drag"], atol=1e-9)


def test_a_message_tells_the_steps_of_all_parts(towed: Machine) -> None:
    r = towed.simulate(0.2, [0.2])
    for end in (1.9, 2.0):  # through changes of joints, and behind them
        r = r.resume(end, [end])
        assert r.message.startswith("Resumed at")
        assert f"Reached t = {end:g} s in {r.stats['steps']:.0f} steps." in r.message


def test_a_limit_of_steps_counts_all(towed: Machine) -> None:
    whole = towed.simulate(2.0, "steps")
    begun = towed.simulate(2.0, "steps", max_steps=int(whole.stats["steps"]) - 3)
    assert begun.outcome is Outcome.MAX_STEPS
    assert begun.reconnections
    rest = begun.resume(2.0, "steps")
    assert rest.t[-1] == 2.0
    same(whole, rest)
    again = begun.resume(2.0, "steps", max_steps=int(whole.stats["steps"]) - 1)
    assert again.outcome is Outcome.MAX_STEPS


# -- past conditions ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swung(workshop: Path) -> Machine:
    """x = cos 3 t; the run ends where the mass goes to the left of -0.5 m."""
    model = Model("resumed_end")
    mass = model.particle("mass", 2.0)
    model.absolute("rail", mass, "y", 0.0)
    model.spring("tie", model.ground.at(-9, 0), mass, stiffness=18.0, free_length=9.0)
    count = model.sampled("count", when=mass.x < 0, value=lambda n: n + 1)
    clock = model.sampled("clock", 0.1, t, delay=0.25, unit="s")
    start = {mass.x: 1.0, mass.vx: 0.0}
    acting, until = ["tie", count, clock], {"left": mass.x < -0.5, "late": t > 7.0}
    outputs = ["energy", "powers", "works", "default"]
    model.scene("swings", acting, start=start, until=until, outputs=outputs)
    model.scene("plain", acting, start=start, outputs=outputs)
    return load(model, "swings", folder=workshop)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("method", METHODS)
def test_a_run_goes_on_past_its_condition(swung: Machine, method: str, formulation: str) -> None:
    r = swung.simulate(9.0, method=method, formulation=formulation, rtol=1e-11)  # type: ignore[arg-type]
    first, turn = np.arccos(-0.5) / 3, 2 * np.pi / 3
    ends = [*(first + turn * k for k in range(4)), 7.0]
    for k, end in enumerate(ends):
        assert (r.outcome, r.ended_by) == (Outcome.OK, "late" if k == 4 else "left")
        assert_allclose(r.t[-1], end, atol=1e-8)
        assert_allclose(r.q("mass.x"), np.cos(3 * r.t), atol=1e-8)
        assert r.y("count")[-1] == k + (k < 4)
        before = r.t[-1]
        r = r.resume(9.0)
        assert r.t[0] == before
    assert (r.ended_by, r.t[-1], r.y("count")[-1]) == ("", 9.0, 5.0)
    assert_allclose(r.at([0.3, 2.2, 8.3]).q("mass.x"), np.cos([0.9, 6.6, 24.9]), atol=1e-8)
    assert_allclose(r.y("clock")[-1], 8.7)
    assert_allclose(r.at([0.3, 0.36, 2.2]).y("clock"), [0.0, 0.1, 1.9], atol=1e-12)


def test_works_and_files_past_a_condition(swung: Machine, tmp_path: Path) -> None:
    whole = load(swung.mechanism.origin.model, "plain", folder=swung.path.parent.parent)  # type: ignore[union-attr]
    plain = whole.simulate(9.0, rtol=1e-11)
    r = swung.simulate(9.0, rtol=1e-11).resume(2.0).resume(5.0, [2.5, 4.0])
    assert r.ended_by == "left"
    assert r.t[:-1].tolist() == [2.5]
    r.save(tmp_path / "left.nc")
    back = load_result(tmp_path / "left.nc", swung)
    assert back.ended_by == "left"
    assert back.t.tolist() == r.t.tolist()
    for one in (r, back):
        on = one.resume(4.0, [3.5, 4.0])
        assert_allclose(on.works["tie"], plain.at([3.5, 4.0]).works["tie"], atol=1e-8)
        assert_allclose(
            on.at([0.2, 2.1]).works["tie"], plain.at([0.2, 2.1]).works["tie"], atol=1e-8
        )


def test_a_joint_goes_past_an_end(workshop: Path) -> None:
    """A pendulum that is cut loose, whose run ends before and behind the cut."""
    model = Model("resumed_cut", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.release(hinge, when=bob.phi > 0.5)
    start, until = {bob.phi: -pi / 2, bob.omega: 7.0}, {"side": bob.phi > 0, "low": bob.y < -1.5}
    model.scene("swing", ["gravity"], start=start, until=until)
    model.scene("through", ["gravity"], start=start)
    machine = load(model, "swing", folder=workshop)
    whole = load(model, "through", folder=workshop).simulate(2.0, rtol=1e-11)
    names, r = [], machine.simulate(2.0, rtol=1e-11)
    while r.ended_by:
        names.append(r.ended_by)
        assert_allclose(r.samples.q, whole.at(r.t).samples.q, atol=1e-9)
        r = r.resume(2.0)
    assert names == ["side", "low"]
    assert_allclose(r.samples.q, whole.at(r.t).samples.q, atol=1e-9)
    assert_allclose(r.at(0.1).q("bob.phi"), whole.at(0.1).q("bob.phi"), atol=1e-10)
    assert r.reconnections == ()
    assert r.t[-1] == 2.0


# -- conditions on outputs ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def pendulum(workshop: Path) -> Machine:
    model = Model("resumed_outputs", gravity=(0, -G))
    bob = model.particle("bob", 1.0)
    model.distance("rod", model.ground.at(0, 0), bob, 1.0)
    model.scene("swings", ["gravity"], start={bob.x: 1.0, bob.vy: 0.0}, guess={bob.y: 0.0})
    return load(model, folder=workshop)


def test_conditions_on_outputs_stay(pendulum: Machine, tmp_path: Path) -> None:
    limit = {"low": ("bob.y", "<", -0.5), "far": ("bob.x", "<", -0.9)}
    whole = pendulum.simulate(4.0, rtol=1e-11)
    r, names = pendulum.simulate(0.1, rtol=1e-11, until=limit), []
    assert not r.ended_by
    for k in range(4):
        r = r.resume(4.0)
        names.append(r.ended_by)
        assert_allclose(r.samples.q, whole.at(r.t).samples.q, atol=1e-9)
        series, _, value = limit[r.ended_by]
        assert_allclose(r.series(series)[0][-1], value, atol=1e-9)
        assert f"where '{r.ended_by}' began to hold" in r.message
        if k == 1:
            r.save(tmp_path / "low.nc")
            r = load_result(tmp_path / "low.nc", pendulum)
    assert names == ["low", "far", "low", "low"]
    assert not r.resume(r.t[-1] + 0.01).ended_by


def test_one_that_fails_on_its_way_to_the_end_is_not_ended(
    pendulum: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = pendulum.simulate(0.1, rtol=1e-11, until={"low": ("bob.y", "<", -0.5)})
    go_on, limits = resumption_of_parts._go_on, [None, 1]

    def limited(*arguments: Any, **words: Any) -> Result:
        return go_on(*arguments, **words | {"max_steps": limits.pop(0)})

    monkeypatch.setattr(resumption_of_parts, "_go_on", limited)
    r = begun.resume(4.0)
    assert (r.outcome, r.ended_by, limits) == (Outcome.MAX_STEPS, "", [])
    assert "began to hold" not in r.message


def test_conditions_have_names_of_their_own(swung: Machine, towed: Machine) -> None:
    for machine, name in ((swung, "left"), (towed, "hook")):
        with pytest.raises(InputError, match=f"until= names '{name}'.*another name"):
            machine.simulate(1.0, until={name: ("kinetic", ">", 0.1)})
