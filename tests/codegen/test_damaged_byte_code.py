"""Byte code of our packages that is cut short is made anew, with a note."""

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

CODE = "import codegen.figures_and_html, codegen.reading.model_file, runtime; runtime.load"
LOADED_FIRST = ("codegen/__init__", "codegen/damaged_byte_code", "runtime/__init__")


@pytest.fixture(scope="module")
def caches(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of byte code, made by importing modules."""
    folder = tmp_path_factory.mktemp("byte_code")
    assert not _run(root, folder)
    return folder


def _run(root: Path, folder: Path) -> str:
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(folder)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    answer = subprocess.run(
        [sys.executable, "-c", CODE], cwd=root, env=environment, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    return answer.stderr


def _ours(root: Path, folder: Path) -> list[Path]:
    ours = folder.joinpath(*root.parts[1:])
    return sorted(path for name in ("codegen", "runtime") for path in (ours / name).rglob("*.pyc"))


def test_byte_code_that_is_cut_short_is_made_anew(root: Path, caches: Path) -> None:
    chance = random.Random(0)
    files = _ours(root, caches)
    assert len(files) > 10
    for path in files:
        content = path.read_bytes()
        path.write_bytes(content[: chance.randrange(16, len(content))])
    notes = _run(root, caches)
    assert notes.count("CacheWarning") == len(files)
    assert "damaged byte code (marshal data too short) is made anew" in notes
    assert not _run(root, caches)


def test_no_byte_code_is_kept_of_what_is_loaded_before_it_can_be_checked(
    root: Path, caches: Path
) -> None:
    ours = caches.joinpath(*root.parts[1:])
    names = {path.relative_to(ours).as_posix().split(".")[0] for path in _ours(root, caches)}
    assert names.isdisjoint(LOADED_FIRST)
