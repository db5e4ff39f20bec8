"""The command `linkwright check`."""

import json
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from linkwright.cli.application import app
from linkwright.cli.completion import MODELS_TO_START_FROM as KINDS
from linkwright.cli.new_model import text_of


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: str) -> Result:
    return CliRunner().invoke(app, ["check", *words])


@pytest.mark.parametrize("kind", KINDS)
def test_models_to_start_from_are_sound(kind: str, folder: Path) -> None:
    (folder / "machine.py").write_text(text_of(kind, "machine"))
    done = run()  # the only model of the folder
    assert (done.exit_code, done.stderr) == (0, "")
    assert "1 degree of freedom; none redundant\n" in done.stdout
    assert "the joints close at t = 0, within " in done.stdout
    assert "No scene uses" not in done.stdout
    assert "Next: linkwright simulate machine.py --scene " in done.stdout
    assert not (folder / "generated").exists()


def test_all_problems_are_lines_of_stderr(folder: Path) -> None:
    text = text_of("four-bar", "machine").replace(
        'effects=["gravity", "fric', 'effects=["gravty", "'
    )
    text = text.replace('"AB", 0.10', '"AB", -0.10')
    (folder / "machine.py").write_text(text)
    done = run("machine.py")
    assert (done.exit_code, done.stdout) == (2, "")
    lines = done.stderr.splitlines()
    assert all(line.startswith("error: ") for line in lines)
    assert any("did you mean 'gravity'?" in line for line in lines)
    assert any("parameter 'AB' is -0.1 m" in line for line in lines)


def test_a_parameter_that_opens_the_joints(folder: Path) -> None:
    (folder / "machine.py").write_text(text_of("four-bar", "machine"))
    done = run("machine.py", "--scene", "swing", "--set", "AD=3")
    assert done.exit_code == 2
    assert "error: scene 'swing': the joints do not close at the start" in done.stderr
    done = run("machine.py", "--scene", "swing", "--set", "AD=3", "--json")
    answer = json.loads(done.stdout)
    assert (answer["ok"], answer["status"], len(answer["problems"])) == (False, 2, 1)


def test_json_of_a_sound_model(folder: Path) -> None:
    (folder / "machine.py").write_text(text_of("pendulum", "machine"))
    answer = json.loads(run("machine.py", "--json").stdout)
    assert (answer["ok"], answer["model"], answer["unused"]) == (True, "machine", {})
    first, second = answer["scenes"]
    assert (first["scene"], first["degrees_of_freedom"]) == ("swing", 1)
    assert second["left_out"] == ["brake"]
    assert second["unused_parameters"] == ["damping"]
    assert first["gap"] < 1e-12


@pytest.mark.parametrize("words", [["nothing.py"], ["machine.py", "--scene", "swin"]])
def test_wrong_words(words: list[str], folder: Path) -> None:
    (folder / "machine.py").write_text(text_of("pendulum", "machine"))
    done = run(*words)
    assert done.exit_code == 2
    assert done.stderr.startswith("error: ")


def test_nothing_is_compiled(folder: Path) -> None:
    import subprocess

    (folder / "machine.py").write_text(text_of("pendulum", "machine"))
    code = (
        "import sys\nsys.argv = ['linkwright', 'check', 'machine.py']\n"
        "from linkwright.command_line import main\ntry:\n    main()\n"
        "except SystemExit as end:\n    print(end.code, 'numba' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == "0 False", done.stderr
