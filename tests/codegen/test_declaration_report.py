"""`check_declaration`: all problems at once, and what sound scenes amount to."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model, ModelFileError, ParameterError, SceneError, t
from codegen.explain.declaration_report import check_declaration

DRAWN = {"coupler.x": 1.8, "coupler.y": 1.2, "coupler.phi": 0.9, "rocker.y": 1.2, "rocker.x": 2.8}
DRAWN |= {"rocker.phi": 1.7}


def linkage(crank: float = 1.0, rocker_end: float = 1.25, closed: bool = True) -> Model:
    """A four-bar linkage with a parameter, an effect and a driver that no scene uses."""
    model = Model("linkage", gravity=(0, -9.81))
    model.parameter("spare", 1.0)
    speed = model.parameter("speed", 2.0)
    bars = {
        name: model.body(name, mass=1.0, inertia=0.1) for name in ("crank", "coupler", "rocker")
    }
    ends = {"crank": crank, "coupler": 3.0, "rocker": 2.5}
    left = {name: bars[name].at(-ends[name] / 2, 0) for name in bars}
    right = {name: bars[name].at(ends[name] / 2, 0) for name in bars}
    model.revolute("A", model.ground.at(0, 0), left["crank"])
    model.revolute("B", right["crank"], left["coupler"])
    model.revolute("C", right["coupler"], bars["rocker"].at(rocker_end, 0))
    if closed:
        model.revolute("D", model.ground.at(3, 0), left["rocker"])
    model.torque("push", on=bars["crank"], value=3.0)
    model.driver("motor", bars["crank"].phi, speed * t)
    model.driver("other", bars["rocker"].phi, t)
    model.track("tip", bars["rocker"].at(0.5, 0))  # a page shows its path: used
    model.scene("free", ["gravity"], start={"crank.phi": 0.0}, guess=DRAWN)
    model.scene("driven", drivers=["motor"], guess=DRAWN)
    return model


def test_a_sound_model() -> None:
    report = check_declaration(linkage())
    assert report.problems == ()
    free, driven = report.scenes
    assert (free.scene, free.coordinates, free.constraints) == ("free", 9, 8)
    assert free.degrees_of_freedom == 1
    assert (driven.constraints, driven.degrees_of_freedom, driven.drivers) == (9, 0, ("motor",))
    assert free.notes == ()
    assert free.gap < 1e-12
    assert report.unused == {"effects": ("push",), "drivers": ("other",), "parameters": ("spare",)}


def test_a_label_of_a_condition_that_no_law_contains() -> None:
    model = Model("ball")
    ball = model.particle("ball", mass=1.0)
    model.force("push", on=ball, fx=1.0, when=ball.x < 2, label="push begins / push ends")
    model.force("idle", on=ball, fx=1.0, when=ball.y < 2, label="left out")
    model.label(ball.x > 3, "never fires")
    model.scene("free", ["push"])
    assert check_declaration(model).unused["labels"] == ("left out", "never fires")


def test_the_position_is_that_of_a_triangle() -> None:
    """With the crank along the ground, BCD has the sides 3, 2.5 and 2."""
    report = check_declaration(linkage(), "free")
    (free,) = report.scenes
    assert {*report.facts()["scenes"][0]["moved"][0]} == {"name", "guess", "reached", "unit"}
    reached = {one.name: one.reached for one in free.moved}
    angle = np.arccos((3.0**2 + 2.0**2 - 2.5**2) / (2 * 3.0 * 2.0))
    assert reached["coupler.phi"] == pytest.approx(angle, rel=1e-10)
    assert "crank.phi" not in reached
    guesses = {one.name: one.guess for one in free.moved}
    assert guesses["coupler.phi"] == 0.9


def test_one_scene_says_nothing_of_what_no_scene_uses() -> None:
    report = check_declaration(linkage(), "driven")
    assert [scene.scene for scene in report.scenes] == ["driven"]
    assert report.unused == {}
    assert "push" in report.scenes[0].left_out


def test_joints_that_cannot_close() -> None:
    report = check_declaration(linkage(crank=12.0))
    assert len(report.problems) == 2
    for problem in report.problems:
        assert "the machine cannot be assembled at t = 0 s" in problem
        assert " misses by " in problem
    assert report.facts()["ok"] is False
    assert report.unused == {}


def test_a_value_of_a_parameter_can_open_joints() -> None:
    model = Model("rod")
    length = model.parameter("length", 1.0, sign="positive")
    a = model.body("a", mass=1.0, inertia=1.0)
    model.revolute("A", model.ground.at(0, 0), a.at(-length, 0))
    model.revolute("B", model.ground.at(2, 0), a.at(length, 0))
    model.scene("still")
    assert check_declaration(model).problems == ()
    (problem,) = check_declaration(model, settings={"length": 1.5}).problems
    assert "rod/still" in problem
    assert "B.x is redundant and contradictory" in problem
    assert "gap 0.5" in problem


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            {"start": {"crank.phi": 0.0, "rocker.phi": 0.0}},
            r"the fixed start values leave joints open.*crank\.phi = 0 rad, rocker\.phi = 0",
        ),
        (
            {"drivers": ["other"], "guess": DRAWN},
            r"the joints close, but not with what the drivers \(other\) demand at t = 0",
        ),
        (
            {"drivers": ["motor", "other"], "guess": DRAWN},
            "Remove or relax 'other': no motion is left",
        ),
    ],
)
def test_scenes_that_contradict_themselves(words: dict[str, Any], told: str) -> None:
    model = linkage()
    model.scene("torn", **words)
    (problem,) = check_declaration(model).problems
    assert re.search(f"torn.*{told}", problem)


def test_two_joints_that_contradict_each_other_are_named_before_a_driver() -> None:
    model = Model("two")
    a, b = (model.body(name, mass=1.0, inertia=1.0) for name in "ab")
    model.revolute("O", model.ground.at(0, 0), a.at(0, 0))
    model.revolute("A", a.at(1, 0), b.at(0, 0))
    model.revolute("B", a.at(2, 0), b.at(1.3, 0))
    model.driver("motor", a.phi, t)
    model.scene("driven", drivers=["motor"])
    (problem,) = check_declaration(model).problems
    assert "Joints A and B hold the same bodies: remove one of them." in problem
    assert "Remove or relax" not in problem


def test_a_point_with_a_wrong_sign_is_named() -> None:
    hint, *open_joints = check_declaration(linkage(rocker_end=-1.25)).problems
    assert all("free" in text or "driven" in text for text in open_joints)
    assert len(open_joints) == 2
    assert hint.startswith("Joints C and D hold body 'rocker' at one point, (-1.25, 0): ")
    slider = Model("slider")
    crank, rod, block = (slider.body(name, mass=1.0, inertia=0.1) for name in ("a", "b", "c"))
    slider.revolute("A", slider.ground.at(0, 0), crank.at(-9, 0))
    slider.revolute("B", crank.at(9, 0), rod.at(-1, 0))
    slider.revolute("C", rod.at(1, 0), block)
    slider.translational("guide", slider.ground, block, axis=(1, 0))
    slider.driver("motor", crank.phi, 1.5)
    slider.scene("driven", drivers=["motor"])
    other = check_declaration(linkage(crank=9.0)).problems + check_declaration(slider).problems
    assert len(other) == 3
    assert not any("at one point" in text for text in other)


def test_a_place_that_is_no_number_hides_no_problem() -> None:
    model = linkage(crank=9.0)
    nothing = model.parameter("nothing", 0.0)
    body = model.body("hanging", mass=1.0, inertia=1.0)
    for name in ("E", "F"):
        model.revolute(name, model.ground.at(0, 0), body.at(1 / nothing, 0))
    assert check_declaration(model).problems


def test_a_forgotten_joint_leaves_a_body_on_one_joint() -> None:
    assert all(scene.one_joint == {} for scene in check_declaration(linkage()).scenes)
    report = check_declaration(linkage(closed=False))
    assert [(s.one_joint, s.degrees_of_freedom) for s in report.scenes] == [
        ({"rocker": "C"}, 3), ({"rocker": "C"}, 2),
    ]  # fmt: skip
    assert report.facts()["scenes"][0]["one_joint"] == {"rocker": "C"}


def test_a_joint_too_many_is_a_note() -> None:
    bar = Model("bar")
    body = bar.body("body", mass=1.0, inertia=1.0)
    bar.revolute("A", bar.ground.at(0, 0), body.at(0, 0))
    bar.revolute("B", bar.ground.at(0, 0), body.at(0, 0))
    report = check_declaration(bar)
    (scene,) = report.scenes
    assert report.problems == ()
    assert (scene.scene, scene.degrees_of_freedom) == ("default", 1)
    assert "redundant: B.x (revolute), B.y (revolute)" in scene.notes[0]


def test_problems_of_model_and_scenes_come_together() -> None:
    model = Model("wrong")
    a = model.body("a", mass=-1.0, inertia=1.0)
    model.spring("s", a, model.ground.at(0, 0), stiffness=3.0)
    model.scene("one", ["gravty"])
    model.scene("two", start={"c.phi": 1.0})
    problems = "\n".join(check_declaration(model).problems)
    for part in ("mass of body 'a' is -1 kg", "spring 's' has a stiffness", "no effect 'gravty'"):
        assert part in problems
    assert "'c.phi' is no coordinate" in problems


def test_no_joints_at_all() -> None:
    model = Model("stone")
    model.body("stone", mass=1.0, inertia=1.0)
    (scene,) = check_declaration(model).scenes
    assert (scene.constraints, scene.gap, scene.moved) == (0, 0.0, ())


def test_wrong_words_are_errors(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="no scene 'fre'; did you mean 'free'"):
        check_declaration(linkage(), "fre")
    with pytest.raises(ParameterError, match="no parameter 'sped'; did you mean 'speed'"):
        check_declaration(linkage(), settings={"sped": 1.0})
    with pytest.raises(ModelFileError):
        check_declaration(tmp_path / "nothing.py")


def test_every_library_model_is_sound(root: Path) -> None:
    """Those that the book does not have: the others are built by other tests."""
    for name in ("quarter_car", "trebuchet", "scotch_yoke", "engine"):
        report = check_declaration(root / "models" / f"{name}.py")
        assert report.problems == ()
        assert all(scene.gap < 1e-12 for scene in report.scenes)
