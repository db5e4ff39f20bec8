"""Surroundings of another kind: no docstrings, an archive, few letters, long names, no /proc."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from codegen.errors import InputError
from runtime import Outcome, load
from runtime.results.dataset import require_dask

MODEL = """from linkwright import Model

model = Model("pendulum", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.scene("swing", ["gravity"], start={bob.phi: 0.5})
"""
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}


def said(root: Path, *words: str | Path, path: Path | None = None, **environment: str) -> str:
    """What a Python process writes to both streams."""
    surroundings = {**os.environ, "PYTHONPATH": str(path or root), **environment}
    done = subprocess.run(
        [sys.executable, *words], env=surroundings, cwd=(path or root).parent, check=False,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    return done.stdout.decode()


def test_without_docstrings_models_are_read_and_no_pages_are_written(
    root: Path, tmp_path: Path
) -> None:
    (tmp_path / "pendulum.py").write_text(MODEL)
    out = said(root, "-OO", "-m", "linkwright", "check", tmp_path / "pendulum.py")
    assert "one joint     bob (hinge)" in out
    out = said(root, "-OO", "-m", "linkwright", "methods", "--out", tmp_path / "methods")
    assert "python -OO takes away" in out


def test_an_archive_is_refused(root: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "linkwright.whl", "w") as archive:
        for file in (root / "codegen").rglob("*.py"):
            archive.write(file, file.relative_to(root))
    out = said(root, "-c", "import codegen.files.library_folders", path=tmp_path / "linkwright.whl")
    assert "imported from the archive" in out
    assert "pip install" in out


def test_letters_that_the_locale_lacks(root: Path, tmp_path: Path) -> None:
    out = said(root, "-m", "linkwright", "list", **ASCII)
    assert "\\u03c9" in out
    assert "Traceback" not in out
    (tmp_path / "mödel.py").write_text(MODEL)
    out = said(root, "-m", "linkwright", "check", tmp_path / "mödel.py", **ASCII)
    assert "PYTHONUTF8=1" in out
    assert "Traceback" not in out


@pytest.mark.parametrize("stem", ["m" * 250, "ü" * 120])
def test_a_model_file_of_a_long_name(tmp_path: Path, stem: str) -> None:
    path = tmp_path / f"{stem}.py"
    path.write_text(MODEL)
    machine = load(path, folder=tmp_path)
    assert load(path, "swing", folder=tmp_path).path == machine.path
    assert machine.simulate(0.1, method="radau5", progress=False).outcome is Outcome.OK
    assert machine.simulate(0.1, formulation="reduced", progress=False).outcome is Outcome.OK


def test_a_dask_that_does_not_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "dask.py").write_text("raise RuntimeError('process PID not found')")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "dask", raising=False)
    with pytest.raises(InputError, match=r"process PID not found\). Mount /proc"):
        require_dask()
