"""What is wrong with a model is said by name, all of it at once, and nothing is written."""

import pickle
from pathlib import Path
from typing import Any

import pytest

from codegen import LinkwrightError, Model, ModelError
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.complaints import check, complaints


def test_constraints_that_contradict_one_another(tmp_path: Path) -> None:
    text = "model.absolute('A', a, 'phi', 0.5)\nmodel.driver('d', a.phi, 0.5 + t)"
    check(complaints(tmp_path, text), [r"redundant: d\.phi \(driver\). Remove or relax 'd'"])


def test_conditions_are_reported_in_the_order_of_the_pieces(tmp_path: Path) -> None:
    text = """
from sympy import Piecewise
c, d = Symbol("c", boolean=True), Symbol("d", boolean=True)
model.force("f", a, Piecewise((1, c), (2, d), (3, True)))
"""
    found = [line for line in complaints(tmp_path, text) if "is no condition" in line]
    assert [line.split()[2] for line in found] == ["c", "d"]


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


def test_all_problems_of_a_model_come_at_once(tmp_path: Path) -> None:
    text = """
c = model.body("c", mass=-1.0, inertia=2.0)
model.revolute("A", a.at(0, 0), a.at(1, 0))
model.force("f", on=model.ground, fx=Symbol("z"))
model.potential("v", Symbol("kk") * a.x)
model.parameter("p", float("nan"))
model.body("class", 1, 1)
model.scene("s", ["nothing"], start={"q.x": 1})
"""
    found = complaints(tmp_path, text)
    check(
        found,
        [
            "mass of body 'c'",
            "revolute 'A' connects",
            "force 'f' acts on the ground",
            "force 'f': unknown symbol 'z'",
            "potential 'v'",
            "parameter 'p' is nan",
            "body name 'class'",
            "scene 's': no effect",
            "scene 's': 'q.x'",
        ],
    )


def test_all_problems_of_all_scenes_come_at_once(tmp_path: Path) -> None:
    text = """
c = model.body("c")
model.scene("one", ["gravity"])
model.scene("two", [], without=[c], start={c.x: 1.0})
"""
    check(
        complaints(tmp_path, text),
        ["scene 'one': body 'c' has no mass", "scene 'two': c.x has a start"],
    )


@pytest.mark.parametrize("arguments", [(), ("a",), ("a", 1), (("a", "b"),)])
def test_base_of_all_errors_takes_what_an_exception_takes(arguments: tuple[Any, ...]) -> None:
    error = LinkwrightError(*arguments)
    assert pickle.loads(pickle.dumps(error)).args == error.args
    assert ("a" in str(error)) == bool(arguments)
