"""Forces on the ground, reactions in global axes and mechanical advantage, each in two ways."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import cos, sin

from codegen import Model, t
from codegen.errors import InputError, ModelError
from runtime import Result, load
from tests.codegen.elements.turned_body import turned_body

G = 9.81
TIMES = np.linspace(0.0, 1.5, 301)


def by_momentum(
    run: Result, masses: dict[str, tuple[float, float]], fx: Any = 0.0, fy: Any = 0.0,
    moment: Any = 0.0,
) -> list[np.ndarray]:  # fmt: skip
    """What loads from outside, also in moment about the origin, leave of the change of momentum."""
    for name, (mass, inertia) in masses.items():
        px, py = mass * run.a(f"{name}.x"), mass * (run.a(f"{name}.y") + G)
        fx, fy = fx - px, fy - py
        moment = moment - (run.q(f"{name}.x") * py - run.q(f"{name}.y") * px)
        moment = moment - inertia * run.a(f"{name}.phi")
    return [fx, fy, moment]


def assert_shakes(run: Result, expected: list[np.ndarray], within: float = 1e-12) -> None:
    for part, values in zip(("fx", "fy", "torque"), expected, strict=True):
        size = max(1.0, float(np.abs(values).max()))
        assert_allclose(run.reaction("ground", part), values, atol=within * size)


def test_an_eccentric_disc_shakes_its_bearing(tmp_path: Path) -> None:
    mass, arm, speed = 3.0, 0.02, 40.0
    model = Model("eccentric")
    disc = model.body("disc", mass, 0.01)
    model.revolute("bearing", model.ground.at(0.5, 0.25), disc.at(-arm, 0))
    model.driver("turn", disc.phi, speed * t)
    model.scene("run", drivers=["turn"], outputs=["shaking", "global_reactions"])
    run = load(model, "run", folder=tmp_path).inverse_dynamics(TIMES)
    force = mass * arm * speed**2
    c, s = force * np.cos(speed * run.t), force * np.sin(speed * run.t)
    assert_allclose(run["ground.fx"], c, atol=1e-11 * force)
    assert_allclose(run["ground.fy"], s, atol=1e-11 * force)
    assert_allclose(run["ground.torque"], 0.5 * s - 0.25 * c, atol=1e-11 * force)
    assert_allclose(run["bearing.global_fx"], -c, atol=1e-11 * force)
    assert run.series("ground.torque")[1] == "N m"


def test_joint_axes_turn_into_global_ones(tmp_path: Path) -> None:
    """A block on a driven slope: what the guide exerts on it, by Newton's law."""
    slope, mass = 0.3, 2.0
    model = Model("slope", gravity=(0, -G))
    block = model.body("block", mass, 0.1)
    axis = cos(slope), sin(slope)
    model.translational("guide", model.ground.at(0, 0), block.at(0, 0), axis)
    link = model.body("link", 1.0, 0.1)
    model.revolute("pin", block.at(0.1, 0.2), link.at(0, 0.5))
    model.force("push", on=block, fx=3.0 * t)
    model.scene("run", ["gravity", "push"], start={block.x: 0.0, block.vx: 0.0, link.phi: 0.4,
                "link.omega": 1.0}, outputs=["default", "global_reactions"])  # fmt: skip
    run = load(model, "run", folder=tmp_path).simulate(1.5, TIMES, rtol=1e-10)
    pin = run.a("link.x"), run.a("link.y") + G  # 1 kg
    assert_allclose(run["pin.global_fx"], pin[0], atol=1e-11)
    assert_allclose(run["pin.global_fy"], pin[1], atol=1e-11)
    guide = mass * run.a("block.x") + pin[0] - 3.0 * run.t, mass * (run.a("block.y") + G) + pin[1]
    assert_allclose(run["guide.global_fx"], guide[0], atol=1e-10)
    assert_allclose(run["guide.global_fy"], guide[1], atol=1e-10)
    fx, fy = run.reaction("guide", "fx"), run.reaction("guide", "fy")
    assert_allclose(np.hypot(fx, fy), np.hypot(*guide), atol=1e-10)
    assert np.abs(fx - guide[0]).max() > 1.0  # the axes do differ


def test_all_that_stands_on_the_ground_shakes_it(tmp_path: Path) -> None:
    """Sticking friction, a contact, a motor, springs, and a joint that is released."""
    model = Model("standing", gravity=(0, -G))
    a, b = model.body("a", 2.0, 0.1), model.body("b", 1.0, 0.05)
    hinge = model.revolute("H", model.ground.at(0.1, 0.2), a.at(-0.5, 0))
    model.revolute("K", a.at(0.5, 0), b.at(-0.3, 0))
    model.friction("rub", hinge, 0.4, radius=0.05, static=0.5)
    model.spring("tie", model.ground.at(1, 1), b.at(0.3, 0), 50.0, free_length=0.5)
    model.spring("inner", a.at(0.2, 0.1), b.at(0.1, 0), 10.0, free_length=0.1, damping=2.0)
    model.contact("stop", gap=a.phi + 1.0, stiffness=1e4, damping=5.0)
    model.torque("drive", on=a, value=-0.2 * a.omega, from_=model.ground)
    model.torque("wind", on=b, value=0.3)
    model.release("K", when=t > 0.7)
    every = ["gravity", "rub", "tie", "inner", "stop", "drive", "wind"]
    start = {a.phi: 0.0, a.omega: 0.0, b.phi: 0.2, b.omega: 0.0}
    both = model.series("H.global_fx") + model.series("K.global_fx")
    model.scene("run", every, start=start, outputs=["default", "shaking", {"both": both}])
    run = load(model, "run", folder=tmp_path).simulate(1.5, TIMES, rtol=1e-9)
    assert run.reconnections
    assert len(run.events) > 3
    assert_shakes(run, by_momentum(run, {"a": (2.0, 0.1), "b": (1.0, 0.05)}, moment=0.3))
    freed = run.t > 0.71
    assert (run["K.global_fx"][freed] == 0.0).all()
    assert_allclose(run["both"], run["H.global_fx"] + run["K.global_fx"], atol=1e-11)
    assert np.abs(run["both"][freed]).max() > 1.0
    plain = model.scene("run").with_(outputs="default")
    again = load(model, plain, folder=tmp_path).simulate(1.5, TIMES, rtol=1e-9)
    for ask in (lambda: again["ground.fx"], lambda: again.reaction("ground", "torque")):
        with pytest.raises(
            InputError, match=r"declare the scene with outputs=\['default', 'shaking"
        ):
            ask()
    with pytest.raises(InputError, match="'ground' has no reaction 'fz'; ask for reaction"):
        run.reaction("ground", "fz")
    assert (again.reaction("K", "global_fx") == run["K.global_fx"]).all()


def test_rigid_contacts_and_sticking_bodies_press_the_ground(tmp_path: Path) -> None:
    model = Model("resting", gravity=(0, -G))
    ball = model.body("ball", 2.0, 0.1)
    model.contact("floor", gap=ball.y, typical_force=20.0, restitution=0.3)
    model.force("push", on=ball, fx=3.0 * t)
    model.scene("run", ["gravity", "floor", "push"], start={ball.y: 0.5, ball.vy: 0.0},
                outputs=["shaking", {"pressed": model.series("floor.force"),
                "lifted": model.series("a(ball.y)")}])  # fmt: skip
    run = load(model, "run", folder=tmp_path).simulate(2.5, np.linspace(0.0, 2.5, 251))
    assert {*run.mode("floor").tolist()} == {1, 2}
    moment = -run.q("ball.y") * 3.0 * run.t
    assert_shakes(run, by_momentum(run, {"ball": (2.0, 0.1)}, 3.0 * run.t, moment=moment), 1e-12)
    assert_allclose(run["pressed"], -run["ground.fy"], atol=1e-12)
    assert_allclose(run["pressed"][-1], 2.0 * G, rtol=1e-12)
    assert_allclose(run["lifted"], run.a("ball.y"), atol=1e-15)


def slider_crank(counterweight: float) -> Model:
    """Crank 0.1 m, massless rod of 0.4 m, slider 1 kg; `counterweight`, kg m, opposite the pin."""
    model = Model("balanced")
    crank = model.body("crank", 2.0, 0.01)
    slider = model.body("slider", 1.0, 0.01)
    centre = counterweight / 2.0
    model.revolute("bearing", model.ground.at(0, 0), crank.at(centre, 0))
    model.translational("guide", model.ground.at(0, 0), slider.at(0, 0), (1, 0))
    model.distance("rod", crank.at(0.1 + centre, 0), slider.at(0, 0), 0.4)
    model.driver("turn", crank.phi, 50.0 * t)
    model.scene("run", drivers=["turn"], guess={slider.x: 0.5, crank.x: -centre},
                outputs=["shaking", "default"])  # fmt: skip
    return model


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_counterweights_balance_a_slider_crank(share: float, tmp_path: Path) -> None:
    """F = -m ẍ of the slider, and centrifugal force of the counterweight against it."""
    run = load(slider_crank(0.1 * share), "run", folder=tmp_path).inverse_dynamics(TIMES)
    phi, r, length, w = 50.0 * run.t, 0.1, 0.4, 50.0
    s, c = np.sin(phi), np.cos(phi)
    root = np.sqrt(length**2 - (r * s) ** 2)
    ax = -r * w**2 * c - r**2 * w**2 * (c**2 - s**2) / root - (r**2 * w * s * c) ** 2 / root**3
    assert_allclose(run["ground.fx"], -ax - 0.1 * share * w**2 * c, atol=1e-9)
    assert_allclose(run["ground.fy"], -0.1 * share * w**2 * s, atol=1e-9)


def toggle(force: float = 40.0) -> Model:
    """Two links of 0.3 m between a pin and a ram, bent at the knee, on which a force presses."""
    model = Model("toggle")
    first, second = model.body("first", 1.0, 0.01), model.body("second", 1.0, 0.01)
    ram = model.body("ram", 1.0, 0.01)
    model.revolute("pin", model.ground.at(0, 0), first.at(-0.15, 0))
    model.revolute("knee", first.at(0.15, 0), second.at(-0.15, 0))
    model.revolute("wrist", second.at(0.15, 0), ram.at(0, 0))
    model.translational("guide", model.ground.at(0, 0), ram.at(0, 0), (1, 0))
    model.spring("work", ram, model.ground.at(0.8, 0), 2e4, free_length=0.23)
    model.force("push", first.at(0.15, 0), fy=-force)
    model.driver("bend", first.phi, 0.6 - 0.1 * t)
    guess = {first.x: 0.12, first.y: 0.08, first.phi: 0.5, second.x: 0.4, second.y: 0.08,
             second.phi: -0.5, ram.x: 0.5}  # fmt: skip
    knee = first.at(0.15, 0)
    model.scene("moved", drivers=["bend"], analysis="kinematics", guess=guess,
                outputs={"advantage": -knee.vy / ram.vx})  # fmt: skip
    model.scene("pressed", ["work", "push"], analysis="equilibrium", guess=guess,
                outputs={"advantage": -model.series("work.force") / force})  # fmt: skip
    return model


def test_mechanical_advantage_of_a_toggle(tmp_path: Path) -> None:
    """1/(2 tan φ), by the speeds of knee and ram, and by the forces that balance (virtual work)."""
    model = toggle()
    moved = load(model, "moved", folder=tmp_path).kinematics(np.linspace(0.0, 5.0, 51))
    assert_allclose(moved["advantage"], 0.5 / np.tan(moved.q("first.phi")), rtol=1e-11)
    assert moved.series("advantage")[1] == "1"
    rest = load(model, "pressed", folder=tmp_path).equilibrium()
    advantage, phi = float(rest.series("advantage")[0][0]), float(rest.q("first.phi")[0])
    assert 0.05 < phi < 0.5
    assert_allclose(advantage, 0.5 / np.tan(phi), rtol=1e-8)


def test_the_ground_needs_bodies_with_angles(tmp_path: Path) -> None:
    model = Model("turned", gravity=(0, -G))
    body = turned_body(model, "bob", 2.0, 0.3, (0.07, -0.03))
    model.revolute("hinge", model.ground.at(0, 0), body.at(-0.5, 0))
    model.scene("run", ["gravity"], outputs=["shaking"])
    with pytest.raises(ModelError, match="the force on the ground needs x, y and phi, but body"):
        load(model, "run", folder=tmp_path)


def test_a_driver_of_an_angle_has_no_force_in_a_plane(tmp_path: Path) -> None:
    model = toggle()
    scene = model.scene("pressed").with_("bend", analysis="dynamics", outputs=["global_reactions"])
    run = load(model, scene, folder=tmp_path).inverse_dynamics([0.0])
    assert run.description.series.get("wrist.global_fx") is not None
    scene = scene.with_(outputs=["global_reaction(bend)", "global_reaction(push)"])
    with pytest.raises(ModelError, match="'bend' has no force in a plane") as refused:
        load(model, scene, folder=tmp_path)
    assert "force 'push' is no joint" in str(refused.value)
