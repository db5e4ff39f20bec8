"""Accuracy targets of runs that conditions end, and in which joints come and go: closed forms."""

from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipj, ellipkinc
from sympy import pi

from codegen import Model
from codegen.errors import InputError
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.models.test_trebuchet import reference

G = 9.81
TARGETS = (1e-4, 1e-6, 1e-8, 1e-10)
LENIENT = 20.0  # of an estimate, which is one to a factor of ten or so


def errors(r: Result, exact: dict[str, np.ndarray]) -> dict[str, float]:
    """The largest error of each series, as a target means it."""
    scales = {row.name: row.scale for row in r.accuracy.quantities}
    return {
        name: float(np.max(np.abs(r.series(name)[0] - x) / (scales[name] + np.abs(x))))
        for name, x in exact.items()
    }


def estimates(r: Result) -> dict[str, float]:
    return {row.name: row.error for row in r.accuracy.quantities}


# -- a pendulum that is cut loose at 0.5 rad, and lands ----------------------------------------

K = G / 1.1
OMEGA = float(np.sqrt(49 - 2 * K * (np.sin(0.5) + 1)))
CUT = float(ellipkinc((0.5 + np.pi / 2) / 2, 4 * K / 49) / 3.5)
RISE = OMEGA * np.cos(0.5)
LOW = CUT + (RISE + np.sqrt(RISE**2 + 2 * G * (np.sin(0.5) + 1.5))) / G


def cut_motion(t: np.ndarray) -> dict[str, np.ndarray]:
    swung = 2 * ellipj(3.5 * t, 4 * K / 49)[3] - np.pi / 2
    speed = np.sqrt(49 - 2 * K * (np.sin(swung) + 1))
    s, held = t - CUT, t <= CUT
    flown = {
        "x": np.cos(0.5) - OMEGA * np.sin(0.5) * s,
        "y": np.sin(0.5) + RISE * s - G * s**2 / 2,
        "phi": 0.5 + OMEGA * s,
        "vx": -OMEGA * np.sin(0.5) + 0 * s,
        "vy": RISE - G * s,
        "omega": OMEGA + 0 * s,
    }
    c, sine = np.cos(swung), np.sin(swung)
    before = (c, sine, swung, -speed * sine, speed * c, speed)
    return {
        f"bob.{name}": np.where(held, x, y)
        for (name, y), x in zip(flown.items(), before, strict=True)
    }


@pytest.fixture(scope="module")
def cut(workshop: Path) -> Machine:
    model = Model("accurate_cut", gravity=(0, -G))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.release(hinge, when=bob.phi > 0.5)
    model.scene(
        "swing", ["gravity"], start={bob.phi: -pi / 2, bob.omega: 7.0}, until={"low": bob.y < -1.5}
    )
    return load(model, folder=workshop)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("target", TARGETS)
def test_a_pendulum_cut_loose(cut: Machine, target: float, formulation: str) -> None:
    r = cut.simulate(3.0, accuracy=target, formulation=formulation, progress=False)
    assert (r.outcome, r.ended_by, len(r.reconnections)) == (Outcome.OK, "low", 1), r.message
    found, given = errors(r, cut_motion(r.t)), estimates(r)
    assert max(found.values()) <= target
    assert max(found.values()) <= LENIENT * r.accuracy.estimated
    about = LENIENT * max(given["t(hinge)"], given["t(low)"], r.accuracy.estimated)
    assert abs(r.reconnections[0].time - CUT) / LOW <= about
    assert abs(r.t[-1] - LOW) / LOW <= about
    assert max(given["t(hinge)"], given["t(low)"]) <= target
    assert set(given) == {*cut_motion(r.t), "t(hinge)", "t(low)"}


@pytest.mark.parametrize("method", ["dopri5", "radau5", "bdf"])
def test_so_with_other_methods(cut: Machine, method: str) -> None:
    r = cut.simulate(3.0, accuracy=1e-7, method=method, progress=False)
    assert r.ended_by == "low"
    found = max(errors(r, cut_motion(r.t)).values())
    assert found <= min(1e-7, LENIENT * r.accuracy.estimated)
    assert abs(r.t[-1] - LOW) / LOW <= 1e-7


def test_the_result_is_that_of_a_run_with_the_recorded_settings(
    cut: Machine, tmp_path: Path
) -> None:
    r = cut.simulate(3.0, accuracy=1e-6, progress=False)
    done = r.accuracy
    again = cut.simulate(
        3.0, rtol=done.rtol, method=done.method,
        formulation=done.formulation,
    )  # fmt: skip
    assert again.reconnections == r.reconnections
    for one, other in zip(r.samples, again.samples, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    r.save(tmp_path / "cut.nc")
    back = load_result(tmp_path / "cut.nc", cut)
    assert back.accuracy == done
    assert (back.outcome, back.ended_by) == (Outcome.OK, "low")


def test_series_are_chosen_by_name(cut: Machine) -> None:
    r = cut.simulate(3.0, accuracy=1e-6, quantities=("bob.x", "hinge.fx"), progress=False)
    assert set(estimates(r)) == {"bob.x", "hinge.fx", "t(hinge)", "t(low)"}
    behind = r.t > r.reconnections[0].time
    assert not r.reaction("hinge", "fx")[behind].any()
    with pytest.raises(InputError, match=r"There is no series 'bob\.z'"):
        cut.simulate(3.0, accuracy=1e-6, quantities=("bob.z",), progress=False)


@pytest.mark.parametrize("times", [[0.1], [0.1, 2.0], [0.0, 1.0, 1.5, 2.5]])
def test_instants_before_and_behind_the_end(cut: Machine, times: list[float]) -> None:
    r = cut.simulate(3.0, times, accuracy=1e-6, progress=False)
    assert (r.outcome, r.ended_by) == (Outcome.OK, "low")
    assert r.t.tolist() == [t for t in times if t < LOW] + [r.t[-1]]
    assert abs(r.t[-1] - LOW) < 1e-6
    assert max(errors(r, cut_motion(r.t)).values()) <= 1e-6


def test_a_run_to_before_the_release_has_no_instant(cut: Machine) -> None:
    r = cut.simulate(0.2, accuracy=1e-6, progress=False)
    assert not [name for name in estimates(r) if name.startswith("t(")]


# -- two masses that latch ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def latched(workshop: Path) -> Machine:
    """Both swing on springs, and meet with different speeds."""
    model = Model("accurate_latch")
    a, b = (model.particle(name, mass=m) for name, m in (("a", 2.0), ("b", 1.0)))
    for mass in (a, b):
        model.absolute(f"rail_{mass.name}", mass, "y", 0.0)
    latch = model.constraint("latch", b.x - a.x - 0.2)
    model.engage(latch, when=b.x - a.x < 0.2)
    model.spring("tie", model.ground.at(-9, 0), b, stiffness=50.0, free_length=10.0)
    model.spring("pull", model.ground.at(-9, 0), a, stiffness=8.0, free_length=9.0)
    model.scene("runs", ["tie", "pull"], start={a.x: 0.1, a.vx: 3.0, b.x: 1.2, b.vx: 0.0})
    return load(model, folder=workshop)


def latched_motion(t: np.ndarray) -> tuple[float, dict[str, np.ndarray]]:
    from scipy.optimize import brentq

    w = np.sqrt(50.0)

    def gap(s: float) -> float:
        return float(1 + 0.2 * np.cos(w * s) - 0.1 * np.cos(2 * s) - 1.5 * np.sin(2 * s) - 0.2)

    met = float(brentq(gap, 0.1, 0.5, xtol=1e-16))
    va = -0.2 * np.sin(2 * met) + 3.0 * np.cos(2 * met)
    vb = -0.2 * w * np.sin(w * met)
    speed, x0 = (2 * va + vb) / 3, 0.1 * np.cos(2 * met) + 1.5 * np.sin(2 * met)
    both, mean = np.sqrt(58 / 3), 40.0 / 58  # 3 x'' = -8 x - 50 (x + 0.2 - 1)
    s, apart = t - met, t <= met
    x = mean + (x0 - mean) * np.cos(both * s) + speed / both * np.sin(both * s)
    v = -(x0 - mean) * both * np.sin(both * s) + speed * np.cos(both * s)
    return met, {
        "a.x": np.where(apart, 0.1 * np.cos(2 * t) + 1.5 * np.sin(2 * t), x),
        "b.x": np.where(apart, 1 + 0.2 * np.cos(w * t), x + 0.2),
        "a.vx": np.where(apart, -0.2 * np.sin(2 * t) + 3 * np.cos(2 * t), v),
        "b.vx": np.where(apart, -0.2 * w * np.sin(w * t), v),
    }


@pytest.mark.parametrize("target", TARGETS)
def test_two_masses_that_latch(latched: Machine, target: float) -> None:
    r = latched.simulate(2.0, accuracy=target, progress=False)
    met, exact = latched_motion(r.t)
    assert (r.outcome, len(r.reconnections)) == (Outcome.OK, 1), r.message
    found = max(errors(r, exact).values())
    assert found <= target
    assert found <= LENIENT * r.accuracy.estimated
    apart = abs(r.reconnections[0].time - met) / 2.0
    assert apart <= max(1e-15, LENIENT * estimates(r)["t(latch)"])


def test_an_instant_beside_the_catch_asks_for_more(latched: Machine) -> None:
    """A velocity jumps there, so that the run has to know on which side the instant lies."""
    met, _ = latched_motion(np.zeros(1))
    times = np.array([0.1, met - 1e-9, met + 1e-9, 0.9])
    r = latched.simulate(1.0, times, accuracy=1e-4, progress=False)
    assert r.outcome is Outcome.OK
    assert max(errors(r, latched_motion(times)[1]).values()) <= 1e-4


# -- the trebuchet -----------------------------------------------------------------------------


@pytest.mark.parametrize("target", TARGETS)
def test_the_trebuchet(target: float) -> None:
    """One run with a rigid contact that opens, a release, and an end by a condition."""
    r = load("trebuchet").simulate(20.0, accuracy=target, progress=False)
    assert (r.outcome, r.ended_by) == (Outcome.OK, "landed")
    exact = reference()
    rows = []
    for t in [*r.t[:-1].tolist(), exact.landed]:
        (angles, rates), (at, v) = exact.angles(t), exact.ball(t)
        fall = v.imag if t < exact.landed else 0.0  # behind the impact
        rows.append([*angles[:2], *rates[:2], at.real, at.imag, v.real, fall])
    names = ("beam.phi", "counterweight.phi", "beam.omega", "counterweight.omega")
    names += ("ball.x", "ball.y", "ball.vx", "ball.vy")
    found = max(errors(r, dict(zip(names, np.array(rows).T, strict=True))).values())
    assert found <= max(target, 1e-10)  # to which the reference is known
    assert found <= LENIENT * max(r.accuracy.estimated, 1e-12)
    assert abs(r.t[-1] - exact.landed) / exact.landed <= target
    assert abs(r.reconnections[0].time - exact.released) / exact.landed <= target


# -- ends and horizons -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swung(workshop: Path) -> Machine:
    model = Model("accurate_end")
    mass = model.particle("mass", 2.0)
    model.absolute("rail", mass, "y", 0.0)
    model.spring("tie", model.ground.at(-9, 0), mass, stiffness=18.0, free_length=9.0)
    start = {mass.x: 1.0, mass.vx: 0.0}
    model.scene("swings", ["tie"], start=start, until={"left": mass.x < -0.5})
    model.scene("grazes", ["tie"], start=start, until={"left": mass.x < -1 + 1e-9})
    model.scene("held", ["tie"], start=start, until={"right": mass.x > 0.5})
    return load(model, "swings", folder=workshop)


@pytest.mark.parametrize("quantities", [None, ("mass.x",), ("mass.x", "kinetic", "a(mass.x)")])
@pytest.mark.parametrize("target", TARGETS)
def test_a_run_that_a_condition_ends(
    swung: Machine, target: float, quantities: tuple[str, ...] | None
) -> None:
    r = swung.simulate(5.0, accuracy=target, quantities=quantities, progress=False)
    assert (r.outcome, r.ended_by) == (Outcome.OK, "left")
    end = np.arccos(-0.5) / 3
    assert max(errors(r, {"mass.x": np.cos(3 * r.t)}).values()) <= target
    assert abs(r.t[-1] - end) / end <= min(target, LENIENT * max(estimates(r)["t(left)"], 1e-15))
    assert r.q("mass.x")[-1] == pytest.approx(-0.5, abs=target)


def test_one_that_holds_at_the_start_ends_the_run_there(swung: Machine, workshop: Path) -> None:
    machine = load(swung.mechanism.origin.model, "held", folder=workshop)
    r = machine.simulate(5.0, accuracy=1e-6, progress=False)
    assert (r.outcome, r.ended_by, r.t.tolist()) == (Outcome.OK, "right", [0.0])


@pytest.mark.parametrize("target", [1e-3, 1e-6])
def test_runs_that_end_differently_are_no_evidence(
    swung: Machine, workshop: Path, target: float
) -> None:
    """A condition that holds for 4e-5 of a swing: a loose run may miss it, and the target says so.

    Where all do, the result goes on; where the last ones end, the instant is known to the root of
    the error of the position.
    """
    machine = load(swung.mechanism.origin.model, "grazes", folder=workshop)
    r = machine.simulate(1.5, accuracy=target, progress=False)
    if r.ended_by:
        assert abs(r.t[-1] - np.pi / 3) < 2e-3
    else:
        assert r.t[-1] == 1.5
    assert max(errors(r, {"mass.x": np.cos(3 * r.t)}).values()) <= target
    loose, tight = r.accuracy.runs[-2:]
    assert f"between rtol = {loose.rtol:.1e} and {tight.rtol:.1e}" in r.accuracy.means
    assert loose.events == tight.events == bool(r.ended_by)


@pytest.fixture(scope="module")
def chaotic(workshop: Path) -> Machine:
    """A double pendulum that is cut loose after many turns."""
    model = Model("accurate_horizon", gravity=(0, -G))
    upper, lower = (model.body(name, mass=1.0, inertia=0.1) for name in ("upper", "lower"))
    model.revolute("hinge", model.ground.at(0, 0), upper.at(-0.5, 0))
    knee = model.revolute("knee", upper.at(0.5, 0), lower.at(-0.5, 0))
    from codegen import t

    model.release(knee, when=t > 59.0)
    start = {upper.phi: 1.5, upper.omega: 0.0, lower.phi: 2.5, lower.omega: 0.0}
    model.scene("thrown", ["gravity"], start=start)
    return load(model, folder=workshop)


def test_a_horizon_cuts_what_comes_behind(chaotic: Machine, tmp_path: Path) -> None:
    r = chaotic.simulate(60.0, accuracy=1e-6, progress=False)
    assert r.outcome is Outcome.INACCURATE
    assert r.t[-1] == r.accuracy.horizon < 59.0
    assert r.reconnections == ()
    r.save(tmp_path / "thrown.nc")
    back = load_result(tmp_path / "thrown.nc", chaotic)
    assert (back.outcome, back.accuracy) == (r.outcome, r.accuracy)
    assert np.array_equal(back.samples.q, r.samples.q)
    assert back.reconnections == ()
    assert back.at(r.t[-1] / 2).q("upper.phi") == r.at(r.t[-1] / 2).q("upper.phi")
