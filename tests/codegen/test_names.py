"""Names and units come out of a model as they went in, or not at all."""

from pathlib import Path

import pytest

from codegen import InputError, build
from tests.codegen.complaints import HEAD, complaints
from tests.codegen.workbench import write_model

INJECTIONS = ["x; import os", "x\nimport os", 'x"""', "x'", "", " ", "1x", "class", "None", "a.b",
              "x#", "λ", "__import__", "_x", "x\\", "{x}", 7, None]  # fmt: skip


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
