"""What is wrong with a friction, dry or in a joint, is said by name."""

from collections.abc import Callable
from pathlib import Path

import pytest

from codegen import Model, ModelError
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.complaints import check, complaints


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("normal=1, coefficient=-0.1, slip=a.vx", ["dry friction 'f': the coefficient .* is -0.1"]),
        ("normal=-2, coefficient=0.1, slip=a.vx", ["the normal force is -2 N; give a number"]),
        ("normal=1, coefficient=0.3, static=0.2, slip=a.vx",
         ["the static coefficient 0.2 is below the kinetic one, 0.3"]),
        ("normal=1, coefficient=0, static=0.2, slip=a.vx",
         ["the coefficient of friction is 0 and the static one 0.2"]),
        ("normal=1, coefficient=0.1, static=0.2, creep=1e-3, slip=a.vx",
         ["dry friction 'f' has both static= and creep=; a friction that creeps never sticks"]),
        ("normal=1, coefficient=0.1, creep=0, slip=a.vx", ["the creep speed is 0; give a pos"]),
        ("normal=1, coefficient=0.1, slip=a.x - 1", ["the slip a_x - 1.* is no velocity"]),
        ("normal=1, coefficient=0.1, slip=a.vx * b.vy", ["is not linear in a_vx; write"]),
        ("normal=1, coefficient=0.1, slip=abs(a.vx)", ["is not linear in a_vx; write"]),
        ("normal=1, coefficient=0.1", ["dry friction 'f' has no slip; give two points"]),
        ("a, b, normal=1, coefficient=0.1, slip=a.vx", ["both slip= and points; give one"]),
        ("a, b, normal=1, coefficient=0.1, axis=(0, 0)", ["the axis .0, 0. points nowhere"]),
        ("a, a.at(1, 0), normal=1, coefficient=0.1", ["between body 'a' and itself; give two"]),
        ("normal=Symbol('N'), coefficient=0.1, slip=a.vx", ["unknown symbol 'N'; declare it"]),
        ("normal=1, coefficient=None, slip=a.vx", ["coefficient of dry friction 'f' is missing"]),
        ("normal=1, coefficient=0.1 + a.x, slip=a.vx",
         ["scene 'default': dry friction 'f': the coefficient .* varies in a run; .* give creep="]),
        ("normal=1, coefficient=k, static=0.3, slip=a.vx",
         ["scene 'default': dry friction 'f': the static coefficient is 0.3, below .* k = 5"]),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(tmp_path: Path, text: str, expected: list[str]) -> None:
    check(complaints(tmp_path, f"model.dry_friction('f', {text})"), expected)


Declare = Callable[[Model, object, object], object]


@pytest.mark.parametrize(
    ("declare", "told"),
    [
        (lambda m, g, p: m.friction("rub", g, -0.1, 1e-3),
         "friction 'rub': the coefficient of friction is -0.1; give a number that is not negative"),
        (lambda m, g, p: m.friction("rub", g, 0.1, 0), "the creep speed is 0; give a positive"),
        (lambda m, g, p: m.friction("rub", p, 0.1, 1e-3), "revolute joint 'pin' needs radius="),
        (lambda m, g, p: m.friction("rub", g, 0.1, 1e-3, radius=1), "'guide' has no pin"),
        (lambda m, g, p: m.friction("rub", p, 0.1, 1e-3, radius=1, length=2), "no long bearing"),
        (lambda m, g, p: m.friction("rub", 3, 0.1, 1e-3), "3 is no joint that rubs"),
        (lambda m, g, p: m.friction("rub", "guide", 0.1, 1e-3), "joint itself, not its name"),
        (lambda m, g, p: m.friction("rub", p, None, 1e-3, radius=1),
         "coefficient of friction 'rub' is missing"),
        (lambda m, g, p: (m.friction("rub", g, 0.1, 1e-3), m.scene("s", ["rub"], without=[g])),
         "effect 'rub' needs joint 'guide', which takes no part"),
        (lambda m, g, p: m.friction("rub", g, 0.3, static=0.2), "0.2 is below the kinetic one"),
        (lambda m, g, p: m.friction("rub", g, 0.3, 1e-3, static=0.4), "both static= and creep="),
        (lambda m, g, p: (m.friction("rub", g, 0.3, static=0.4),
                          m.force("gas", m.bodies["one"], fx=1, when=m.bodies["one"].vx < 0)),
         "scene 'default': 'rub' and 'gas' both change where one_vx = 0, and 'rub' has a static"),
        (lambda m, g, p: (m.friction("rub", g, 0.3, static=0.4),
                          m.dry_friction("wet", slip=m.bodies["one"].vx, normal=1, coefficient=1)),
         "'rub' and 'wet' both change where one_vx = 0, and 'rub' has a static"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_joint_is_said(declare: Declare, told: str) -> None:
    model = Model("bad")
    one, other = model.body("one", 1.0, 1.0), model.body("other", 1.0, 1.0)
    guide = model.translational("guide", model.ground, one)
    declare(model, guide, model.revolute("pin", one.at(0, 0), other))
    with pytest.raises(ModelError) as caught:
        valid_scenes(model, None)
    assert told in str(caught.value)


def test_scene_with_its_own_parameters_is_checked() -> None:
    model = Model("belt")
    block = model.body("block", 1.0, 1.0)
    kinetic, static = model.parameter("kinetic", 0.2), model.parameter("static", 0.3)
    model.dry_friction("rub", slip=block.vx, normal=1.0, coefficient=kinetic, static=static)
    assert model.parameters["kinetic"].sign == "positive"
    model.scene("fine", ["rub"])
    model.scene("odd", ["rub"], parameters={static: 0.1})
    with pytest.raises(
        ModelError, match=r"scene 'odd': .* static is 0\.1, below .* kinetic = 0\.2"
    ):
        valid_scenes(model, None)
