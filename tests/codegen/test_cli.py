"""The command line: what goes to stdout, what to stderr, and the exit status."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

import codegen.driver
from linkwright.cli.application import app
from tests.codegen.workbench import write_model

MODEL = """
print("hello from the model file")
model = Model("pendulum", gravity=(0, -9.81))
m = model.parameter("m", 2.0, unit="kg")
bob = model.body("bob", mass=m, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.torque("friction", on=bob, value=-0.1 * bob.omega)
model.scene("swing", ["gravity"])
"""
Run = Callable[..., Result]


@pytest.fixture
def model(tmp_path: Path) -> Path:
    return write_model(tmp_path / "models", MODEL, "clock")


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """The command line in this process, without the compilation."""
    monkeypatch.setattr(codegen.driver, "compile_modules", lambda paths: [0.0] * len(paths))
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(app, [str(a) for a in arguments])


def names(answer: Result, key: str = "stale") -> list[str]:
    """Names of the files in the JSON object of a build."""
    found: Any = json.loads(answer.stdout)[key]
    return [Path(one["path"] if key == "scenes" else one).name for one in found]


def test_build_says_what_it_did(model: Path, run: Run) -> None:
    first = run("build", model)
    assert first.exit_code == 0
    for words in (
        *("pendulum, scene swing: written", "3 coordinates, 2 constraints, 1 degree of freedom"),
        *("effects       gravity", "left out      friction", "accelerations ", "seconds "),
    ):
        assert words in first.stdout
    assert "pendulum, scene swing: unchanged, nothing written" in run("build", model).stdout


def test_json_is_one_object_alone_on_stdout(model: Path, tmp_path: Path, root: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "codegen", "build", model, "--out", tmp_path / "g", "--json"],
        env={**os.environ, "PYTHONPATH": str(root)}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    (line,) = done.stdout.splitlines()
    answer = json.loads(line)
    assert set(answer) == {"scenes", "stale"}
    (scene,) = answer["scenes"]
    assert (scene["model"], scene["scene"], scene["changed"]) == ("pendulum", "swing", True)
    assert Path(scene["path"]).is_file()
    assert scene["operations"]["accelerations"] > 0
    assert "hello from the model file" in done.stderr
    assert list((tmp_path / "g" / "__pycache__").glob("clock__swing.*.lwo"))


def test_check(model: Path, run: Run, tmp_path: Path) -> None:
    stale = run("build", model, "--check")
    assert stale.exit_code == 1
    assert "clock__swing.py is missing or out of date" in stale.stderr
    assert not (tmp_path / "generated").exists()
    assert run("build", model).exit_code == 0
    fresh = run("build", model, "--check")
    assert (fresh.exit_code, fresh.stderr) == (0, "hello from the model file\n")
    assert "checked" in fresh.stdout


def test_several_models_and_all_that_is_wrong_with_them(
    model: Path, run: Run, tmp_path: Path
) -> None:
    other, missing, heavy = (tmp_path / f"{name}.py" for name in ("other", "missing", "heavy"))
    other.write_text(model.read_text())
    heavy.write_text(model.read_text().replace("mass=m", "mass=-1.0"))
    answer = run("build", other, missing, heavy, model, "--check")
    assert answer.exit_code == 2
    assert answer.stdout.count("pendulum, scene swing: checked") == 2
    said = answer.stderr.replace("\n", "")
    for words in (f"run: linkwright build {other}", f"run: linkwright build {model}",
                  f"error: {heavy}: ", str(missing)):  # fmt: skip
        assert words in said
    built = run("build", other, model, "--json")
    assert names(built, "scenes") == ["other__swing.py", "clock__swing.py"]
    assert run("build", other, model, "--check").exit_code == 0
    other.write_text(model.read_text() + "# edited\n")
    answer = run("build", other, model, "--check", "--json")
    assert (answer.exit_code, names(answer)) == (1, ["other__swing.py"])


def test_set_and_out(model: Path, run: Run, tmp_path: Path) -> None:
    done = run("build", model, "--set", "m=7.5", "--out", tmp_path / "here", "--json")
    assert done.exit_code == 0
    (path,) = (tmp_path / "here").glob("*.py")
    assert names(done, "scenes") == [path.name]
    assert '("m", 7.5, "kg", "positive")' in path.read_text()
    answer = run("build", model, "--out", path / "below")
    assert (answer.exit_code, answer.stdout) == (2, "")
    assert "error: cannot write" in answer.stderr
    assert "--out" in answer.stderr


def test_explain_adds_up_to_what_is_built(run: Run) -> None:
    ledgers = json.loads(run("explain", "slider_crank", "--json").stdout)["scenes"]
    assert len(ledgers) == 9
    totals = {ledger["scene"]: ledger["totals"] for ledger in ledgers}
    built = run("build", "slider_crank", "--scene", "compressor", "--out", "g", "--json")
    assert json.loads(built.stdout)["scenes"][0]["operations"] == totals["compressor"]
    with_gas, without = totals["inverse_dynamics"], totals["inverse_dynamics_without_gas"]
    assert without["applied_forces"] == 0 < with_gas["applied_forces"]
    assert without["accelerations"] < with_gas["accelerations"]
    assert without["correction"] == with_gas["correction"]
    assert "switching" not in without


def test_explain_shows_what_acts_and_what_does_not(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "140")
    answer = run("explain", "slider_crank", "--scene", "inverse_dynamics", "--no-measure")
    assert answer.exit_code == 0
    rows = {line.split()[1]: line for line in answer.stdout.splitlines() if line.startswith("│")}
    assert {"A", "B", "C", "gas", "crank_drive", "factorization", "total"} <= set(rows)
    assert "│ in  │ force; named by the scene" in rows["gas"]
    assert "│ out │ torque; the scene does not name it" in rows["motor"]
