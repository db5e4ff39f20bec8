"""A generated module holds numbers, names and quoted text, whatever a modeller gives."""

import ast
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
import xarray as xr

from codegen import Effect, Model, build
from codegen.driver import translate
from codegen.emit.line_wrapping import checked, identifier, literal, prose
from codegen.emit.module import Origin, module_text
from codegen.errors import GeneratedFileError, LinkwrightError
from codegen.generated_files.generated_file import Clock
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.workbench import write_model

CODE = "raise SystemExit"


class Spoken(float):
    """A number whose texts are code."""

    def __repr__(self) -> str:
        return f"0.0\n{CODE}\n"

    __str__ = __repr__


@pytest.mark.parametrize(
    "value",
    [1, -2.5, "plain", 'a"b\\c', "a\nb\r\tc", "\ud800", "\x00\x85\u2028", "Φ é", (1, "a", (2.0,))],
)
def test_what_is_written_is_read_again(value: Any) -> None:
    text = literal(value)
    assert ast.literal_eval(text) == value
    assert text.isprintable()


def test_numbers_are_written_as_pythons_own() -> None:
    assert literal(np.float64(0.1)) == "0.1"
    assert literal(Spoken(0.5)) == "0.5"


@pytest.mark.parametrize("value", [math.nan, math.inf, 1j, object(), {1: 2}, sympy.Integer(1), {1}])
def test_nothing_else_is_written(value: Any) -> None:
    with pytest.raises(GeneratedFileError, match="numbers, names and text"):
        literal(value)


@pytest.mark.parametrize("name", ["a b", "a\nb", "", "é", "1a", "a;b", "a\n"])
def test_a_name_is_an_identifier(name: str) -> None:
    with pytest.raises(GeneratedFileError):
        identifier(name)


def test_a_comment_stays_one() -> None:
    assert prose(f'a\n{CODE}"""\\') == f"a\\n{CODE}'''/"
    with pytest.raises(GeneratedFileError, match="cannot be a line"):
        checked(["x = 1", f"# a\n{CODE}"])


def text_of(model: Model, scene: Any = None) -> str:
    """The text of the first scene's module."""
    (chosen, *_) = valid_scenes(model, scene)
    _, lowered, _ = translate(model, chosen, Clock({}, lambda _: None, ""))
    origin = Origin("test", (), "0", f"build(m, scene={chosen.expression or chosen.name})")
    return module_text(lowered, origin)


def bead() -> Model:
    model = Model("bead", gravity=(0, -9.81))
    model.parameter("c", 0.5)
    ball = model.body("ball", mass=1.0, inertia=1.0)
    model.torque("drag", on=ball, value=-ball.omega)
    model.scene("fall", effects=["gravity", "drag"])
    return model


@pytest.mark.parametrize("number", [xr.DataArray(2.0), np.array(2.0), Spoken(2.0), np.float32(2.0)])
def test_a_value_given_to_with_is_written_as_it_is_read(number: Any) -> None:
    model = bead()
    scene = model.scenes["fall"].with_(start={"ball.x": number})
    text = text_of(model, scene)
    ast.parse(text)
    assert CODE not in text
    assert "with_(start={'ball.x': 2.0})" in text


class Reports(Effect):
    """A force that reports."""

    kind = "reporting force"

    def __init__(self, ball: Any, rows: Any) -> None:
        self.name, self.ball, self.rows = "mine", ball, rows

    @property
    def bodies(self) -> Any:
        return (self.ball,)

    def forces(self, bodies: Any) -> Any:
        return {self.ball.x: sympy.S.One}

    def reported(self, bodies: Any) -> Any:
        return self.rows


@pytest.mark.parametrize(("part", "unit"), [(f"f\n{CODE}", "N"), ("f", f"N\n{CODE}"), ("f", '"""')])
def test_components_and_units_of_an_own_element_are_words(part: str, unit: str) -> None:
    model = bead()
    model.add(Reports(model.bodies["ball"], ((part, unit, sympy.S.One),)))
    with pytest.raises(LinkwrightError, match=r"'mine': what its reported\(\) returns is"):
        valid_scenes(model, None)


class Named(Reports):
    """A force whose name changes each time."""

    kind = "renamed force"

    def __init__(self, ball: Any) -> None:
        self.asked, self.ball, self.rows = 0, ball, ()

    @property
    def name(self) -> str:  # type: ignore[override]
        self.asked += 1
        return "mine" if self.asked < 3 else f"mine\n{CODE}"


def test_a_name_that_is_a_property_brings_no_lines() -> None:
    model = bead()
    model.add(Named(model.bodies["ball"]))
    model.scene("pushed", effects=["mine"])
    try:
        text = text_of(model, "pushed")
    except LinkwrightError:
        return
    assert not [line for line in text.splitlines() if line.startswith("raise")]


def test_the_path_of_a_model_file_brings_no_lines(tmp_path: Path) -> None:
    folder = tmp_path / f"a\n{CODE}\n"
    folder.mkdir()
    path = write_model(folder, 'model = Model("m")\nmodel.body("a", mass=1.0, inertia=1.0)\n')
    (report,) = build(path, out=tmp_path / "out", compile=False).scenes
    tree = ast.parse(Path(report.path).read_text())
    assert not [node for node in tree.body if isinstance(node, ast.Raise)]
