"""Forces in pictures of results: they balance each body, rounding has no arrow."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.drawing.annotations import loads
from runtime import load
from runtime.show.pictures import exerted, moving_picture
from tests.runtime.show.page_data import header_of

GRAVITY = 9.81


def texts(figure: Any) -> set[str]:
    return {text.get_text() for text in figure.axes[0].texts}


def on_a_lever(add: Callable[[Model, Any, Any], Any], driven: bool, folder: Path) -> Any:
    """A lever on a pin at its end, on which one more element acts, at an instant of a run."""
    model = Model("lever", gravity=(0, -GRAVITY))
    lever = model.body("lever", mass=2.0, inertia=0.5)
    hinge = model.revolute("hinge", model.ground.at(0, 0), lever.at(-1, 0))
    add(model, lever, hinge)
    start = {lever.phi: 0.3, lever.omega: 0.5}
    if driven:
        guess = {lever.phi: 0.3, lever.x: 0.95, lever.y: 0.3}
        model.scene("run", ["gravity"], ["e"], guess=guess)
        return load(model, generated=folder).inverse_dynamics(0.1, progress=False).at(0.05)
    model.scene("run", ["gravity", "e"], start=start)
    return load(model, generated=folder).simulate(0.1, progress=False).at(0.05)


Add = Callable[[Model, Any, Any], Any]
EFFECTS: dict[str, Add] = {
    "spring": lambda m, b, _: m.spring(
        "e", m.ground.at(-0.5, 1.5), b.at(0.5, 0), stiffness=300.0, free_length=1.0
    ),
    "line force": lambda m, b, _: m.line_force("e", m.ground.at(-0.5, 1.5), b.at(0.5, 0), 300.0),
    "motor": lambda m, b, _: m.motor("e", on=b, stall_torque=30.0, no_load_speed=10.0),
    "torsion spring": lambda m, b, _: m.torsion_spring("e", b, m.ground, stiffness=30.0),
    "bushing": lambda m, b, _: m.bushing(
        "e", m.ground.at(0, 0), b.at(0.5, 0.2), stiffness=(90.0, 60.0, 5.0)
    ),
    "stop": lambda m, _, hinge: m.stop("e", hinge, upper=0.1, stiffness=300.0),
    "two stops": lambda m, _, hinge: m.stop("e", hinge, lower=0.4, upper=0.9, stiffness=300.0),
    "friction": lambda m, _, hinge: m.friction("e", hinge, 0.3, radius=0.1),
    "dry friction": lambda m, b, _: m.dry_friction(
        "e", m.ground, b.at(1, 0.1), coefficient=0.5, normal=10.0, axis=(1, 1)
    ),
    "turning friction": lambda m, b, _: m.dry_friction(
        "e", slip=0.4 * b.omega, coefficient=0.5, normal=10.0
    ),
    "clearance joint": lambda m, b, _: m.clearance_joint(
        "e", m.ground.at(1.4, 0.55), b.at(0.5, 0), radius=0.1, clearance=0.01, stiffness=1e3
    ),
}
DRIVERS: dict[str, Add] = {
    "distance driver": lambda m, b, _: m.distance_driver(
        "e", m.ground.at(-0.5, 1.5), b.at(0.5, 0), 2.0 + 0.1 * t
    ),
    "relative driver": lambda m, b, _: m.relative_driver(
        "e", m.ground.at(0, 0), b.at(1, 0), "y", 0.6 + 0.1 * t
    ),
    "point driver": lambda m, b, _: m.point_driver("e", b.at(1, 0), "x", 1.9 - 0.1 * t),
}


@pytest.mark.parametrize("name", [*EFFECTS, *DRIVERS])
def test_all_forces_on_a_body_are_its_mass_times_its_acceleration(
    name: str, tmp_path: Path
) -> None:
    """Sizes, directions and places of all arrows, also of forces that are no outputs."""
    one = on_a_lever((EFFECTS | DRIVERS)[name], name in DRIVERS, tmp_path)
    found = loads(moving_picture(one), exerted(one, everything=True))
    acting = [row for row in found if row.label.endswith(" on lever") and row.size > 0]
    assert any(row.element == "e" and row.size > 0.1 for row in acting)
    center = one.q("lever.x")[0] + 1j * one.q("lever.y")[0]
    force, torque = -1j * 2.0 * GRAVITY, 0.0
    for row in acting:
        if row.style == "torque":
            torque += float(np.ravel(row.value)[0])
        else:
            value, at = np.ravel(row.value)[0], np.ravel(row.at)[0]
            force += value
            torque += ((at - center).conjugate() * value).imag
    moved = 2.0 * (one.a("lever.x")[0] + 1j * one.a("lever.y")[0])
    assert_allclose([force, torque], [moved, 0.5 * one.a("lever.phi")[0]], atol=1e-8)


@pytest.mark.parametrize(
    ("name", "words"),
    [("motor", "e on lever: 27"), ("stop", "e on lever: 5"), ("spring", "e on lever: 2")],
)
def test_a_still_has_forces_that_are_no_outputs(name: str, words: str, tmp_path: Path) -> None:
    drawn = texts(on_a_lever(EFFECTS[name], False, tmp_path).draw(forces=True))
    assert any(text.startswith(words) for text in drawn)


def test_a_motor_and_a_clutch_act_on_what_they_drive(tmp_path: Path) -> None:
    model = Model("drives")
    frame, rotor = (model.body(name, mass=2.0, inertia=0.5) for name in ("frame", "rotor"))
    model.revolute("F", model.ground.at(0, 0), frame.at(-1, 0))
    model.revolute("R", frame.at(1, 0), rotor.at(0, 0))
    model.motor("motor", on=rotor, from_=frame, stall_torque=30.0, no_load_speed=10.0)
    outer = model.body("outer", mass=1.0, inertia=0.5)
    model.revolute("O", model.ground.at(0, 3), outer)
    model.one_way_clutch("clutch", driver=frame, driven=outer)
    start = {body.phi: 0.0 for body in (frame, rotor, outer)}
    start |= {frame.omega: 0.0, rotor.omega: 0.0, outer.omega: 0.0}
    model.scene("run", ["motor", "clutch"], start=start, outputs=["default", "torques"])
    run = load(model, generated=tmp_path).simulate(0.1, progress=False)
    found = {row.label: row.value for row in loads(moving_picture(run), exerted(run))}
    assert found["motor on rotor"][0] == 30.0
    assert run.a("rotor.phi")[0] > 0
    assert "clutch on outer" in found


def test_rounding_has_no_arrow(tmp_path: Path) -> None:
    """What is left of a torque in its last instant is nothing beside the torque of the run."""
    model = Model("fading")
    wheel = model.body("wheel", mass=1.0, inertia=0.5)
    model.revolute("pin", model.ground.at(0, 0), wheel)
    model.torque("push", on=wheel, value=30.0 * (1 - t) + 1e-12)
    model.scene("run", ["push"], start={wheel.phi: 0.0, wheel.omega: 0.0})
    run = load(model, generated=tmp_path).simulate(1.0, progress=False)
    assert "push on wheel: 30 N m" in texts(run.draw(0.0, forces=True))
    assert not any("N m" in text for text in texts(run.draw(1.0, forces=True)))


def test_a_torque_that_is_rounding_beside_the_forces_has_no_arrow(tmp_path: Path) -> None:
    model = Model("squeezed")
    jaw = model.body("jaw", mass=1.0, inertia=0.5)
    model.weld("vice", model.ground.at(0, 0), jaw)
    model.force("squeeze", on=jaw, fy=6400.0)
    model.torque("rest", on=jaw, value=2e-12)
    model.scene("run", ["squeeze", "rest"])
    run = load(model, generated=tmp_path).inverse_dynamics(0.1, progress=False)
    assert not any("N m" in text for text in texts(run.draw(forces=True)))
    shown = {row["label"] for row in header_of(run.animate().html)["runs"][0]["arrows"]}
    assert shown == {"squeeze on jaw", "vice, ground on jaw"}
