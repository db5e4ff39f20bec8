"""Joints that repeat each other: noted by a build, with what they are; drivers that do, refused."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from codegen import build
from codegen.generated_files.generated_file import SceneReport
from linkwright.cli.application import app
from tests.codegen.complaints import HEAD
from tests.codegen.workbench import write_model


def report_of(folder: Path, text: str, head: str = HEAD) -> SceneReport:
    path = write_model(folder, head + text)
    (scene,) = build(path, out=folder / "out", compile=False).scenes
    assert scene.path.is_file()
    return scene


def test_a_joint_declared_twice(tmp_path: Path) -> None:
    twice = "for n in 'AZ': model.revolute(n, model.ground.at(0, 0), a.at(1, 0))"
    scene = report_of(tmp_path, twice)
    (note,) = scene.notes
    assert "4 constraints on 6 coordinates, of which only 2 are independent" in note
    assert "redundant: Z.x (revolute), Z.y (revolute)." in note
    assert "Remove or relax 'Z'" in note
    assert scene.degrees_of_freedom == 4


def test_an_equation_stated_twice(tmp_path: Path) -> None:
    (note,) = report_of(tmp_path, "model.constraint('c', a.x - b.x, 2 * a.x - 2 * b.x)").notes
    assert "redundant: c.row1 (constraint)." in note


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_parallelogram_with_a_third_bar(tmp_path: Path, size: float) -> None:
    text = f"""
from codegen import Model
model, size = Model("m"), {size}
table = model.body("table", 1, 1)
for k in range(3):
    bar = model.body(f"bar{{k}}", 1, 1)
    model.revolute(f"foot{{k}}", model.ground.at(k * size, 0), bar.at(-size / 2, 0))
    model.revolute(f"head{{k}}", bar.at(size / 2, 0), table.at(k * size, 0))
model.scene("swing", start={{f"bar{{k}}.phi": 1.0 for k in range(3)}})
"""
    (note,) = report_of(tmp_path, text, head="").notes
    assert "12 constraints on 12 coordinates, of which only 11 are independent" in note
    assert "redundant: head2." in note
    assert "Remove or relax 'head2'" in note


def test_the_command_prints_the_note(tmp_path: Path) -> None:
    text = "for n in 'AZ': model.revolute(n, model.ground.at(0, 0), a.at(1, 0))"
    path = write_model(tmp_path, HEAD + text)
    answer = CliRunner().invoke(app, ["build", str(path), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 0, answer.output
    told = " ".join(answer.stdout.split())
    assert "note scene 'default': 4 constraints on 6 coordinates" in told


def test_independent_joints_are_not_mentioned(tmp_path: Path) -> None:
    text = "model.revolute('A', model.ground.at(0, 0), a.at(1, 0))"
    assert report_of(tmp_path, text).notes == ()
