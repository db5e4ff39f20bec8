"""Torques and forces that do what drivers would, in space and in the plane: the same numbers."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sympy import cos, sin

from codegen import Model, SceneError, t
from codegen.declare.element import Effect
from runtime import load
from runtime.results.result import Result

REACH, HEIGHT = 0.6 + 0.05 * cos(2 * t), 0.05 * sin(2 * t)
INERTIA = 0.02


def in_plane(folder: Path) -> Result:
    model = Model("arm_in_plane", gravity=(0, -9.81))
    upper, fore = model.body("upper", 1.0, INERTIA), model.body("fore", 0.5, INERTIA)
    model.revolute("A", model.ground, upper.at(-0.2, 0))
    model.revolute("B", upper.at(0.2, 0), fore.at(-0.2, 0))
    model.torque("shoulder", upper, 1.0)
    model.torque("elbow", fore, 1.0, from_=upper)
    model.point_driver("x", fore.at(0.2, 0), "x", REACH)
    model.point_driver("y", fore.at(0.2, 0), "y", HEIGHT)
    guess = {"upper.phi": -0.7, "fore.phi": 0.7, "upper.x": 0.15, "upper.y": -0.13, "fore.x": 0.45}
    model.scene("go", ["gravity", "shoulder", "elbow"], ["x", "y"], guess=guess)
    return load(model, folder=folder).inverse_dynamics(
        1.0, 11, unknown=["shoulder", "elbow"], progress=False
    )


def arm_in_space() -> Model:
    """The same in the plane of x and z: angles are counted about -y."""
    model = Model("arm_in_space", space=True, gravity=(0, 0, -9.81))
    inertia = (0.01, INERTIA, 0.015)
    upper = model.body("upper", 1.0, inertia, at=(0.2, 0, 0))
    fore = model.body("fore", 0.5, inertia, at=(0.6, 0, 0))
    base = model.revolute("A", model.ground, upper, at=(0, 0, 0), axis=(0, -1, 0))
    elbow = model.revolute("B", upper, fore, at=(0.4, 0, 0), axis=(0, -1, 0))
    model.torque("shoulder", upper, (0, 1, 0), frame="body")
    model.torsion_spring("elbow", elbow, actuator=1.0)
    model.force("lift", fore.at(0.2, 0, 0), (0, 0, 1.0))
    model.force("askew", fore.at(0.2, 0, 0), (1.0, 0, 1.0))
    model.point_driver("x", fore.at(0.2, 0, 0), "x", REACH)
    model.point_driver("z", fore.at(0.2, 0, 0), "z", HEIGHT)
    bent = {"upper.e0": np.cos(0.35), "upper.e2": np.sin(0.35)}
    bent |= {"fore.e0": np.cos(0.35), "fore.e2": -np.sin(0.35)}
    for name, effects in (("go", ["shoulder", "elbow"]), ("lifted", ["lift", "elbow", "askew"])):
        outputs = ["default", base.angle]
        model.scene(name, ["gravity", *effects], ["x", "z"], guess=bent, outputs=outputs)
    return model


def test_torques_of_an_arm_are_those_of_the_plane(tmp_path: Path) -> None:
    plane, machine = in_plane(tmp_path), load(arm_in_space(), "go", folder=tmp_path)
    run = machine.inverse_dynamics(1.0, 11, unknown=["shoulder", "elbow"], progress=False)
    for name in ("x", "z"):
        assert np.abs(run.reaction(name, f"f{name}")).max() < 1e-10
    largest = np.abs(plane.torque("shoulder")).max()
    assert largest > 1.0
    off = run.torque("shoulder", "ty") + plane.torque("shoulder")
    assert np.abs(off).max() < 1e-9 * largest
    assert not run.torque("shoulder", "tx").any()
    # n acts on the joint's first body
    off = run.torque("elbow") + plane.torque("elbow")
    assert np.abs(off).max() < 1e-9 * largest
    assert np.abs(run["A.angle"] - plane.q("upper.phi")).max() < 1e-10


def test_a_force_of_one_component_is_sought_and_others_are_refused(tmp_path: Path) -> None:
    machine = load(arm_in_space(), "lifted", folder=tmp_path)
    run = machine.inverse_dynamics(1.0, 11, unknown=["lift", "elbow"], progress=False)
    given = machine.inverse_dynamics(1.0, 11, progress=False)
    x, z = 0.6 + 0.05 * np.cos(2 * run.t), 0.05 * np.sin(2 * run.t)
    # Of the same moment about the shoulder: that of the elbow's torque is 0. 1 N is given.
    expected = 1.0 + given.reaction("z", "fz") - z / x * given.reaction("x", "fx")
    assert np.abs(expected).max() > 1.0
    assert np.abs(run.force("lift", "fz") - expected).max() < 1e-9
    assert np.abs(run.reaction("x", "fx")).max() < 1e-10
    with pytest.raises(SceneError, match="'askew' is no torque, line force, motor"):
        machine.inverse_dynamics(1.0, 11, unknown=["askew", "elbow"], progress=False)


def test_a_spring_without_an_actuator_is_not_sought() -> None:
    model = arm_in_space()
    spring: Any = model.torsion_spring("spring", model.joints["B"], stiffness=2.0)
    assert isinstance(spring, Effect)
    assert spring.exerting(2) is None
