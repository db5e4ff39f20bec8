"""The command `linkwright`: all commands of both programs, wherever one works."""

import subprocess
import sys
from pathlib import Path

from typer.main import get_command
from typer.testing import CliRunner

import codegen
from linkwright.cli.application import app

PROGRAM = Path(sys.executable).with_name("linkwright")
MODEL = """
from linkwright import Model

model = Model("stone")
stone = model.body("stone", mass=2.0, inertia=1.0)
model.force("wind", on=stone, fx=4.0)
model.scene("windy", effects=["wind"])
model.scene("calm")
"""


def run(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*words], cwd=folder, capture_output=True, text=True, check=False, timeout=600
    )


def test_all_names_offer_the_same_application(tmp_path: Path) -> None:
    commands = set(vars(get_command(app))["commands"])
    assert commands == {
        *("new", "list", "elements", "check", "draw", "build", "explain", "precompile", "methods"),
        *("equilibrium", "kinematics", "inverse", "inverse-dynamics", "simulate", "report"),
        *("accuracy", "matters", "sweep"),
    }
    pages = set()
    for name in ("codegen", "runtime", "linkwright"):
        done = run(sys.executable, "-m", name, "draw", "--help", folder=tmp_path)
        assert done.returncode == 0, done.stderr
        pages.add(" ".join(done.stdout.partition("[MODEL]")[2].split()))
    assert len(pages) == 1
    assert "" not in pages


def test_version(tmp_path: Path) -> None:
    for words in ((str(PROGRAM),), (sys.executable, "-m", "linkwright")):
        done = run(*words, "--version", folder=tmp_path)
        assert (done.returncode, done.stdout) == (0, f"linkwright {codegen.__version__}\n")


def test_files_of_the_users_stand_in_no_ones_way(tmp_path: Path) -> None:
    """Two scenes are compiled in processes of their own, which must not import these either."""
    for name in ("runtime", "codegen", "numpy", "typer", "generated"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong file')")
    (tmp_path / "stone.py").write_text(MODEL)
    for words in ((str(PROGRAM),), (sys.executable, "-m", "linkwright")):
        done = run(*words, "build", "stone.py", folder=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "stone, scene windy" in done.stdout
    answer = run(str(PROGRAM), "simulate", "stone.py", "--t-end", "1", folder=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert "stone.x     1 m\n" in answer.stdout


def test_wrong_input_ends_with_two(tmp_path: Path) -> None:
    done = run(str(PROGRAM), "simulate", "stoone.py", "--t-end", "1", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: There is no model 'stoone.py'")


def test_an_unknown_method_is_refused_before_anything_compiles() -> None:
    done = CliRunner().invoke(app, ["precompile", "dop85"])
    assert done.exit_code == 2
    assert "error: no such method: dop85; there are dop853" in done.stderr


def test_an_analysis_imports_no_compiler(root: Path) -> None:
    code = (
        "import sys\nsys.argv = ['linkwright', 'equilibrium', 'slider_crank', '--scene', "
        "'gas_equilibrium']\n"
        "from linkwright.command_line import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    print(end.code)\n"
        "print(sorted({'sympy', 'codegen.model', 'pandas', 'xarray'} & set(sys.modules)))"
    )
    done = run(sys.executable, "-c", code, folder=root)
    assert done.stdout.splitlines()[-2:] == ["0", "[]"], done.stderr
