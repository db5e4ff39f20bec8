"""What a machine in space does not have yet is refused by name, and what is wrong in it told."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from codegen import Model, t
from codegen.driver import build
from codegen.errors import AnalysisError, ModelError, ParameterError
from codegen.model.bodies import MovingBodies
from codegen.model.contacts import Contacts
from codegen.model.forces import Forces
from codegen.model.space_model import ELEMENTS, REFUSED, SpaceModel
from models.space.heavy_top import heavy_top
from runtime import load
from tests.space.machines import X, Z


def declared(**words: Any) -> Any:
    model = Model("machine", space=True, gravity=(0, 0, -9.81))
    model.body("a", 1.0, (1.0, 2.0, 2.5), **words)
    return model


def hinge(model: Any) -> Any:
    return model.revolute("A", model.ground, model.bodies["a"], at=(0, 0, 0), axis=Z)


@pytest.mark.parametrize("word", REFUSED)
def test_elements_of_the_plane_are_refused_by_name(word: str) -> None:
    with pytest.raises(ModelError) as refusal:
        getattr(declared(), word)("it")
    said = str(refusal.value)
    assert f"model.{word}: model 'machine' is in space" in said
    assert (f"In space there are {ELEMENTS}." in said) == (not REFUSED[word])
    assert REFUSED[word] in said


def test_what_stands_in_for_a_motor_does(workshop: Path) -> None:
    model = declared()
    A, b = hinge(model), model.body("b", 1.0, (1.0, 1.0, 1.0))
    B = model.revolute("B", model.ground, b, at=(0, 0, 0), axis=Z)
    model.generalized_force("one", {A.angle: 50 - 5 * A.rate})
    model.torsion_spring("two", B, actuator=-(50 - 5 * B.rate))
    model.scene("s", ["one", "two"], outputs=["default", A.rate, B.rate])
    run = load(model, folder=workshop).simulate(0.5, 6, progress=False)
    for name, inertia in (("A", 2.5), ("B", 1.0)):
        assert_allclose(run[f"{name}.rate"], 10 * (1 - np.exp(-5 / inertia * run.t)), rtol=1e-5)


def test_what_stands_in_for_a_belt_and_for_a_cam_does(workshop: Path) -> None:
    model = declared()
    A, b, c = hinge(model), *(model.body(name, 1.0, (1.0, 1.0, 1.0)) for name in "bc")
    B = model.revolute("B", model.ground, b, at=(0, 0, 0), axis=Z)
    C = model.translational("C", model.ground, c, at=(0, 0, 0), axis=Z)
    x, y = [0, 1, 2, 3, 4], [0, 0.1, 0.2, 0.1, 0]
    lift = model.table("lift", x, y, units=("rad", "m"), kind="spline")
    model.gear("belt", A, B, ratio=0.1 / 0.4)
    model.constraint("cam", C.slide - lift(A.angle))
    model.rotation_driver("drive", A, 4 * t)
    model.scene("s", [], ["drive"], outputs=["default", B.angle, C.slide])
    run = load(model, folder=workshop).kinematics(1.0, 11, progress=False)
    assert_allclose(run["B.angle"], run.t, atol=1e-9)
    assert_allclose(run["C.slide"], CubicSpline(x, y)(4 * run.t), atol=1e-9)


def test_a_word_that_space_lacks_is_not_taken_for_another() -> None:
    model = declared()
    with pytest.raises(ModelError) as refusal:
        model.torque("T", model.bodies["a"], (1, 0, 0), from_=model.ground)
    assert "unexpected keyword argument 'from_'" in str(refusal.value)
    assert "did you mean" not in str(refusal.value)


def test_every_word_of_the_plane_is_refused_or_means_something_in_space() -> None:
    rooms = [base for room in (MovingBodies, Contacts, Forces) for base in room.__mro__]
    modules = ("bodies", "constraints", "connections", "contacts", "forces")
    words = {
        word
        for base in rooms
        if base.__module__ in {f"codegen.model.{name}" for name in modules}
        for word, method in vars(base).items()
        if callable(method) and not word.startswith("_")
    }
    known = {*ELEMENTS.replace(" and", ",").split(", "), *REFUSED, "label"}
    assert words - known == set()
    assert all(callable(getattr(SpaceModel, word)) for word in known)


MISTAKES: dict[str, tuple[Callable[[Any], Any], str]] = {
    "flat inertia": (
        lambda m: m.body("b", 1.0, (0.1, 0.3, 0.5)),
        ("inertia of body 'b' has the principal moments 0.1, 0.3, 0.5 kg m^2, of which the largest "
        "exceeds the sum of the others; no distribution of mass has that. Check units and axes."),
    ),
    "negative inertia": (
        lambda m: m.body("b", 1.0, (1.0, 1.0, 1.0, 2.0, 0.0, 0.0)),
        "the principal moments -1, 1, 3 kg m^2; all three must be positive.",
    ),
    "two moments": (
        lambda m: m.body("b", 1.0, (1.0, 1.0)),
        ("inertia of body 'b' is (1.0, 1.0); give three principal moments, six numbers J_xx, J_yy, "
        "J_zz, J_xy, J_xz, J_yz, or a matrix, 3 x 3."),
    ),
    "one moment": (
        lambda m: m.body("b", 1.0, 0.5),
        ("inertia of body 'b' is 0.5; give three principal moments, six numbers J_xx, J_yy, J_zz, "
        "J_xy, J_xz, J_yz, or a matrix, 3 x 3."),
    ),
    "skew matrix": (
        lambda m: m.body("b", 1.0, np.array([[1, 2, 0], [0, 1, 0], [0, 0, 1.0]])),
        "give a symmetric matrix.",
    ),
    "unknown symbol": (
        lambda m: m.body("b", 1.0, (m.bodies["a"].x, 1.0, 1.0)),
        "inertia of body 'b': unknown symbol 'a_x'; an inertia consists of numbers and",
    ),
    "parallel axes": (
        lambda m: m.body("b", 1.0, (1.0, 1.0, 1.0), axes=(X, X)),
        "body 'b': axes is ((1, 0, 0), (1, 0, 0)); give two axes that are not parallel, a",
    ),
    "rotation matrix": (
        lambda m: m.body("b", 1.0, (1.0, 1.0, 1.0), axes=np.eye(3)),
        ("body 'b': axes is array([[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]); give two axes that "
        "are not parallel, a rotation vector in rad, or four Euler parameters; of a rotation "
        "matrix R give R.T[:2]."),
    ),
    "place of two": (
        lambda m: m.body("b", 1.0, (1.0, 1.0, 1.0), at=(1, 2)),
        "body 'b': at is (1, 2); give 3 numbers, as (1.0, 0.0, 0.0).",
    ),
    "point of two": (
        lambda m: m.spherical("S", m.ground, m.bodies["a"], at=(1, 2)),
        "'S': at is (1, 2); give 3 numbers, as (1.0, 0.0, 0.0).",
    ),
    "no axis": (
        lambda m: m.revolute("R", m.ground, m.bodies["a"], at=(0, 0, 0), axis=(0, 0, 0)),
        "revolute in space 'R': axis (0, 0, 0) has no direction; give one.",
    ),
    "no numbers of an axis": (
        lambda m: m.revolute("R", m.ground, m.bodies["a"], at=(0, 0, 0), axis=()),
        ("revolute in space 'R': axis is (); give three numbers in global axes, or an axis of each "
        "body, as (i.along(1, 0, 0), j.along(1, 0, 0))."),
    ),
    "axis of one body": (
        lambda m: m.revolute(
            "R", m.ground, m.bodies["a"], at=(0, 0, 0), axis=(m.ground.along(*Z),)
        ),
        "; give three numbers in global axes, or an axis of each body, as (i.along(1, 0, 0),",
    ),
    "three axes": (
        lambda m: m.revolute(
            "R", m.ground, m.bodies["a"], at=(0, 0, 0), axis=[m.ground.along(*Z)] * 3
        ),
        "; give three numbers in global axes, or an axis of each body, as (i.along(1, 0, 0),",
    ),
    "axis of another body": (
        lambda m: m.revolute(
            "R", m.ground.at(0, 0, 0), m.bodies["a"].at(0, 0, 0),
            axis=(m.bodies["a"].along(*Z), m.bodies["a"].along(*Z)),
        ),
        "is no axis of body 'ground'.",
    ),
    "point with at": (
        lambda m: m.spherical("S", m.ground, m.bodies["a"].at(0, 0, 0), at=(0, 0, 0)),
        "'S', with at=: Point of 'a' is no body; give a body as a whole.",
    ),
    "one axis": (
        lambda m: m.universal("U", m.ground, m.bodies["a"], at=(0, 0, 0), axes=X),
        "universal 'U': axes=(1, 0, 0); give two axes.",
    ),
    "parallel axes of a cross": (
        lambda m: m.universal("U", m.ground, m.bodies["a"], at=(0, 0, 0), axes=(Z, Z)),
        ("universal 'U': at the drawing the axes of 'ground' and 'a' are 0° apart, and the joint "
        "keeps them at 90°. Give such axes, or another angle=."),
    ),
    "angle of a cross that is drawn at another": (
        lambda m: m.universal("U", m.ground, m.bodies["a"], at=(0, 0, 0), axes=(X, Z), angle=1.2),
        ("universal 'U': at the drawing the axes of 'ground' and 'a' are 90° apart, and the joint "
        "keeps them at 68.75°. Give such axes, or another angle=."),
    ),
    "axes of a cross": (
        lambda m: m.universal(
            "U", m.ground, m.body("b", 1.0, (1.0, 1.0, 1.0), axes=(0, 0, 0.5)),
            at=(0, 0, 0), axes=(X, (np.sin(np.radians(-17)), np.cos(np.radians(-17)), 0)),
        ),
        "universal 'U': at the drawing the axes of 'ground' and 'b' are 107° apart",
    ),
    "axis and hinge": (
        lambda m: m.revolute_cylindrical(
            "R", m.ground, m.bodies["a"], at=(0, 0, 0), axis=X, hinge=(1, 1, 0)
        ),
        "revolute_cylindrical 'R': at the drawing the axes of 'ground' and 'a' are 45° apart",
    ),
    "itself": (
        lambda m: m.spherical("S", m.bodies["a"].at(0, 0, 0), m.bodies["a"].at(0, 0, 1)),
        "spherical 'S' connects body 'a' with itself; give two different bodies.",
    ),
    "no point": (
        lambda m: m.spherical("S", m.ground, "a"),
        "'S': 'a' is neither a point nor a body of a machine in space; write body.at(x, y, z).",
    ),
    "pushed ground": (
        lambda m: m.force("F", m.ground.at(0, 0, 0), (1, 0, 0)),
        "force in space 'F' acts on the ground; give a moving body.",
    ),
    "force of two": (
        lambda m: m.force("F", m.bodies["a"], (1, 0)),
        "value of force in space 'F': (1, 0) is not 3 values; write value=(1, 0, 0).",
    ),
    "torque on a hinge": (
        lambda m: m.torque("T", hinge(m), (1, 0, 0)),
        "torque in space 'T', on: revolute in space 'A' is no body; give a body as a whole.",
    ),
    "spring of a hinge": (
        lambda m: m.line_force("F", hinge(m), m.bodies["a"], 1),
        "'F': revolute in space 'A' is neither a point nor a body of a machine in space; write",
    ),
    "torsion spring of bodies": (
        lambda m: m.torsion_spring("S", m.ground, m.bodies["a"]),
        "a body is none, but its coordinates are, a.x, a.y or a.z.",
    ),
    "force of a rate": (
        lambda m: m.generalized_force("F", {hinge(m).rate: 1}),
        "force 'F': A_rate moves no body; write A.angle.",
    ),
    "force of a spin": (
        lambda m: m.generalized_force("F", {m.bodies["a"].omega_z: 1}),
        "force 'F': a_omega_z moves no body; write body.x or joint.angle.",
    ),
    "flat gravity": (
        lambda m: m.gravity("g", (0, -9.81)),
        "g of gravity in space 'g': (0, -9.81) is not 3 values; write g=(1, 0, 0).",
    ),
    "length": (
        lambda m: m.distance("D", m.ground, m.bodies["a"], -1.0),
        "the length is -1 m; give a positive number, or use a spherical joint.",
    ),
    "mass of t": (
        lambda m: m.body("b", 1.0 + t, (1.0, 1.0, 1.0)),
        "mass of body 'b' is t + 1.0; masses that vary are there for machines in the plane alone",
    ),
    "force on the ground": (
        lambda m: m.scene("s", outputs=["shaking"]),
        ("scene 's': the force on the ground needs x, y and phi, but body 'a' has x, y, z, e0, e1, "
        "e2, e3; leave that output out."),
    ),
    "series of the ground": (
        lambda m: m.scene("s", outputs={"double": 2 * m.series("ground.fx")}),
        "scene 's': the force on the ground needs x, y and phi, but body 'a' has",
    ),
    "global reaction": (
        lambda m: (
            m.spherical("S", m.ground, m.bodies["a"], at=(0, 0, 0)),
            m.scene("s", outputs=["global_reaction(S)"]),
        ),
        "reactions in space are in global axes; ask for 'reaction(S)'.",
    ),
    "global reactions": (
        lambda m: m.scene("s", outputs=["global_reactions"]),
        "scene 's': reactions in space are in global axes; ask for 'reactions'.",
    ),
    "start": (
        lambda m: m.scene("other", start={"a.omega": 1.0}),
        "scene 'other': 'a.omega' is no coordinate or velocity; did you mean a.omega_z",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_told(case: str, tmp_path: Path) -> None:
    mistake, text = MISTAKES[case]
    model = declared()
    mistake(model)
    if not model.scenes:
        model.scene("s")
    with pytest.raises(ModelError) as refusal:
        build(model, out=tmp_path, compile=False)
    assert text in str(refusal.value)


@pytest.mark.parametrize("space", [True, False])
def test_gravity_that_is_not_declared_is_written_as_the_machine_needs_it(space: bool) -> None:
    model = Model("machine", space=space)
    model.scene("s", effects=["gravity"])
    (problem,) = model.problems
    numbers = "(0, 0, -9.81)" if space else "(0, -9.81)"
    advice = f"declare it, as Model(..., gravity={numbers}) does."
    assert problem == f"scene 's': no effect 'gravity'; {advice}"


@pytest.mark.parametrize("drawn", ["rounded", "angle", "of the bodies"])
def test_axes_of_a_cross_that_are_not_refused(drawn: str) -> None:
    model = declared()
    a, words = model.bodies["a"], {}
    axes: Any = X, (0.005, 1, 0)
    if drawn == "angle":
        axes, words = (X, (1, 1, 0)), {"angle": np.pi / 4}
    elif drawn == "of the bodies":
        axes = model.ground.along(*X), a.along(1, 1, 0)  # the drawing is a guess
    model.universal("U", model.ground, a, at=(0, 0, 0), axes=axes, **words)
    assert not model.problems


def test_a_stop_of_two_coordinates_is_one_problem() -> None:
    model = declared()
    joint = model.cylindrical("c", model.ground, model.bodies["a"], at=(0, 0, 0), axis=Z)
    model.stop("s", joint, upper=1.0, restitution=0.5)
    (problem,) = model.problems
    assert problem == (
        "stop 's': 'c' is no joint with one coordinate; give c.angle or c.slide, or an expression "
        "of coordinates."
    )


def test_a_stop_of_a_joint_without_coordinates_names_joints_that_have_one() -> None:
    model = declared()
    ball = model.spherical("b", model.ground, model.bodies["a"], at=(0, 0, 0))
    model.stop("s", ball, upper=1.0, restitution=0.5)
    (problem,) = model.problems
    assert problem == (
        "stop 's': 'b' is no joint with one coordinate; give a revolute or a translational joint "
        "itself, or an expression of coordinates."
    )


def test_space_is_true_or_false() -> None:
    assert not Model("machine").in_space
    assert declared().in_space
    model = Model("machine", space="yes")  # type: ignore[arg-type]
    model.body("a", 1.0, 1.0)
    model.scene("s")
    with pytest.raises(ModelError, match="space='yes'; write True or False"):
        build(model, compile=False)


def test_an_inertia_of_parameters_is_judged_before_each_run(workshop: Path) -> None:
    model = Model("machine", space=True)
    j = model.parameter("J", 0.3, "kg m^2")
    model.body("a", 1.0, (j, 0.5, j))
    model.scene("s")
    machine = load(model, folder=workshop)
    assert machine.simulate(0.1, 2, parameters={"J": 0.25}, progress=False).t[-1] == 0.1
    for value, fault in ((0.2, "has a moment above the sum"), (-0.1, "is not positive definite")):
        with pytest.raises(ParameterError, match=f"body 'a': inertia: it {fault}"):
            machine.simulate(0.1, 2, parameters={"J": value}, progress=False)


def test_a_body_without_inertia_moves_in_kinematics_alone(tmp_path: Path) -> None:
    model = Model("machine", space=True)
    model.body("a", 1.0)
    model.scene("s")
    with pytest.raises(ModelError, match="body 'a' has no inertia; give it in"):
        build(model, out=tmp_path, compile=False)


def test_modes_and_limits_are_refused(workshop: Path) -> None:
    machine = load(heavy_top(), folder=workshop)
    result = machine.simulate(0.01, 3, progress=False)
    with pytest.raises(AnalysisError, match="assembly_modes are there for machines in the plane"):
        machine.assembly_modes()
    with pytest.raises(AnalysisError, match="limits are there for machines in the plane"):
        machine.limits("top.z")
    assert result.plot("top.omega_y", "top.z") is not None


@pytest.mark.parametrize("hinges", [1, 2])
def test_a_driver_too_many_names_joints_only_where_two_hold_the_same_bodies(
    hinges: int, tmp_path: Path
) -> None:
    model = declared()
    a = model.bodies["a"]
    for k in range(hinges):
        model.revolute(f"A{k}", model.ground, a, at=(0, 0, k), axis=Z)
    tip = a.at(0.3, 0.1, 0)
    model.driver("one", tip.x, 0.3 - 0.1 * t)
    model.driver("two", tip.y, 0.1 + 0.1 * t)
    model.scene("run", drivers=["one", "two"])
    with pytest.raises(ModelError) as refusal:
        build(model, "run", out=tmp_path, compile=False)
    if hinges == 1:
        assert "Remove or relax 'two': no motion is left" in str(refusal.value)
    else:
        assert "Joints A0 and A1 hold the same bodies" in str(refusal.value)
