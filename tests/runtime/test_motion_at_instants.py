"""A result at any instant, the instants of a run that names none, and curves."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from codegen import Model
from codegen.errors import InputError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate import checkpoints
from runtime.machine_facade import Machine
from runtime.results.result import Result
from runtime.statics.equilibrium import Equilibrium
from tests.runtime.same_bits import same


def _swing(tmp_path: Path, phi: float, *outputs: str) -> Machine:
    """A rod on a hinge at the distance 1, in the field 9.81."""
    model = Model("swing", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.5)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.torque("damper", on=bob, value=-0.3 * bob.omega)
    model.scene("free", effects=["gravity"], start={bob.phi: phi, bob.omega: 0.0})
    model.scene("damped", effects=["gravity", "damper"], start={bob.phi: phi}, outputs=outputs)
    return load(model, "damped" if outputs else "free", folder=tmp_path)


@pytest.fixture(scope="module")
def ball() -> Machine:
    return load("hard/bouncing_ball", "dropped")


def _random(r: Result, count: int = 25) -> np.ndarray:
    rng = np.random.default_rng(3)
    return np.unique([*rng.uniform(r.t[0], r.t[-1], count), r.t[0], r.t[-1]])


# -- instants ---------------------------------------------------------------------------------


def test_a_run_that_names_no_instants_has_501(gas: Machine) -> None:
    assert np.array_equal(gas.simulate(0.7).t, np.linspace(0.0, 0.7, 501))
    assert np.array_equal(gas.simulate(0.7, 11, t_start=0.2).t, np.linspace(0.2, 0.7, 11))
    assert gas.simulate(0.7, accuracy=1e-4).t.shape == (501,)
    assert gas.simulate(0.7, np.int64(3), accuracy=1e-4).t.shape == (3,)
    assert gas.simulate(0.0).t.tolist() == [0.0]


def test_steps_on_demand(gas: Machine) -> None:
    r = gas.simulate(0.7, "steps")
    assert len(r.t) == r.stats["steps"] + 1
    assert r.stats["dense_outputs"] < r.stats["steps"]


def test_a_driven_motion_goes_by_the_same_rule(driven: Machine) -> None:
    for analyse in (driven.kinematics, driven.inverse_dynamics):
        assert np.array_equal(analyse(0.25).t, np.linspace(0.0, 0.25, 501))
        assert np.array_equal(analyse(0.25, 6, t_start=0.1).t, np.linspace(0.1, 0.25, 6))
        assert analyse([0.25]).t.tolist() == [0.25]
        assert analyse(t_eval=[0.2, 0.25]).t.tolist() == [0.2, 0.25]
        assert analyse(0.25, [0.2]).t.tolist() == [0.2]
        assert analyse(0.0).t.tolist() == [0.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.1, 0, 0.2), r"t_end = 0\.1 s lies before t_start = 0\.2 s.*give \[0\.1\]"),
        ((0.1, "steps", 0.0), '"steps" has no meaning'),
        (([0.1], [0.2], 0.0), "t_eval is given as well"),
        ((0.1, [0.2], 0.0), r"t_eval goes to 0\.2 s, beyond t_end = 0\.1 s"),
        ((None, None, 0.0), "give the last instant"),
        ((1.0, 0.5, 0.0), r"of one instant it must be \[0\.5\]"),
        ((1.0, 1, 0.0), "a whole number from 2"),
        ((1.0, "often", 0.0), 'or "steps"'),
    ],
)
def test_instants_that_make_no_sense(driven: Machine, arguments: tuple, message: str) -> None:
    t_end, t_eval, t_start = arguments
    with pytest.raises(InputError, match=message):
        driven.kinematics(t_end, t_eval or None, t_start=t_start)


def test_steps_are_none_of_an_accuracy(gas: Machine) -> None:
    with pytest.raises(InputError, match='"steps" and accuracy are both given'):
        gas.simulate(0.1, "steps", accuracy=1e-4)


# -- the motion between -----------------------------------------------------------------------


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "bdf", "auto"])
@pytest.mark.parametrize(
    ("name", "t_end"), [("hard/contact_follower thrown", 1.3), ("hard/belt_block riding", 2.0)]
)
def test_any_instant_has_the_bits_of_a_sample(name: str, t_end: float, method: str) -> None:
    machine = load(*name.split())
    run = machine.simulate(t_end, [0.0, t_end], method=method)
    t = np.union1d(_random(run), [event.time for event in run.events[:20]])
    asked = machine.simulate(t_end, t, method=method)
    same(asked, run.at(t))
    same(asked, machine.simulate(t_end, "steps", method=method).at(t))
    assert len(run._motion.checkpoints.rows) > 1 or run.stats["steps"] < 128
    for k in (3, 9):
        assert run.at(t[k]).samples.q.tolist() == asked.samples.q[k : k + 1].tolist()


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize(
    "name", ["hard/five_bar fall", "hard/n_four_bar fall", "quick_return shaper"]
)
def test_so_has_a_run_that_changes_its_coordinates(name: str) -> None:
    machine = load(*name.split())
    run = machine.simulate(1.3, [0.0, 1.3], formulation="reduced")
    assert len(run._motion.checkpoints.rows) > 3
    t = _random(run)
    same(machine.simulate(1.3, t, formulation="reduced"), run.at(t))


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("scene", ["spin", "driven"])
def test_so_has_a_motion_through_singular_positions(scene: str) -> None:
    machine = load("hard/equal_rods", scene)
    analyse = machine.kinematics if scene == "driven" else machine.simulate
    run = analyse(1.3, 3)
    t = _random(run)
    asked = analyse(1.3, t)
    found = run.at(t)
    assert found.samples.q == pytest.approx(asked.samples.q, abs=1e-13)
    if scene == "spin":
        same(asked, found)


@pytest.mark.usefixtures("often")
def test_few_checkpoints_are_kept_where_bytes_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoints, "_MOST_BYTES", 100_000)
    machine = load("hard/five_bar", "fall")
    run = machine.simulate(2.6, [0.0, 2.6], formulation="reduced")
    kept = run._motion.checkpoints
    assert len(kept.rows) > 1
    assert kept.bytes < 200_000
    t = _random(run)
    same(machine.simulate(2.6, t, formulation="reduced"), run.at(t))


def test_a_pendulum_is_where_elliptic_functions_say(tmp_path: Path) -> None:
    start = 0.4
    r = _swing(tmp_path, start).simulate(6.0, [6.0], rtol=1e-12)
    t = np.random.default_rng(1).uniform(0.0, 6.0, 200)
    # From the vertical: ψ = φ + π/2, at rest at ψ0.
    omega0, k = np.sqrt(9.81 * 2.0 / 2.5), np.sin((start + np.pi / 2) / 2)
    sn, cn, *_ = ellipj(ellipk(k * k) + omega0 * t, k * k)
    at = r.at(t)
    assert np.array_equal(at.t, t)
    assert at.q("bob.phi") == pytest.approx(2.0 * np.arcsin(k * sn) - np.pi / 2, abs=1e-10)
    assert at.v("bob.omega") == pytest.approx(2.0 * k * omega0 * cn, abs=1e-10)


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("t_eval", [[3.0], "steps", 5])
def test_works_go_on_from_the_last_one_known(tmp_path: Path, t_eval: object) -> None:
    machine = _swing(tmp_path, 0.4, "work(damper)", "energy")
    run = machine.simulate(60.0, t_eval=[*range(61)] if t_eval == [3.0] else t_eval)
    t = np.array([3.1, 0.0, 0.2, 59.99, 60.0, 17.3])
    found = run.at(t)
    energy = found.energy() - run.at(0.0).energy()
    assert found.work("damper") == pytest.approx(energy, abs=1e-7)
    assert len(run._motion.checkpoints.rows) > 1
    again = found.at([40.0, 1.0])
    assert again.work("damper") == pytest.approx(run.at([40.0, 1.0]).work("damper"), abs=1e-9)


def test_derived_quantities_come_along(gas: Machine, tmp_path: Path) -> None:
    r = gas.simulate(0.7, 3)
    t = np.linspace(0.0, 0.7, 7)
    asked, found = gas.simulate(0.7, t), r.at(t)
    assert np.array_equal(found.data["reaction"].values, asked.data["reaction"].values, True)
    assert np.array_equal(found.energy(), asked.energy())
    assert np.array_equal(found.a("crank.phi"), asked.a("crank.phi"))
    assert found.outcome is r.outcome
    assert r.data.sizes["time"] == 3
    assert found.save(tmp_path / "some.csv").exists()
    assert "7 instants" in repr(found)


# -- events and ends --------------------------------------------------------------------------


def test_an_impact_has_two_sides(ball: Machine) -> None:
    r = ball.simulate(2.0)
    impact = next(event for event in r.events if event.what == "impact")
    before, after = (r.at(impact.time, side) for side in ("before", "after"))
    assert before.t.tolist() == after.t.tolist() == [impact.time]
    assert before.samples.v[0, 1] < 0.0 < after.samples.v[0, 1]
    assert after.samples.v[0] == pytest.approx(impact.v, abs=1e-12)
    assert after.samples.q[0] == pytest.approx(before.samples.q[0], abs=1e-12)
    assert r.at(impact.time).samples.v.tolist() == before.samples.v.tolist()
    beside = 0.5 * impact.time
    assert r.at(beside, "after").samples.v.tolist() == r.at(beside, "before").samples.v.tolist()


def test_so_has_a_law_that_bends(tmp_path: Path) -> None:
    from sympy import Piecewise

    from codegen import t

    model = Model("push")
    slide = model.body("slide", mass=2.0, inertia=0.1)
    model.translational("guide", model.ground.at(0, 0), slide.at(0, 0), axis=(1, 0))
    push = Piecewise((6.0, t < 0.5), (-4.0, True))
    model.force("push", on=slide.at(0, 0), fx=push)
    model.scene("pushed", effects=["push"], start={slide.x: 0.0, slide.vx: 0.0})
    r = load(model, "pushed", folder=tmp_path).simulate(1.0)
    assert r.at(0.5, "before").a("slide.x") == pytest.approx([3.0], abs=1e-12)
    assert r.at(0.5, "after").a("slide.x") == pytest.approx([-2.0], abs=1e-12)
    assert r.at(r.events[0].time, "before").a("slide.x") == pytest.approx([3.0], abs=1e-12)


@pytest.mark.parametrize("analysis", ["simulate", "inverse_dynamics"])
@pytest.mark.parametrize("t_end", [0.6, 4.0, 40.0])
def test_sides_of_a_kink_do_not_depend_on_the_end(
    analysis: str, t_end: float, tmp_path: Path
) -> None:
    from sympy import Piecewise

    from codegen import t

    model = Model("kink")
    slide = model.body("slide", mass=2.0, inertia=0.1)
    model.translational("guide", model.ground.at(0, 0), slide.at(0, 0), axis=(1, 0))
    model.driver("pieces", slide.x, Piecewise((0.2 * t, t < 0.5), (0.1 + 0.6 * (t - 0.5), True)))
    points = [0.0, 0.5, 50.0], [0.0, 0.1, 29.8]
    table = model.table("law", *points, kind="linear", beyond="hold")
    model.driver("table", slide.x, table(t))
    for driver in ("pieces", "table"):
        model.scene(f"of_{driver}", drivers=[driver])
        machine = load(model, f"of_{driver}", folder=tmp_path)
        r = getattr(machine, analysis)(t_end, 20, progress=False)
        for instant in (0.5, r.events[0].time):
            for side, speed in (("before", 0.2), ("after", 0.6)):
                assert r.at(instant, side).v("slide.vx") == pytest.approx([speed]), (driver, side)


def test_a_run_that_failed_goes_to_where_it_stopped(gas: Machine) -> None:
    whole = gas.simulate(30.0)
    r = gas.simulate(30.0, max_steps=5)
    assert r.outcome is Outcome.MAX_STEPS
    assert r.t[-1] == gas.simulate(30.0, "steps", max_steps=5).t[-1]
    assert r.t[-1] not in whole.t
    t = np.linspace(0.0, r.t[-1], 7)
    assert r.at(t).samples.q == pytest.approx(whole.at(t).samples.q, abs=1e-14)
    assert r.at(r.t[-1]).samples.q.tolist() == r.samples.q[-1:].tolist()
    with pytest.raises(InputError, match=r"lies outside of the result, which goes from t = 0 to"):
        r.at([0.0, 30.0])


@pytest.mark.parametrize("t", ["now", np.nan, [], [[0.1]], None, [0.1, np.inf], True])
def test_what_is_no_instant(gas: Machine, t: object) -> None:
    with pytest.raises(InputError, match="an instant in s"):
        gas.simulate(0.1, 2).at(t)  # type: ignore[arg-type]


def test_what_is_no_side(gas: Machine) -> None:
    with pytest.raises(InputError, match='"before" or "after"'):
        gas.simulate(0.1, 2).at(0.05, "left")  # type: ignore[arg-type]


def test_an_equilibrium_has_one_instant(make: Callable[..., Machine]) -> None:
    rest = make("slider_crank", "free").equilibrium()
    assert isinstance(rest, Equilibrium)
    with pytest.raises(InputError, match="this is one of equilibrium"):
        rest.at(0.0)


# -- curves -----------------------------------------------------------------------------------


def test_curves_are_smooth_and_jumps_are_jumps(ball: Machine) -> None:
    pytest.importorskip("matplotlib")
    r = ball.simulate(1.0, 5)
    impact = next(event for event in r.events if event.what == "impact")
    line = r.plot("ball.vy").axes[0].lines[0]
    t, v = line.get_xdata(), line.get_ydata()
    assert len(t) > 1000
    at = np.flatnonzero(t == impact.time)
    assert len(at) >= 2
    assert v[at[0]] < 0.0 < v[at[-1]]
    flight = (t > impact.time) & (t < r.events[1].time)
    fall = v[flight] + 9.81 * t[flight]
    assert np.ptp(fall) < 1e-6
    assert len(r.t) == 5


def test_curves_of_a_long_run_are_those_of_its_samples(gas: Machine) -> None:
    pytest.importorskip("matplotlib")
    r = gas.simulate(0.1, 5)
    r.stats["integration_seconds"] = 100.0
    assert len(r.plot("crank.phi").axes[0].lines[0].get_xdata()) == 5
