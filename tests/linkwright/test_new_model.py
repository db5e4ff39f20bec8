"""The models to start from, which `linkwright new` writes, and the listing of models."""

import ast
import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import linkwright as lw
from linkwright.cli.application import app
from linkwright.cli.completion import MODELS_TO_START_FROM as KINDS

WORDS = ("# A parameter", "# A guess", "# A scene", "frame of its body", "ffect", "bod", "oint")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    return tmp_path


def run(*words: str) -> Result:
    return CliRunner().invoke(app, [*words])


@pytest.mark.parametrize("kind", KINDS)
def test_a_template_runs_as_it_is_written(kind: str, folder: Path) -> None:
    done = run("new", "machine", "--kind", kind)
    assert (done.exit_code, done.stderr) == (0, "")
    path = folder / "machine.py"
    text = path.read_text(encoding="utf-8")
    assert "NAME" not in text
    assert all(word in text for word in WORDS)
    report = lw.build(path, compile=False)
    assert not [note for scene in report.scenes for note in scene.notes]
    m = lw.load(path)
    r = m.simulate(0.2)
    assert r.outcome == lw.Outcome.OK
    assert abs(r.v(m.coordinates[2].velocity)).max() > 0.1
    assert {"check", "draw", "simulate", "report"} <= {line.split()[1] for line in said(done)}
    for line in said(done):
        command = line.partition("  ")[0].split()
        assert command[0] == "linkwright"
        assert "machine.py" in command
        assert line.partition("  ")[2].strip().endswith("?")
        assert f"    {' '.join(command)}" in text


def said(done: Result) -> list[str]:
    """The lines that say what to type next."""
    head, *lines = done.stdout.splitlines()
    assert head.endswith("Next:")
    assert len(lines) >= 3
    return [line.strip() for line in lines]


def test_nothing_is_overwritten(folder: Path) -> None:
    (folder / "machine.py").write_text("mine")
    done = run("new", "machine.py")
    assert done.exit_code == 2
    assert "machine.py is there already" in done.stderr
    assert (folder / "machine.py").read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["2x"], "model name '2x' is no identifier"),
        (["a/b"], "model name 'a/b' is no identifier"),
        (["x", "--kind", "fourbar"], "of kind 'fourbar'; did you mean 'four-bar'?"),
    ],
)
def test_wrong_words(words: list[str], sentence: str, folder: Path) -> None:
    done = run("new", *words)
    assert done.exit_code == 2
    assert sentence in done.stderr
    assert not [*folder.iterdir()]


def test_list_of_a_folder(folder: Path) -> None:
    run("new", "swing", "--kind", "pendulum")
    (folder / "plot.py").write_text("print()")
    (folder / "broken.py").write_text("Model(")
    done = run("list", str(folder))
    assert done.exit_code == 0
    lines = [line.split() for line in done.stdout.splitlines()]
    assert [line[0] for line in lines[1:] if line] == ["swing.py", "swing", "free_swing"]
    assert lines[1][1:4] == ["swing:", "a", "pendulum,"]
    assert " ".join(lines[3][1:4]) == "The same without"


def test_list_as_json(folder: Path) -> None:
    run("new", "swing", "--kind", "pendulum")
    (model,) = json.loads(run("list", ".", "--json").stdout)["models"]
    assert (model["name"], model["path"]) == ("swing", "swing.py")
    assert [scene["name"] for scene in model["scenes"]] == ["swing", "free_swing"]


def test_list_has_this_folder_and_the_library(folder: Path) -> None:
    run("new", "swing", "--kind", "pendulum")
    done = run("list")
    assert done.stdout.startswith("this folder\n  swing.py ")
    assert "the library\n  coil_spring " in done.stdout
    assert "slider-crank compressor of Haug, Computer-Aided Kinematics" in " ".join(
        done.stdout.split()
    )


def test_list_of_no_folder(folder: Path) -> None:
    done = run("list", "nowhere")
    assert done.exit_code == 2
    assert done.stderr == "error: 'nowhere' is no folder; give the folder of some model files.\n"
    assert "linkwright new NAME" in run("list", ".").stderr


def test_templates_are_files_of_the_package(root: Path) -> None:
    files = {p.stem for p in (root / "linkwright" / "templates").glob("[!_]*.py")}
    assert files == {kind.replace("-", "_") for kind in KINDS}
    for path in (root / "linkwright" / "templates").glob("[!_]*.py"):
        assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
