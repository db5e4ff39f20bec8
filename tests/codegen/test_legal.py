"""Unusual and legal: these machines build, and give the same answers as their plain sisters."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, build, t
from tests.codegen.machines import frozen
from tests.codegen.workbench import Interpreted

Scenes = dict[str, Interpreted]


def test_free_body_falls(scenes: Scenes) -> None:
    machine = scenes["free_body.default"]
    assert (machine.n, machine.m, machine.s) == (3, 0, 1)
    s = machine.state(0)
    s.v[0] = 2.0
    a, lam = machine.solution(s, modes=[1])
    assert_allclose(a, [-0.1 * 4 / 2, -9.81, 0], rtol=1e-15)
    assert lam.size == 0
    assert machine.vector("constraints", s).size == 0


def test_model_without_scenes_lets_everything_act(scenes: Scenes) -> None:
    told = scenes["free_body.default"].lowered.description
    assert told.scene == "default"
    assert told.effects == (("gravity", "gravity"), ("drag", "force"))
    assert told.left_out == ()


def test_names_of_arguments_are_free_to_use(scenes: Scenes, texts: dict[str, str]) -> None:
    text = texts["names.default"]
    assert "q_ = p[0]" in text
    machine = scenes["names.default"]
    plain = Model("plain")
    numbers = [plain.parameter(f"n{k}", 1.0 + k / 10) for k in range(12)]
    i = plain.body("one", mass=plain.parameter("mass", 2.0), inertia=numbers[0])
    j = plain.body("two", mass=numbers[1] * numbers[2], inertia=1.5)
    p = plain.body("three", mass=1.0, inertia=numbers[3] + 1)
    plain.revolute("A", plain.ground.at(0, 0), j.at(numbers[4], 0))
    plain.revolute("B", i.at(0, numbers[5] / numbers[6]), j.at(-1, numbers[7]))
    plain.translational("C", i, p.at(0.1, 0.2), axis=(numbers[8], 1), angle=numbers[9])
    from sympy import sin

    plain.torque("D", on=p, value=numbers[10] * sin(p.phi) * numbers[11])
    plain.force("E", on=i, fx=1.0, when=i.vx > 0)
    other = Interpreted(plain)
    s = machine.state(4)
    one, two = machine.solution(s), other.solution(s)
    assert_allclose(np.concatenate(one), np.concatenate(two), rtol=1e-12, atol=1e-12)


def test_frozen_scene_has_the_numbers_of_the_open_one(scenes: Scenes) -> None:
    shut, same, opened = (scenes[f"folded.{name}"] for name in ("shut", "same", "open"))
    s = shut.state(1)
    for kernel in ("constraints", "jacobian", "acceleration_rhs", "mass", "applied_forces"):
        assert_allclose(shut.vector(kernel, s), same.vector(kernel, s), rtol=1e-14)
    assert_allclose(shut.solution(s)[0], same.solution(s)[0], rtol=1e-12)
    assert_allclose(same.vector("mass", s), opened.vector("mass", s) * 4 / 3, rtol=1e-14)
    operations = {m: dict_of(scenes[f"folded.{m}"]) for m in ("shut", "same")}
    assert operations["shut"]["constants"] == 0 < operations["same"]["constants"]


def dict_of(machine: Interpreted) -> dict[str, int]:
    from codegen.lower.operation_count import operations

    return {k.name: operations(machine.program, k) for k in machine.program.kernels}


def test_parameters_in_points_move_them() -> None:
    machine = Interpreted(frozen(), "open")
    s = machine.state(2)
    short = machine.vector("constraints", s, p=[0.5, 3.0])
    long = machine.vector("constraints", s, p=[2.5, 3.0])
    assert_allclose(long - short, 2.0 * np.array([np.cos(s.q[2]), np.sin(s.q[2])]), rtol=1e-13)


def test_massless_scene_moves_by_its_drivers(scenes: Scenes) -> None:
    machine = scenes["massless.move"]
    names = {kernel.name for kernel in machine.program.kernels}
    assert not names & {
        "mass",
        "applied_forces",
        "potential",
        "kinetic_energy",
        "powers",
        "reactions",
    }
    s = machine.state(0)
    a = machine.flat("accelerations", s)["a"]
    assert_allclose(a, [-np.sin(s.t), np.sin(s.t), 0], rtol=1e-14)


def test_bodies_called_as_the_frames_of_the_joints(scenes: Scenes) -> None:
    model = Model("swapped")
    j, i = model.body("j", 1.0, 1.0), model.body("i", 1.0, 1.0)
    model.revolute("A", j.at(0.3, 0.1), i.at(-0.2, 0.4))
    other = Model("plain")
    a, b = other.body("a", 1.0, 1.0), other.body("b", 1.0, 1.0)
    other.revolute("A", a.at(0.3, 0.1), b.at(-0.2, 0.4))
    one, two = Interpreted(model), Interpreted(other)
    s = one.state(0)
    assert_allclose(one.jacobian(s), two.jacobian(s), atol=0)
    assert_allclose(one.vector("acceleration_rhs", s), two.vector("acceleration_rhs", s), atol=0)


def test_own_element_stands_on_equal_terms() -> None:
    from codegen.declare.element import ConjugateReaction, Statement

    class Gear:
        kind = "gear"

        def __init__(self, name: str, i: object, j: object, ratio: object) -> None:
            self.name, self.bodies = name, (i, j)
            self.phi = i.phi + ratio * j.phi

        def statement(self) -> Statement:
            return Statement((self.phi,), ("mesh",), ConjugateReaction((("torque", "N m"),)))

        def problems(self) -> list[str]:
            return []

    model = Model("gears")
    a, b = model.body("a", 1.0, 1.0), model.body("b", 1.0, 4.0)
    model.add(Gear("mesh", a, b, model.parameter("ratio", 2.0)))
    model.torque("motor", on=a, value=3.0)
    machine = Interpreted(model)
    s = machine.state(0)
    found, lam = machine.solution(s)
    assert_allclose(found[[2, 5]], [3.0 / 2, -3.0 / 4], rtol=1e-14)
    assert_allclose(machine.vector("reactions", s, lam=lam), -lam, atol=0)


@pytest.mark.parametrize(
    "name", ["factorization", "correction", "masses", "constants", "mass", "a"]
)
def test_elements_may_be_called_as_the_parts_of_a_module(name: str) -> None:
    model = Model("names", gravity=(0, -9.81))
    body = model.body("body", 1.0, 1.0)
    model.revolute(name, model.ground.at(0, 0), body.at(1, 0))
    text = Interpreted(model).text()
    compile(text, "module", "exec")
    assert f'("{name}", "revolute", "x")' in text


def test_quantities_are_converted_where_they_are_declared(tmp_path: Path) -> None:
    import pint

    u = pint.get_application_registry()
    model = Model("units")
    length = model.parameter("length", 25 * u.cm, unit="m")
    speed = model.parameter("speed", 60 * u.rpm, unit="rad/s")
    body = model.body("body", mass=500 * u.g, inertia=2e4 * u.g * u.cm**2)
    model.revolute("A", model.ground.at(10 * u.mm, 0), body.at(length, 0))
    model.driver("drive", body.phi, 90 * u.degree + speed * t)
    model.force("push", on=body, fx=2 * u.kN)
    model.scene("s", ["push"], ["drive"], start={body.phi: 90 * u.degree})
    machine = Interpreted(model, "s")
    s = machine.state(0)
    assert_allclose(machine.p, [0.25, 2 * np.pi], rtol=1e-15)
    assert_allclose(machine.vector("mass", s), [0.5, 0.5, 2e-3], rtol=1e-15)
    assert_allclose(machine.vector("applied_forces", s), [2000, 0, 0], atol=0)
    x = 0.01 - s.q[0] - 0.25 * np.cos(s.q[2])
    assert_allclose(machine.vector("constraints", s)[0], x, rtol=1e-13)
    assert machine.lowered.description.start == (("body.phi", np.pi / 2, "fixed"),)


@pytest.mark.parametrize("seed", range(20))
def test_sound_machines_are_not_refused(seed: int) -> None:
    from codegen.check.kinematics import examine
    from tests.codegen.workbench import random_machine

    model = random_machine(seed, closed=seed % 2 == 0)[0]
    machine = Interpreted(model)
    assert examine(model, machine.equations, machine.lowered).problems == ()


def test_the_ground_has_coordinates_that_are_zero(tmp_path: Path) -> None:
    """A joint angle is φ_j - φ_i, whichever of the two is the ground."""
    texts = []
    for name in ("ground", "none"):
        model = Model("grounded")
        arm, base = model.body("arm", mass=1.0, inertia=1.0), model.ground
        model.revolute("pin", base.at(0, 0), arm.at(0, 0))
        angle, rate = arm.phi, arm.omega
        if name == "ground":
            angle, rate = angle - base.phi + base.x, rate - base.omega + base.vy
        model.torque("servo", on=arm, from_=base, value=-5 * angle - rate)
        model.scene("runs", ["servo"])
        (written,) = build(model, out=tmp_path / name, compile=False).scenes
        texts.append([line for line in written.path.read_text().splitlines() if "SHA" not in line])
    assert texts[0] == texts[1]
