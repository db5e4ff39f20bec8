"""A start that is far from its guess is a note wherever a machine is assembled."""

from pathlib import Path

import numpy as np
import pytest
from sympy import log

from codegen import Model, build
from codegen.errors import AssemblyError
from codegen.explain.declaration_report import check_declaration
from runtime import load

TURNED = "Closing the joints turns by more than a right angle: arm from 0.0° to 171.9°."
MIRRORED = "A loop closes as the mirror image of its guess: left from 20.0° to -36.9°, right from "


def arm(driven: float = 3.0) -> Model:
    model = Model("arm")
    body = model.body("arm", mass=1.0, inertia=1.0)
    model.revolute("pin", model.ground.at(0, 0), body.at(-1, 0))
    model.driver("motor", body.phi, driven)
    model.scene("turned", drivers=["motor"], guess={body.x: 1.0, body.phi: 0.0})
    return model


def roof(side: float = 1.0, guess: float = 20.0) -> Model:
    """Two bars of a length of 1 m over 1.6 m, guessed to stand below, their angles those above."""
    model = Model("roof")
    left, right = (model.body(name, mass=1.0, inertia=1.0) for name in ("left", "right"))
    model.revolute("A", model.ground.at(0, 0), left.at(-side / 2, 0))
    model.revolute("B", left.at(side / 2, 0), right.at(-side / 2, 0))
    model.revolute("C", right.at(side / 2, 0), model.ground.at(1.6, 0))
    degree = 3.141592653589793 / 180
    model.scene("still", guess={
        left.x: 0.4, left.y: -0.5, left.phi: guess * degree,
        right.x: 1.2, right.y: -0.5, right.phi: -guess * degree,
    })  # fmt: skip
    return model


@pytest.mark.parametrize(("model", "said"), [(arm(), TURNED), (roof(), MIRRORED)])
def test_a_far_start_is_a_note_everywhere(model: Model, said: str, tmp_path: Path) -> None:
    (scene,) = check_declaration(model).scenes
    (built,) = build(model, out=tmp_path).scenes
    with pytest.warns(UserWarning, match="[Cc]los") as drawn:
        model.draw()
    machine = load(model, folder=tmp_path)
    texts = [*scene.notes, *built.notes, str(drawn[0].message), str(machine.assemble())]
    texts.append(machine.kinematics([0.0]).message)
    assert [said in text for text in texts] == [True] * 5
    assert built.problem == scene.problem == ""


def test_near_starts_bear_no_note(tmp_path: Path) -> None:
    for model in (arm(1.5), roof(guess=-20.0)):
        assert load(model, folder=tmp_path).assemble().note == ""


def lever(guess: float) -> Model:
    """A lever of 1 m about (5, 0), of which a cylinder from (4, 1) has it stand at 100° or 170°."""
    model = Model("lever")
    body = model.body("arm", mass=1.0, inertia=1.0)
    model.revolute("pin", model.ground.at(5, 0), body.at(0, 0))
    at_100 = np.hypot(1.0 + np.cos(np.radians(100.0)), np.sin(np.radians(100.0)) - 1.0)
    model.distance_driver("cylinder", model.ground.at(4, 1), body.at(1, 0), float(at_100))
    model.scene("held", drivers=["cylinder"], guess={body.phi: np.radians(guess)})
    return model


@pytest.mark.parametrize(("guess", "mirrored"), [(95.0, False), (110.0, False), (190.0, True)])
def test_a_loop_whose_angles_alone_have_guesses_is_judged_at_its_place(
    guess: float, *, mirrored: bool
) -> None:
    start = load(lever(guess)).assemble()
    assert np.degrees(start["arm.phi"]) % 360.0 == pytest.approx(100.0)
    assert ("mirror image of its guess: arm" in start.note) == mirrored


def test_a_refusal_is_the_same_everywhere(tmp_path: Path) -> None:
    model = roof(side=0.7)
    (problem,) = check_declaration(model).problems
    (built,) = build(model, out=tmp_path).scenes
    with pytest.warns(UserWarning, match="roof/still: the machine cannot be assembled"):
        machine = load(model, folder=tmp_path)
    with pytest.raises(AssemblyError) as refused:
        machine.kinematics([0.0])
    assert problem == built.problem == str(refused.value)


def test_a_driver_out_of_reach_says_by_how_much(tmp_path: Path) -> None:
    """A cylinder from (3, 0) to the end of an arm of 2 m about the origin reaches 1 m to 5 m."""
    model = Model("crane")
    body = model.body("arm", mass=1.0, inertia=1.0)
    model.revolute("pin", model.ground.at(0, 0), body.at(-1, 0))
    model.distance_driver("cylinder", model.ground.at(3, 0), body.at(1, 0), 5.5)
    model.scene("lifted", drivers=["cylinder"], guess={body.phi: 1.0})
    (problem,) = check_declaration(model).problems
    assert "driver cylinder asks for 0.5 m more than the joints let it reach" in problem


def test_a_start_whose_search_leaves_a_logarithm_is_loaded_without_a_note() -> None:
    model = Model("logarithm")
    arm, slide = (model.body(name, mass=1.0, inertia=0.1) for name in ("arm", "slide"))
    model.revolute("pin", model.ground.at(0, 0), arm.at(-1, 0))
    model.translational("guide", model.ground, slide, axis=(1, 0))
    model.constraint("law", log(slide.x + 1) + 3 - 0.01 * arm.phi)
    model.driver("motor", arm.phi, 1.0)
    model.scene("s", drivers=["motor"], guess={arm.phi: 0.2})
    assert np.isfinite(load(model).assemble().q).all()
