"""Names and units come out of a model as they went in, or not at all."""

from copy import copy
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest

from codegen import Body, InputError, Model, ModelError, build
from codegen.explain.declaration_report import check_declaration
from tests.codegen.complaints import HEAD, complaints
from tests.codegen.workbench import write_model

INJECTIONS = ["x\nimport os", 'x"""', "x'", "", "1x", "class", "a.b", "λ", "_x", "x\\", "{x}", 7]


@pytest.mark.parametrize("name", INJECTIONS)
@pytest.mark.parametrize(
    "declare",
    [
        "model.body({}, mass=1, inertia=1)",
        "model.parameter({}, 1.0)",
        "model.revolute({}, a.at(0, 0), b.at(0, 0))",
        "model.driver({}, a.x, t)",
        "model.torque({}, on=a, value=1)",
        "model.scene({})",
        "model = Model({}); model.body('a', 1, 1)",
    ],
)
def test_names_are_identifiers(tmp_path: Path, declare: str, name: object) -> None:
    path = write_model(tmp_path, HEAD + declare.format(repr(name)))
    with pytest.raises(InputError) as caught:
        build(path, out=tmp_path / "out", compile=False)
    assert len(caught.value.problems) == 1
    kind = declare.partition("(")[0].rpartition(".")[2].rpartition(" ")[2].lower()
    kind = {"revolute": "joint", "torque": "effect"}.get(kind, kind)
    assert caught.value.problems[0].startswith(f"{kind} name {name!r} is no identifier")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("unit", ['m"; import os; "', "m\nimport os", "m\\", "__import__('os')"])
def test_units_reach_the_text_only_when_pint_knows_them(tmp_path: Path, unit: str) -> None:
    (found,) = complaints(tmp_path, f"model.parameter('c', 1.0, unit={unit!r})")
    assert found.startswith("parameter 'c': the unit ")


def test_word_of_python_is_said_to_be_one(tmp_path: Path) -> None:
    (found,) = complaints(tmp_path, "model.parameter('lambda', 1.0)")
    assert found.startswith("parameter name 'lambda' is no identifier, but a word of Python's own")


def test_what_a_part_does_not_have_is_said_by_its_name() -> None:
    model = Model("m")
    rod, bead = model.body("rod", mass=1.0, inertia=1.0), model.particle("bead", mass=1.0)
    scene = model.scene("s")
    for part, word, told in (
        (rod, "theta", "Body 'rod' has no 'theta'; it has angle, .*phi"),
        (bead, "fi", "Particle 'bead' has no 'fi'"),
        (rod.at(0, 0), "s", "Point has no 's'; did you mean .*sx"),
        (rod.circle(1), "radius", "Curve has no 'radius'"),
        (scene, "effect", "Scene 's' has no 'effect'; did you mean effects"),
    ):
        with pytest.raises(ModelError, match=told):
            getattr(part, word)
        assert not hasattr(part, word)
    assert copy(rod.at(1, 0)).sx == 1


def test_a_property_that_fails_keeps_its_own_error() -> None:
    class Odd(Body):
        @property
        def length(self) -> float:
            return self.name.half  # type: ignore[attr-defined, no-any-return]

    with pytest.raises(AttributeError, match="'str' object has no attribute 'half'"):
        _ = Odd("rod", None, None, None).length


MISTAKES = {
    "a body named like a parameter": """
        crank = model.parameter("crank", 0.04, unit="m")
        b = model.body("crank", mass=1.0, inertia=0.1)
    """,
    "two bodies of one name": """
        model.body("b", mass=1.0, inertia=0.1)
        b = model.body("b", mass=1.0, inertia=0.1)
    """,
    "a body whose name is no identifier": 'b = model.body("2b", mass=1.0, inertia=0.1)',
    "a mass that is text": 'b = model.body("b", mass="heavy", inertia=0.1)',
    "a parameter named like a body": """
        b = model.body("b", mass=1.0, inertia=0.1)
        model.torque("turn", on=b, value=model.parameter("b", 3.0))
    """,
    "a joint named like its body": """
        b = model.body("b", mass=1.0, inertia=0.1)
        model.revolute("b", model.ground.at(0, 0), b.at(1, 0))
    """,
    "a state named like a body": """
        b = model.body("b", mass=1.0, inertia=0.1)
        model.state("b", rate=1.0)
    """,
    "a joint of a body that is text": """
        b = model.body("b", mass=1.0, inertia=0.1)
        model.revolute("pin", model.ground.at(0, 0), "bar")
    """,
}


@pytest.mark.parametrize("what", MISTAKES)
def test_one_mistake_is_one_error(what: str) -> None:
    model = Model("w")
    names: dict[str, Any] = {"model": model}
    exec(dedent(MISTAKES[what]), names)
    body = names["b"]
    model.revolute("O", model.ground.at(0, 0), body.at(0, 0))
    model.torque("motor", on=body, value=1.0)
    model.scene("run", effects=["motor"], start={body.phi: 0, body.omega: 0})
    assert len(check_declaration(model).problems) == 1
