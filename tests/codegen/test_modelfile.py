"""Model files and options that are wrong: said with file and line, status 2, nothing written."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from codegen.errors import ModelFileError
from codegen.files.library_folders import LIBRARY
from codegen.reading.model_file import execute_model_file
from linkwright.cli.application import app
from tests.codegen.complaints import HEAD, check, complaints
from tests.codegen.workbench import write_model


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--set", "kk=3"], ["model 'm' has no parameter 'kk'; did you mean 'k'?"]),
        (["--set", "k=nan"], ["parameter 'k' is nan; give a finite number"]),
        (["--set", "k=inf", "--set", "z=1"], ["parameter 'k' is inf", "no parameter 'z'"]),
        (["--set", "w=-1"], ["parameter 'w' is -1 kg, but must be positive"]),
        (["--set", "k=five"], ["--set k=five: write NAME=VALUE with a number"]),
        (["--set", "k"], ["--set k: write NAME=VALUE with a number"]),
        (["--scene", "swig"], ["model 'm' has no scene 'swig'; did you mean 'swing'?"]),
    ],
)
def test_options(tmp_path: Path, options: list[str], expected: list[str]) -> None:
    text = "w = model.parameter('w', 1.0, unit='kg')\nmodel.body('c', w, 1)\nmodel.scene('swing')\n"
    path = write_model(tmp_path, HEAD + text)
    answer = CliRunner().invoke(app, ["build", str(path), "--out", str(tmp_path / "out"), *options])
    assert answer.exit_code == 2
    check([line.removeprefix("error: ") for line in answer.stderr.splitlines()], expected)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x = (\n", r"machine\.py, line 5: the model file fails with SyntaxError: .*"),
        (
            "x = 1\ny = 1 / 0\n",
            r"machine\.py, line 6: the model file fails with ZeroDivisionError: division",
        ),
        (
            "import nowhere_to_be_found\n",
            r"machine\.py, line 5: .* ModuleNotFoundError: No module named 'nowh",
        ),
        ("raise SystemExit(3)\n", r"machine\.py, line 5: .* SystemExit: 3"),
        (
            "body = Model('m').body('a')\nif 1 < body.x < 2: pass\n",
            r"machine\.py, line 6: .*\(TypeError: .*truth",
        ),
        ("x = 1\n", r"machine\.py declares no model; assign the one to build to the name 'model'"),
        (
            "one = Model('one')\ntwo = Model('two')\n",
            r"machine\.py declares several models \('one', 'two'\)",
        ),
        ("model = Model('m')\n", "model 'm' has no body; declare one with model.body"),
    ],
)
def test_model_file(tmp_path: Path, text: str, expected: str) -> None:
    (found,) = complaints(tmp_path, text, head="")
    assert re.search(expected, found), found


def test_generated_module_is_not_executed_as_a_model_file() -> None:
    path = LIBRARY / "generated" / "pendulum__bar.py"
    with pytest.raises(ModelFileError, match=r"pendulum__bar\.py is a module that was generated"):
        execute_model_file(path)


def test_model_file_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "pendulum.py").write_text("")
    for name, hint in (
        ("models/pendulumm.py", "Models there: pendulum."),
        ("slider_krank", "Models there: slider_crank, "),
    ):
        answer = CliRunner().invoke(app, ["build", name])
        assert answer.exit_code == 2
        assert f"There is no model {name!r}" in answer.stderr
        assert hint in answer.stderr
        assert not (tmp_path / "generated").exists()


@pytest.mark.parametrize("path", ["/", "x" * 300 + ".py", "x" * 300, "a\nb.py"])
@pytest.mark.parametrize("words", [["build"], ["elements", "gear", "--model"]])
def test_path_of_no_file(words: list[str], path: str) -> None:
    answer = CliRunner().invoke(app, [*words, path])
    assert answer.exit_code == 2
    assert answer.stderr.startswith("error: ")
    assert len(answer.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "text", ["model.pin('p', a, b)", "model.torque('T', a, 1, 2, 3, 4, 5)", "a.psi"]
)
def test_wrong_call_has_its_line(tmp_path: Path, text: str) -> None:
    path = write_model(tmp_path, HEAD + text)
    line = path.read_text().splitlines().index(text) + 1
    answer = CliRunner().invoke(app, ["build", str(path)])
    assert answer.exit_code == 2
    assert f"{path.name}, line {line}: " in answer.stderr


def test_explain_answers_errors_alike(tmp_path: Path) -> None:
    path = write_model(tmp_path, HEAD + "model.torque('k', on=a, value=1)")
    answer = CliRunner().invoke(app, ["explain", str(path), "--json"])
    assert answer.exit_code == 2
    (problem,) = json.loads(answer.stdout)["problems"]
    assert problem.startswith("effect 'k': the name is already")
    assert answer.stderr == f"error: {problem}\n"
