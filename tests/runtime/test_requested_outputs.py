"""Outputs that have to be asked for: paths of points, and works of effects."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.errors import InputError
from runtime import Machine, Result, load
from runtime.results.export import table

INSTANTS = np.linspace(0.0, 3.0, 61)
TIP = (0.3, -0.2)


def swing() -> Model:
    """A pendulum with a damper, a motor that acts one way, a spring and a wall to lean on."""
    model = Model("led_swing", gravity=(0, -9.81))
    c = model.parameter("c", 0.3, unit="N m s/rad")
    bob = model.body("bob", mass=2.0, inertia=0.1)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.torque("damper", on=bob, value=-c * bob.omega)
    model.torque("motor", on=bob, value=1.5, when=bob.omega > 0)
    model.spring("spring", model.ground.at(0, 2), bob, 2.0, free_length=0.5)
    model.contact("wall", gap=bob.phi + 1.9, stiffness=2e3, damping=5.0)
    model.track("tip", bob.at(*TIP))
    model.track("middle", bob)
    model.driver("hand", bob.phi, 0.2 * t)
    every = ["gravity", "damper", "motor", "spring", "wall"]
    model.scene("all", every, start={bob.phi: -0.5, bob.omega: 0.0},
                outputs=["reactions", "energy", "powers", "works", "points"])  # fmt: skip
    model.scene("plain", every, start={bob.phi: -0.5, bob.omega: 0.0})
    model.scene("led", ["gravity"], ["hand"], outputs=["work(hand)", "point(tip)"])
    model.scene("moved", drivers=["hand"], analysis="kinematics", outputs=["point(tip)"])
    return model


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("asked")


@pytest.fixture(scope="module")
def machine(folder: Path) -> Machine:
    return load(swing(), "all", folder=folder)


@pytest.fixture(scope="module")
def told(machine: Machine) -> Result:
    return machine.simulate(3.0, INSTANTS, rtol=1e-10)


def tip(phi: np.ndarray) -> np.ndarray:
    """Closed form: the hinge at the origin, the body's centre 1 m from it."""
    x, y = 1 + TIP[0], TIP[1]
    c, s = np.cos(phi), np.sin(phi)
    return np.column_stack([c * x - s * y, s * x + c * y])


def test_works_are_the_energy_that_the_motion_has(told: Result) -> None:
    assert {"gravity", "damper", "motor", "spring", "wall"} == set(told.works)
    assert len(told.events) > 4
    gained = told.energy("kinetic") - told.energy("kinetic")[0]
    done = sum(told.work(name) for name in told.works)
    assert_allclose(done, gained, atol=1e-7)
    height = told.q("bob.y")
    assert_allclose(told.work("gravity"), -2.0 * 9.81 * (height - height[0]), atol=1e-7)
    assert (np.diff(told.work("damper")) <= 1e-12).all()
    assert told.work("damper")[-1] < -0.1
    assert (np.diff(told.work("motor")) >= -1e-12).all()
    assert np.abs(told.work("wall")).max() > 1e-3


def test_works_do_not_depend_on_the_instants(machine: Machine, told: Result) -> None:
    few = machine.simulate(3.0, [1.5, 3.0], rtol=1e-10)
    steps = machine.simulate(3.0, "steps", rtol=1e-10)
    assert few.t.tolist() == [1.5, 3.0]
    assert len(steps.t) == steps.stats["steps"] + 1
    for name in told.works:
        assert_allclose(few.work(name), told.work(name)[[30, 60]], atol=1e-8)
        assert_allclose(steps.work(name)[-1], told.work(name)[-1], atol=1e-8)


def test_asking_changes_no_digit_of_the_motion(told: Result, folder: Path) -> None:
    plain = load(swing(), "plain", folder=folder)
    found = plain.simulate(3.0, INSTANTS, rtol=1e-10)
    assert (found.samples.q == told.samples.q).all()
    assert found.stats["steps"] == told.stats["steps"]
    assert (found.power("motor") == told.power("motor")).all()
    assert plain.effects.names == ("gravity", "damper", "motor", "spring", "wall")
    assert not plain.description.work_rows
    assert "work(" not in plain.path.read_text()


def test_paths_are_those_of_the_points(told: Result) -> None:
    assert_allclose(told.point("tip"), tip(told.q("bob.phi")), atol=1e-12)
    assert_allclose(told.point("middle")[:, 0], told.q("bob.x"), atol=1e-12)
    assert told.data["point"].shape == (61, 2, 2)
    assert told.data["point"].attrs["units"] == "m"
    assert told.data["work"].sel(worker="damper")[-1] == told.work("damper")[-1]
    assert told.series("tip.x")[1] == "m"
    assert told.series("work(motor)")[1] == "J"
    assert "tip" not in told.data["joint"]
    assert {"tip.x [m]", "work(spring) [J]", "power(motor) [W]"} <= {*table(told)}


def test_driven_scenes_have_paths(folder: Path) -> None:
    model = swing()
    moved = load(model, "moved", folder=folder).kinematics(INSTANTS)
    assert_allclose(moved.point("tip"), tip(0.2 * INSTANTS), atol=1e-9)
    machine = load(model, "led", folder=folder)
    led = machine.simulate(3.0, INSTANTS, rtol=1e-10)
    height = np.sin(0.2 * INSTANTS)
    assert_allclose(led.work("hand"), 2.0 * 9.81 * height, atol=1e-8)
    inverse = machine.inverse_dynamics(INSTANTS)
    assert_allclose(inverse.point("tip"), tip(0.2 * INSTANTS), atol=1e-9)
    with pytest.raises(InputError, match="integrated along the steps of a simulation"):
        inverse.work("hand")


def test_what_was_not_asked_for_is_offered(folder: Path) -> None:
    found = load(swing(), "plain", folder=folder).simulate(0.1)
    with pytest.raises(
        InputError, match=r"not compute work\(motor\).*'default', 'work\(motor\)'\]"
    ):
        found.work("motor")
    assert_allclose(found.point("tip"), tip(found["bob.phi"]), atol=1e-12)
    with pytest.raises(InputError, match="no tracked point 'tipp'"):
        found.point("tipp")
    with pytest.raises(InputError, match="no work of 'moter'"):
        found.work("moter")


def test_run_that_stops_has_the_works_so_far(machine: Machine) -> None:
    cut = machine.simulate(3.0, INSTANTS, rtol=1e-10, max_steps=10)
    assert cut.failed
    gained = cut.energy("kinetic") - cut.energy("kinetic")[0]
    known = np.isfinite(cut.work("gravity"))
    assert known[:-1].all()
    assert_allclose(sum(cut.work(n) for n in cut.works)[known], gained[known], atol=1e-7)


def test_points_are_no_joints_and_no_effects(told: Result) -> None:
    with pytest.raises(InputError, match=r"no reaction of 'tip'; ask for point\('tip', 'x'\)"):
        told.reaction("tip", "x")
    assert (told.point("tip", "x") == told.point("tip")[:, 0]).all()
    omega, place = told.v("bob.omega"), told.point("tip")
    assert_allclose(told.point("tip", "vy"), omega * place[:, 0], atol=1e-9)
    speed = told.data["point_velocity"].sel(place="tip", axis="x")
    assert_allclose(speed, -omega * place[:, 1], atol=1e-9)
    with pytest.raises(InputError, match="'tip' has no point 'z'"):
        told.point("tip", "z")
    assert "points       tip, middle (m)" in repr(told)
    (axes,) = told.plot("tip").axes
    assert axes.get_xlabel() == "x (m)"
    assert axes.get_aspect() == 1.0
    assert len(told.plot("tip", "bob.phi", "middle").axes) == 2
    model = swing()
    model.spring("tip", model.ground, model.bodies["bob"], 1.0, free_length=1.0)
    assert "the name is already that of a tracked point" in model.problems[-1]
