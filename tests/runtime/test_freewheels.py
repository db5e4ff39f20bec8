"""Rigid one-way clutches: motions in closed form, impacts by hand, methods and formulations."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from sympy import Piecewise, cos

from codegen import Body, Model, t
from codegen.errors import AnalysisError, ModelError
from runtime import Outcome, Result, load

J = 0.5, 0.3
EXACT = 1e-9


def shafts(name: str, inertias: tuple[float, ...] = J) -> tuple[Model, list[Body]]:
    """Bodies on bearings of their own."""
    model = Model(name, gravity=(0, -9.81))
    bodies = [model.body(f"b{k}", mass=1.0, inertia=size) for k, size in enumerate(inertias)]
    for k, body in enumerate(bodies):
        model.revolute(f"bearing_{k}", model.ground.at(k, 0), body)
    return model, bodies


def start(bodies: list[Body], *speeds: float) -> dict[object, float]:
    at_rest = {body.phi: 0.0 for body in bodies}
    return at_rest | {b.omega: speed for b, speed in zip(bodies, speeds, strict=True)}


def simulated(model: Model, folder: Path, t_end: float, **settings: object) -> Result:
    instants = np.linspace(0, t_end, 121)
    settings = {"rtol": 1e-12, "atol": 1e-13} | settings
    run = load(model, folder=folder).simulate(t_end, instants, **settings)
    assert run.outcome is Outcome.OK, run.message
    return run


def test_a_drive_that_brakes_is_overrun_and_catches_up(tmp_path: Path) -> None:
    """2 N m for 1 s, back for 1 s, and on: it grips, overruns from 1 s, and grips from 3 s on."""
    model, bodies = shafts("braking")
    model.one_way_clutch("clutch", *bodies)
    model.torque("motor", bodies[0], Piecewise((2.0, t < 1), (-2.0, t < 2), (2.0, True)))
    model.scene("run", ["clutch", "motor"], start=start(bodies, 0.0, 0.0), outputs="all")
    run = simulated(model, tmp_path, 4.0)
    both, alone = 2.0 / sum(J), 2.0 / J[0]
    driven = both * np.where(run.t < 1, run.t, np.maximum(run.t - 2, 1))
    fallen = alone * (1 - np.abs(run.t - 2))
    driver = np.where((run.t > 1) & (run.t < 3), driven - fallen, driven)
    assert_allclose(run.v("b1.phi"), driven, atol=EXACT)
    assert_allclose(run.v("b0.phi"), driver, atol=EXACT)
    assert_allclose(run.rate("clutch"), driven - driver, atol=EXACT)
    beside = (np.abs(run.t - 1) > 1e-9) & (np.abs(run.t - 3) > 1e-9)
    torque = np.where((run.t < 1) | (run.t > 3), both * J[1], 0.0)
    assert_allclose(run.torque("clutch")[beside], torque[beside], atol=EXACT)
    changes = [(event.time, event.word) for event in run.events if event.name.startswith("clutch")]
    assert [what for _, what in changes] == ["overruns", "grips"]
    assert_allclose([time for time, _ in changes], [1.0, 3.0], atol=EXACT)


@pytest.mark.parametrize("light", [0.3, 1e-3, 1e-6])
def test_an_impact_of_two_freewheels_keeps_the_momentum(tmp_path: Path, light: float) -> None:
    """Three shafts in a row have one speed behind it, however light the one between."""
    model, bodies = shafts("impact", (0.5, light, 0.2))
    model.one_way_clutch("first", *bodies[:2])
    model.one_way_clutch("second", *bodies[1:])
    model.torque("brake", bodies[2], -0.4)
    given = start(bodies, 3.0, 0.0, -1.0)
    model.scene("run", ["first", "second", "brake"], start=given, outputs="all")
    run = simulated(model, tmp_path, 1.0)
    whole = 0.5 + light + 0.2
    speed = (0.5 * 3.0 - 0.2) / whole
    for body in bodies:
        assert_allclose(run.v(f"{body.name}.phi"), speed - 0.4 / whole * run.t, atol=EXACT)
    assert_allclose(run.torque("first"), 0.4 * 0.5 / whole, atol=EXACT)
    assert_allclose(run.torque("second"), 0.4 * (0.5 + light) / whole, atol=EXACT)
    lost = 0.5 * 0.5 * 3.0**2 + 0.5 * 0.2 - run.energy("kinetic")[0]
    assert_allclose(lost, 0.5 * 0.5 * 3.0**2 + 0.1 - 0.5 * whole * speed**2, atol=EXACT)


def test_an_impact_leaves_what_it_need_not_stop(tmp_path: Path) -> None:
    """The third shaft is faster than what the first and the second agree on: it overruns."""
    model, bodies = shafts("partial", (0.5, 0.3, 0.2))
    model.one_way_clutch("first", *bodies[:2])
    model.one_way_clutch("second", *bodies[1:])
    model.scene("run", ["first", "second"], start=start(bodies, 3.0, 0.0, 2.5), outputs="all")
    run = simulated(model, tmp_path, 1.0)
    assert_allclose(run.v("b0.phi"), 1.5 / 0.8, atol=EXACT)
    assert_allclose(run.v("b1.phi"), 1.5 / 0.8, atol=EXACT)
    assert_allclose(run.v("b2.phi"), 2.5, atol=EXACT)
    assert_allclose(run.torque("second"), 0.0, atol=0)


def test_two_opposite_freewheels_are_a_rigid_coupling(tmp_path: Path) -> None:
    model, (one, two) = shafts("coupling")
    model.one_way_clutch("forward", one, two)
    model.one_way_clutch("back", two, one)
    model.torque("motor", one, cos(5 * t))
    model.scene(
        "run", ["forward", "back", "motor"], start=start([one, two], 3.0, 0.0), outputs="all"
    )
    run = simulated(model, tmp_path, 2.0)
    speed = (J[0] * 3.0 + np.sin(5 * run.t) / 5) / sum(J)
    for name in ("b0.phi", "b1.phi"):
        assert_allclose(run.v(name), speed, atol=EXACT)
    forward, back = run.torque("forward"), run.torque("back")
    assert_allclose(forward - back, np.cos(5 * run.t) * J[1] / sum(J), atol=EXACT)
    assert min(forward.min(), back.min()) >= -EXACT


def indexing() -> Model:
    """A crank-rocker turns a shaft with dry friction through a freewheel."""
    model = Model("indexing")
    crank = model.body("crank", mass=0.3, inertia=0.001)
    coupler = model.body("coupler", mass=0.5, inertia=0.02)
    rocker = model.body("rocker", mass=0.4, inertia=0.01)
    shaft = model.body("shaft", mass=2.0, inertia=0.05)
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.revolute("B", crank.at(0.1, 0), coupler.at(-0.2, 0))
    model.revolute("C", coupler.at(0.2, 0), rocker.at(0.25, 0))
    model.revolute("D", model.ground.at(0.4, 0), rocker.at(0, 0))
    model.revolute("E", model.ground.at(0.4, 0), shaft.at(0, 0))
    model.driver("motor", crank.phi, 10 * t)
    model.one_way_clutch("clutch", rocker, shaft)
    model.dry_friction("load", coefficient=0.08, normal=20.0, slip=0.5 * shaft.omega)
    model.scene(
        "run", ["clutch", "load"], ["motor"], start={shaft.phi: 0.0, shaft.omega: 0.0},
        guess={crank.phi: 0.0, coupler.phi: 0.6, rocker.phi: 1.9}, outputs="all",
    )  # fmt: skip
    return model


def rocker_speed(time: float) -> float:
    """ψ̇ of the crank-rocker, from the loop a e^{iφ} + b e^{iθ} = d + c e^{iψ} (elbow up)."""
    phi, a, b, c, d = 10.0 * time, 0.1, 0.4, 0.25, 0.4
    x, y = a * np.cos(phi) - d, a * np.sin(phi)  # the crank pin from the rocker's bearing
    r = np.hypot(x, y)
    psi = np.arctan2(y, x) - np.arccos((r * r + c * c - b * b) / (2 * r * c))
    theta = np.arctan2(c * np.sin(psi) - y, c * np.cos(psi) - x)
    return float(10.0 * a * np.sin(phi - theta) / (c * np.sin(psi - theta)))


def strokes(t_end: float) -> list[tuple[float, float, float, float]]:
    """(grips, overruns, speed there, rest) of each stroke: friction of 0.8 N m stops 0.05 kg m²."""
    inertia, load, fine = 0.05, 0.8, 1e-4

    def acceleration(time: float) -> float:
        five = (1, -8, 8, -1)
        at = (time - 2 * fine, time - fine, time + fine, time + 2 * fine)
        return sum(w * rocker_speed(x) for w, x in zip(five, at, strict=True)) / (12 * fine)

    found, times = [], np.linspace(0, t_end, 2001)
    speeds = [rocker_speed(time) for time in times]
    rises = [k for k in range(2000) if speeds[k] <= 0 < speeds[k + 1]]
    for k in rises:
        grips = brentq(rocker_speed, times[k], times[k + 1], xtol=1e-14)
        later = times[times > grips + 1e-3]
        brakes = (x for x in later if acceleration(x) < -load / inertia)
        after = next(brakes, None)
        if after is None:
            break
        overruns = brentq(lambda x: acceleration(x) + load / inertia, after - 1e-3, after)
        speed = rocker_speed(overruns)
        found.append((grips, overruns, speed, overruns + speed * inertia / load))
    return found


@pytest.mark.parametrize(
    ("method", "formulation"),
    [
        ("dop853", "cartesian"), ("dopri5", "reduced"), ("tsit5", "cartesian"),
        ("radau5", "reduced"), ("radau5", "cartesian"), ("bdf", "cartesian"), ("bdf", "reduced"),
    ],
)  # fmt: skip
def test_an_indexing_freewheel(tmp_path: Path, method: str, formulation: str) -> None:
    settings = {"method": method, "formulation": formulation, "rtol": 1e-11, "atol": 1e-12}
    run = simulated(indexing(), tmp_path, 1.5, **settings)
    expected = np.zeros(len(run.t))
    found = strokes(1.5)
    assert len(found) >= 2
    for grips, overruns, speed, rest in found:
        for k, time in enumerate(run.t):
            if grips < time <= overruns:
                expected[k] = rocker_speed(time)
            elif overruns < time < rest:
                expected[k] = speed - 0.8 / 0.05 * (time - overruns)
    known = run.t < found[-1][3]
    assert_allclose(run.v("shaft.phi")[known], expected[known], atol=2e-9)


def test_a_sprag_holds_a_load_that_does_not_fall_back(tmp_path: Path) -> None:
    """A drum of 0.5 m lifts 3 kg by 20 N m for 1 s; the sprag in the ground bears its weight."""
    model = Model("hoist", gravity=(0, -9.81))
    drum, load = model.body("drum", mass=1.0, inertia=0.2), model.body("load", mass=3.0, inertia=1)
    model.revolute("bearing", model.ground.at(0, 0), drum)
    model.translational("guide", model.ground.at(0.5, 0), load.at(0, 0), axis=(0, 1))
    model.constraint("rope", load.y - 0.5 * drum.phi)
    model.torque("motor", drum, Piecewise((20.0, t < 1), (0.0, t < 2), (18.0, True)))
    model.one_way_clutch("sprag", model.ground, drum)
    still = {drum.phi: 0.0, drum.omega: 0.0}
    model.scene("run", ["gravity", "motor", "sprag"], start=still, outputs="all")
    run = simulated(model, tmp_path, 3.0)
    weight, inertia = 3.0 * 9.81 * 0.5, 0.2 + 3.0 * 0.25
    up, down, again = ((torque - weight) / inertia for torque in (20.0, 0.0, 18.0))
    stops = 1.0 - up / down
    angle = np.where(run.t < 1, up * run.t**2 / 2, 0.0)
    risen = up / 2 + up * (np.minimum(run.t, stops) - 1)
    risen += down * (np.minimum(run.t, stops) - 1) ** 2 / 2
    angle = np.where(run.t >= 1, risen + again * np.maximum(run.t - 2, 0) ** 2 / 2, angle)
    assert_allclose(run.q("load.y"), angle / 2, atol=EXACT)
    held = (run.t > stops) & (run.t < 2 - 1e-9)
    assert held.sum() > 20
    assert_allclose(run.torque("sprag")[held], weight, atol=EXACT)
    assert_allclose(run.torque("sprag")[run.t > 2.01], 0.0, atol=0)


@pytest.mark.parametrize("restitution", [0.6, 0.0])
def test_a_rebound_sets_a_flywheel_going(tmp_path: Path, restitution: float) -> None:
    """A body of 2 kg on a rope about a drum hits the floor; the drum drives by a freewheel.

    It rebounds with e ẏ⁻, and then the flywheel, which overran, takes its part of the momentum.
    """
    model = Model("rebound", gravity=(0, -9.81))
    body = model.body("body", mass=2.0, inertia=0.1)
    drum, wheel = (model.body(n, mass=1.0, inertia=s) for n, s in (("drum", 0.05), ("wheel", 0.4)))
    model.translational("guide", model.ground.at(0, 0), body.at(0, 0), axis=(0, 1))
    model.revolute("A", model.ground.at(1, 0), drum)
    model.revolute("B", model.ground.at(1, 0), wheel)
    model.constraint("rope", body.y - 0.2 * drum.phi - 1.0)
    floor = {"free_length": 0.0, "direction": (0, 1)}
    model.contact("floor", model.ground.at(0, 0), body.at(0, 0), restitution=restitution, **floor)
    model.one_way_clutch("clutch", drum, wheel)
    model.scene(
        "run", ["gravity", "floor", "clutch"], start=start([drum, wheel], 0.0, 0.0), outputs="all"
    )
    run = simulated(model, tmp_path, 0.7)
    mass = 2.0 + 0.05 / 0.2**2
    acceleration = 2.0 * 9.81 / mass
    lands = np.sqrt(2.0 / acceleration)
    leaves = mass * restitution * acceleration * lands / (mass + 0.4 / 0.2**2)
    after = run.t > lands
    assert_allclose(run.v("wheel.phi")[after], leaves / 0.2, atol=EXACT)
    assert_allclose(run.v("wheel.phi")[~after], 0.0, atol=0)
    if restitution > 0:
        flown = run.t[after] - lands
        assert_allclose(run.v("body.y")[after], leaves - acceleration * flown, atol=EXACT)
    else:
        assert_allclose(run.q("body.y")[after], 0.0, atol=EXACT)


def test_what_does_not_decide_whether_it_grips_is_refused_by_name(tmp_path: Path) -> None:
    model, bodies = shafts("refused")
    model.one_way_clutch("clutch", *bodies)
    model.driver("turns", bodies[0].phi, t)
    model.driver("follows", bodies[1].phi, t)
    model.scene("driven", ["clutch"], ["turns", "follows"])
    model.scene("free", ["clutch"], start=start(bodies, 0.0, 0.0))
    with pytest.raises(
        AnalysisError, match="which one-way clutches grip, and this scene has clutch"
    ):
        load(model, "free", folder=tmp_path).equilibrium()
    with pytest.raises(AnalysisError, match="which one-way clutches grip"):
        load(model, "driven", folder=tmp_path).inverse_dynamics(1.0)


def test_two_freewheels_of_one_slip_are_refused(tmp_path: Path) -> None:
    model, bodies = shafts("twice")
    model.one_way_clutch("first", *bodies)
    model.one_way_clutch("second", *bodies)
    model.scene("run", ["first", "second"], start=start(bodies, 0.0, 0.0))
    with pytest.raises(ModelError, match="'first' and 'second' are freewheels of one slip"):
        load(model, folder=tmp_path)


def test_drivers_against_a_freewheel_end_the_run_by_name(tmp_path: Path) -> None:
    """No impact makes the slip of -1 rad/s that they prescribe any faster."""
    model, bodies = shafts("forced")
    model.one_way_clutch("clutch", *bodies)
    for k, (body, speed) in enumerate(zip(bodies, (2, 1), strict=True)):
        model.driver(f"turns_{k}", body.phi, speed * t)
    model.scene("run", ["clutch"], ["turns_0", "turns_1"], outputs="all")
    run = load(model, folder=tmp_path).simulate(1.0, 6)
    assert run.outcome is Outcome.INCONSISTENT
    assert "clutch" in run.message
    assert run.t[-1] == 0.0
