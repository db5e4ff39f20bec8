"""Words that a shell completes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from codegen.elements.registry import kinds_of_elements
from codegen.files.model_text import read_model_text
from codegen.reading.model_file import read_model
from linkwright.cli import completion
from linkwright.cli.application import app
from linkwright.cli.model_listing import models_in
from runtime.integrate.method import METHODS

MODEL = '''"""A stone.

Scenes
------
windy, calm
    With and without
    wind.
thrown
    Upwards.

high

    From a tower.

    It is high.

More text.

more
Sources
-------
Stones
    A book.
"""

raise SystemExit  # a model is read, and not executed
model.parameter("mass", 1.0)
stone = model.body("stone", 1.0)
model.force("wind", on=stone)
for name in ("windy", "thrown"):
    model.scene(name)
model.scene("calm")
model.scene("dark")
'''


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "stone.py").write_text(MODEL.replace("raise", "Model()\nraise"))
    (tmp_path / "plot.py").write_text("print()")
    (tmp_path / "parts").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def completed(line: str, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    words = line.split(" ")
    monkeypatch.setenv("_LINKWRIGHT_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    done = CliRunner().invoke(app, [], prog_name="linkwright")
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("linkwright sim", ["simulate"]),
        ("linkwright simulate st", ["stone.py"]),
        ("linkwright simulate pa", ["parts/"]),
        ("linkwright simulate stone.py --sc", ["--scene"]),
        ("linkwright simulate stone.py --scene ", ["calm", "dark", "windy", "thrown", "high"]),
        ("linkwright simulate --scene w", ["windy"]),
        ("linkwright simulate stone.py --set ", ["mass="]),
        ("linkwright simulate --t-end 1 stone.py --start stone.p", ["stone.phi="]),
        ("linkwright matters stone.py --quantity max:wi",
         ["max:wind.fx", "max:wind.fy", "max:wind.torque"]),
        ("linkwright sweep stone.py --over mass=0.06:", []),
        ("linkwright simulate stone.py --start a:", []),
        ("linkwright simulate stone.py --method r", ["radau5"]),
        ("linkwright elements revolute-",
         ["revolute-cylindrical", "revolute-in-space", "revolute-revolute",
          "revolute-revolute-in-space", "revolute-spherical", "revolute-translational",
          "revolute-translational-in-space"]),
        ("linkwright new x --kind four", ["four-bar"]),
        ("linkwright simulate stone.py --formulation ", ["cartesian", "reduced"]),
        ("linkwright simulate nothing.py --scene ", ["calm", "dark", "windy", "thrown", "high"]),
    ],
)  # fmt: skip
def test_completed(
    line: str, words: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert completed(line, monkeypatch) == words


def test_in_a_process_of_its_own(folder: Path) -> None:
    """Also that it loads nothing heavy: a shell waits for it."""
    code = (
        "import sys\nfrom linkwright.command_line import main\ntry:\n    main()\n"
        "finally:\n    print(*sorted({'numpy', 'sympy', 'numba'} & set(sys.modules)))"
    )
    line = {"COMP_WORDS": "linkwright simulate stone.py --scene d", "COMP_CWORD": "4"}
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **line, "_LINKWRIGHT_COMPLETE":
        "complete_bash"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stdout.split() == ["dark"], done.stderr


def test_the_library_is_read_as_it_runs(root: Path) -> None:
    """Scenes and parameters of every model of the library are in its text or its docstring."""
    texts = models_in(root / "models") + models_in(root / "models" / "space")
    assert len(texts) > 10
    for text in texts[::3]:
        model = read_model(text.path).model
        assert set(text.scenes) <= set(model.scenes)
        assert set(text.parameters) == set(model.parameters)


def test_scenes_have_their_lines(folder: Path) -> None:
    text = read_model_text(folder / "stone.py")
    assert text is not None
    assert text.summary == "A stone."
    assert text.scenes == {
        "calm": "With and without wind.",
        "dark": "",
        "windy": "With and without wind.",
        "thrown": "Upwards.",
        "high": "From a tower.",
    }


def test_a_section_behind_that_of_the_scenes_has_none(tmp_path: Path) -> None:
    file = tmp_path / "stone.py"
    file.write_text(MODEL.replace("More text.\n\nmore\n", ""))
    text = read_model_text(file)
    assert text is not None
    assert list(text.scenes) == ["calm", "dark", "windy", "thrown", "high"]


def test_kinds_are_those_that_are_registered() -> None:
    found = kinds_of_elements() | kinds_of_elements(space=True)
    library = (name for name, kind in found.items() if not kind.is_user_defined)
    there = {name.replace(" ", "-") for name in library}
    assert set(completion.kinds("")) == there


def test_methods_are_all_of_them() -> None:
    assert completion.methods("") == sorted(METHODS)
