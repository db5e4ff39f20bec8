"""Forces and torques of actuators in place of drivers: virtual work, statics by hand, refusals."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from sympy import cos, pi, sin

from codegen import Model, t
from codegen.errors import AnalysisError, InputError
from runtime import Result, load, load_result
from runtime.machine_facade import Machine
from runtime.show.pictures import moving_picture

G = 9.81
ARMS = (0.5, 0.7, 0.7, 0.5)  # a, b, c, e of the robot, m
MASSES, INERTIAS = (1.0, 1.2, 1.4, 1.6), (0.02, 0.03, 0.04, 0.05)
MOTORS = ["motor_1", "motor_2"]


def robot(*, elbow: bool = False) -> Model:
    """A five-bar robot, the end point of which is driven: motors at the base, one at an elbow."""
    model = Model("five_bar_robot", gravity=(0, -G))
    ground = model.ground
    a, b, c, e = (
        model.body(name, mass=m, inertia=i)
        for name, m, i in zip("abce", MASSES, INERTIAS, strict=True)
    )
    la, lb, lc, le = ARMS
    model.revolute("A", ground.at(-0.3, 0), a.at(-la / 2, 0))
    model.revolute("E", ground.at(0.3, 0), e.at(-le / 2, 0))
    model.revolute("B", a.at(la / 2, 0), b.at(-lb / 2, 0))
    model.revolute("D", e.at(le / 2, 0), c.at(-lc / 2, 0))
    model.revolute("C", b.at(lb / 2, 0), c.at(lc / 2, 0))
    model.torque("motor_1", on=a, value=7.0 * t)  # a law that the search replaces
    model.motor("motor_2", on=e, stall_torque=3.0, no_load_speed=10.0)
    model.torque("elbow", on=b, from_=a, value=1.0)
    model.torque("again", on=a, value=1.0)
    model.spring("strut", a, e, 10.0, free_length=0.3)
    model.point_driver("reach", b.at(lb / 2, 0), "x", 0.1 * cos(3 * t))
    model.point_driver("lift", b.at(lb / 2, 0), "y", 0.8 + 0.1 * sin(3 * t))
    guess = {a.phi: 1.9, b.phi: 0.6, e.phi: 1.2, c.phi: 2.5, a.x: -0.4, a.y: 0.2, b.x: -0.2,
             b.y: 0.6, c.x: 0.2, c.y: 0.6, e.x: 0.4, e.y: 0.2}  # fmt: skip
    acting, driven = ["gravity", *MOTORS], ["reach", "lift"]
    if elbow:
        model.scene("spare", [*acting, "elbow", "again", "strut"], driven, guess=guess)
    else:
        model.scene("draw", acting, driven, guess=guess)
        model.scene("bare", acting, driven, guess=guess, outputs=[])
    return model


def work_by_angles(r: Result, k: int) -> tuple[Any, Any]:
    """Generalized forces on the angles of a and e that the motion takes, and dφ_b by these."""
    la, lb, lc, le = ARMS
    phi = {name: r.q(f"{name}.phi")[k] for name in "abce"}
    along = {name: np.array([-np.sin(phi[name]), np.cos(phi[name])]) for name in "abce"}
    closed = np.column_stack([lb * along["b"], -lc * along["c"]])
    moved = np.linalg.solve(closed, np.column_stack([-la * along["a"], le * along["e"]]))
    turns = {"a": [1.0, 0.0], "e": [0.0, 1.0], "b": moved[0], "c": moved[1]}
    turn = {name: np.array(row) for name, row in turns.items()}
    places = {
        "a": np.outer(la / 2 * along["a"], turn["a"]),
        "e": np.outer(le / 2 * along["e"], turn["e"]),
        "b": np.outer(la * along["a"], turn["a"]) + np.outer(lb / 2 * along["b"], turn["b"]),
        "c": np.outer(le * along["e"], turn["e"]) + np.outer(lc / 2 * along["c"], turn["c"]),
    }
    total = np.zeros(2)
    for name, mass, inertia in zip("abce", MASSES, INERTIAS, strict=True):
        a = np.array([r.a(f"{name}.x")[k], r.a(f"{name}.y")[k] + G])
        total += mass * a @ places[name] + inertia * r.a(f"{name}.phi")[k] * turn[name]
    return total, turn["b"]


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    monkeypatch.chdir(tmp_path)
    return load(robot())


@pytest.fixture
def make_press(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Machine]:
    """A press: crank, rod and a ram that works; the crank is turned from the upper dead centre."""
    monkeypatch.chdir(tmp_path)

    def make(rubbing: bool = False, **scene: Any) -> Machine:
        model = Model("toggle_press", gravity=(0, -G))
        ground = model.ground
        crank = model.body("crank", mass=2.0, inertia=0.05)
        rod, ram = model.body("rod", mass=3.0, inertia=0.2), model.body("ram", 20.0, 0.3)
        pin = model.revolute("A", ground.at(0, 0), crank.at(0, 0))
        model.revolute("B", crank.at(0.1, 0), rod.at(-0.2, 0))
        model.revolute("C", rod.at(0.2, 0), ram.at(0, 0))
        model.translational("guide", ground.at(0, 0), ram.at(0, 0), axis=(0, 1))
        model.torque("motor", on=crank, value=0)
        model.line_force("cylinder", ground.at(0, 2), ram.at(0, 0), 3.0)
        model.force("push", on=ram, fy=1.0)
        model.force("skew", on=ram, fx=1.0, fy=1.0)
        model.force("work", on=ram, fy=-1000 * (1 - ram.vy))
        model.friction("rub", pin, 0.3, creep=0.01, radius=0.05)
        model.rotation_driver("spin", ground, crank, pi * t + pi / 2)
        acting = ["gravity", "motor", "cylinder", "push", "skew", "work"] + ["rub"] * rubbing
        guess = {crank.phi: 1.57, rod.phi: 1.57, ram.y: 0.5, rod.y: 0.3}
        model.scene("run", acting, ["spin"], guess=guess, **scene)
        return load(model)

    return make


def test_motors_of_a_robot_do_the_virtual_work_of_its_motion(machine: Machine) -> None:
    r = machine.inverse_dynamics(2.0, 41, unknown=MOTORS)
    work = np.array([work_by_angles(r, k)[0] for k in range(len(r.t))])
    found = np.column_stack([r.torque(name) for name in MOTORS])
    assert_allclose(found, work, rtol=1e-12, atol=1e-12 * np.abs(work).max())
    assert_allclose(r.power("motor_2"), found[:, 1] * r.rate("motor_2"), rtol=1e-13)
    assert np.abs(r.reaction("reach", "fx")).max() < 1e-12 * np.abs(work).max()
    assert np.abs(r.reaction("lift", "fy")).max() < 1e-12 * np.abs(work).max()
    assert "Sought: motor_1, motor_2, in place of reach, lift." in r.message


def test_joints_bear_what_they_bear_with_these_torques_as_laws(machine: Machine) -> None:
    """The torques that were found at an instant are declared: drivers have nothing to do there."""
    r = machine.inverse_dynamics([0.0, 0.7], unknown=MOTORS)
    model = robot()
    a, e = model.bodies["a"], model.bodies["e"]
    for body, name in ((a, "motor_1"), (e, "motor_2")):
        model.torque(f"{name}_known", on=body, value=float(r.torque(name)[1]))
    known = model.scene("draw").without(*MOTORS).with_("motor_1_known", "motor_2_known")
    same = load(model, known).inverse_dynamics([0.0, 0.7])
    for joint in "AEBDC":
        for part in ("fx", "fy"):
            expected = same.reaction(joint, part)[1]
            assert_allclose(r.reaction(joint, part)[1], expected, rtol=1e-11, atol=1e-11)
    assert abs(same.reaction("lift", "fy")[1]) < 1e-11


def test_of_more_unknowns_the_values_of_least_weighted_norm_are_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    model = robot(elbow=True)
    scene = model.scene("spare").without("strut", "again")
    names, weights = [*MOTORS, "elbow"], np.array([1.0, 0.5, 3.0])
    given = dict(zip(names[1:], weights[1:], strict=True))
    r = load(model, scene).inverse_dynamics(1.0, 11, unknown=names, weights=given)
    for k in range(len(r.t)):
        work, turn = work_by_angles(r, k)
        matrix = np.column_stack([np.eye(2), turn - [1.0, 0.0]]) / weights
        expected = np.linalg.lstsq(matrix, work, rcond=None)[0] / weights
        assert_allclose([r.torque(name)[k] for name in names], expected, rtol=1e-11)
    assert "3 for 2 driven" in r.message
    assert "motor_1 1, motor_2 0.5, elbow 3" in r.message


def test_the_motor_of_a_press_has_the_power_of_what_it_moves(
    make_press: Callable[..., Machine],
) -> None:
    r = make_press().inverse_dynamics(1.9, 20, unknown=["motor"])
    power = 0.05 * r.a("crank.phi") * r.v("crank.omega") + r.v("crank.vy") * 2.0 * G
    for body, mass, inertia in (("rod", 3.0, 0.2), ("ram", 20.0, 0.3)):
        power += mass * r.a(f"{body}.x") * r.v(f"{body}.vx") + mass * G * r.v(f"{body}.vy")
        power += mass * r.a(f"{body}.y") * r.v(f"{body}.vy")
        power += inertia * r.a(f"{body}.phi") * r.v(f"{body}.omega")
    ram = r.v("ram.vy")
    power -= (2.0 - 1000 * (1 - ram)) * ram + 3.0 * ram  # push, skew, work; the cylinder pulls up
    assert_allclose(r.torque("motor"), power / np.pi, rtol=1e-12, atol=1e-12 * np.abs(power).max())


def test_a_force_at_a_dead_centre_does_nothing_and_is_no_number(
    make_press: Callable[..., Machine],
) -> None:
    machine = make_press()
    r = machine.inverse_dynamics([0.0, 0.25, 0.5, 1.0, 1.25], unknown=["push"])
    assert_array_equal(np.isnan(r.force("push", "fy")), [True, False, False, True, False])
    assert_array_equal(np.isnan(r.reaction("B", "fx")), np.isnan(r.force("push", "fy")))
    assert np.isfinite(r.a("ram.y")).all()
    assert not r.failed
    assert "At 2 instants (t = 0, 1 s) no values of them, or any" in r.message
    assert np.isnan(r.at(1.0).force("push", "fy")).all()
    with pytest.raises(AnalysisError, match=r"push move 0 of these 1: nothing .* moves by push"):
        machine.inverse_dynamics([0.0], unknown=["push"])


def test_cylinders_of_an_excavator_hold_its_arms_by_statics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Moments about the pins: the stick's cylinder by the stick, the boom's by both arms."""
    monkeypatch.chdir(tmp_path)
    model = Model("excavator_arm", gravity=(0, -G))
    ground = model.ground
    boom, stick = model.body("boom", mass=900.0, inertia=800.0), model.body("stick", 400.0, 150.0)
    model.revolute("foot", ground.at(0, 0), boom.at(-2.0, 0))
    model.revolute("head", boom.at(2.0, 0), stick.at(-1.0, 0))
    model.line_force("lifter", ground.at(0.5, -0.6), boom.at(-0.5, 0.2), 1.0)
    model.line_force("puller", boom.at(0.5, 0.5), stick.at(-1.4, 0.3), 1.0)
    model.rotation_driver("hoist", ground, boom, 0.6)
    model.rotation_driver("bend", boom, stick, -1.5)
    guess = {boom.phi: 0.6, stick.phi: -0.9, boom.x: 1.6, boom.y: 1.1, stick.x: 4, stick.y: 1.5}
    model.scene("hold", ["gravity", "lifter", "puller"], ["hoist", "bend"], guess=guess)
    r = load(model).inverse_dynamics([0.0], unknown=["lifter", "puller"])

    def turned(phi: float, x: float, y: float) -> Any:
        return np.array([np.cos(phi) * x - np.sin(phi) * y, np.sin(phi) * x + np.cos(phi) * y])

    def moment(arm: Any, force: Any) -> float:
        return float(arm[0] * force[1] - arm[1] * force[0])

    head, weight = turned(0.6, 4.0, 0.0), np.array([0.0, -G])
    low, high = turned(0.6, 2.5, 0.5), head + turned(-0.9, -0.4, 0.3)
    pull = (low - high) / np.linalg.norm(low - high)  # on the stick, in tension
    of_stick = moment(turned(-0.9, 1.0, 0.0), 400.0 * weight)
    puller = -of_stick / moment(high - head, pull)
    both = of_stick + moment(head, 400.0 * weight) + moment(turned(0.6, 2.0, 0.0), 900.0 * weight)
    place, base = turned(0.6, 1.5, 0.2), np.array([0.5, -0.6])
    lift = (base - place) / np.linalg.norm(base - place)
    lifter = -both / moment(place, lift)
    assert_allclose(r.force("puller"), puller, rtol=1e-12)
    assert_allclose(r.force("lifter"), lifter, rtol=1e-12)


def test_friction_in_joints_follows_from_the_reactions_with_the_actuator(
    make_press: Callable[..., Machine],
) -> None:
    """The cylinder pulls the crank about; the friction in its bearing knows what it bears then."""
    machine = make_press(rubbing=True)
    r = machine.inverse_dynamics([0.1, 0.3, 0.9], unknown=["cylinder"])
    bearing = np.hypot(r.reaction("A", "fx"), r.reaction("A", "fy"))
    assert_allclose(r.torque("rub"), -0.3 * 0.05 * bearing, rtol=1e-9)
    assert np.abs(r.reaction("spin", "torque")).max() < 1e-10
    plain = machine.inverse_dynamics([0.1, 0.3, 0.9], unknown=["motor"])
    assert np.abs(plain.reaction("spin", "torque")).max() < 1e-10


def test_result_is_asked_later_saved_and_drawn(machine: Machine, tmp_path: Path) -> None:
    r = machine.inverse_dynamics(1.0, 11, unknown=MOTORS, weights={"motor_1": 2.0})
    between = machine.inverse_dynamics([0.0, 0.33], unknown=MOTORS)
    assert_allclose(r.at(0.33).torque("motor_1"), between.torque("motor_1")[1:], rtol=1e-12)
    later = r.torque("motor_1")
    bare = load(robot(), "bare").inverse_dynamics(1.0, 11, unknown=MOTORS)
    assert_allclose(bare.torque("motor_1"), later, rtol=1e-12)
    assert_allclose(bare.power("motor_1"), later * r.v("a.omega"), rtol=1e-12)  # not an output
    r.save("r.nc")
    for back in (load_result("r.nc"), load_result("r.nc", machine=load(robot()))):
        assert_array_equal(back.torque("motor_1"), later)
        assert_array_equal(back.at(0.33).torque("motor_2"), r.at(0.33).torque("motor_2"))
    drawn = [s.shape.torque for s in moving_picture(r).symbols if s.element == "motor_1"]
    assert_array_equal(drawn[0], later)


def test_scene_without_unknowns_knows_nothing_of_them(machine: Machine) -> None:
    files = sorted(path.name for path in machine.path.parent.glob("*.py"))
    text = machine.path.read_text(encoding="utf-8")
    machine.inverse_dynamics([0.0, 0.1], unknown=MOTORS)
    assert machine.path.read_text(encoding="utf-8") == text
    assert "UNKNOWN" not in text
    assert not machine.inverse_dynamics([0.0, 0.1]).description.unknown
    more = {path.name for path in machine.path.parent.glob("*.py")} - {*files}
    assert more == {"five_bar_robot__draw_unknown_motor_1_motor_2.py"}


def test_numbers_of_a_frozen_scene_stay_numbers(make_press: Callable[..., Machine]) -> None:
    r = make_press(frozen=True).inverse_dynamics([0.1, 0.2], unknown=["motor"])
    assert_allclose(
        r.torque("motor"),
        make_press().inverse_dynamics([0.1, 0.2], unknown=["motor"]).torque("motor"),
    )


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ({"unknown": ["motor_1"]}, "motor_1 for 2 driven coordinates"),
        ({"unknown": []}, "none for 2 driven coordinates"),
        ({"unknown": ["motor_1", "motor"]}, "'motor' is no torque.*did you mean 'motor_"),
        ({"unknown": ["motor_1", "strut"]}, "'strut' is no torque, line force"),
        ({"unknown": ["motor_1", "gravity"]}, "'gravity' is no torque, line"),
        ({"unknown": ["motor_1", "reach"]}, "'reach' is no torque, line force"),
        ({"unknown": ["motor_1", "again"]}, "motor_1, again depend on each other"),
        ({"unknown": "motor_1"}, "unknown is 'motor_1'; it must be a sequence"),
        ({"unknown": MOTORS, "weights": {"elbow": 1.0}}, "weights: There is no unknown 'elbow'"),
        ({"unknown": MOTORS, "weights": {"motor_1": 0.0}}, "weight of motor_1 is 0.0; give a pos"),
        ({"unknown": MOTORS, "weights": {"motor_1": "2"}}, "weight of motor_1 is '2'; give a pos"),
        ({"unknown": MOTORS, "parameters": {"motor_1": 1.0}}, "no parameter 'motor_1'"),
        ({"weights": {"motor_1": 1.0}}, "unknown is none for 2 driven"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: dict[str, Any], expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((InputError, AnalysisError), match=expected):
        load(robot(elbow=True)).inverse_dynamics([0.0, 0.1], **words)


def test_force_of_two_components_has_no_single_value(make_press: Callable[..., Machine]) -> None:
    with pytest.raises(InputError, match=r"'skew' is no .* force of one component"):
        make_press().inverse_dynamics([0.1], unknown=["skew"])


def test_ensembles_refuse_unknowns_by_name(machine: Machine) -> None:
    given: Any = {"unknown": MOTORS}
    with pytest.raises(InputError, match="unexpected keyword argument 'unknown'"):
        machine.ensemble(1.0, analysis="inverse_dynamics", **given)


def test_force_of_a_cylinder_is_in_the_result(make_press: Callable[..., Machine]) -> None:
    r = make_press().inverse_dynamics([0.1, 0.2], unknown=["cylinder"])
    assert "force(cylinder)" in r.description.outputs
    assert_array_equal(r.data["force"].sel(effect="cylinder"), r.force("cylinder"))
