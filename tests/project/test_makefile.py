"""The Makefile's own promises that need no new environment."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

make = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


def run(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["make", "--no-print-directory", *arguments],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )


@make
def test_help_is_the_default_and_lists_every_target(root: Path) -> None:
    text = (root / "Makefile").read_text(encoding="utf-8")
    phony = text.partition(".PHONY:")[2].partition("\n\n")[0].replace("\\", " ").split()
    shown = run(root).stdout
    assert shown == run(root, "help").stdout
    assert {line.split()[1] for line in shown.splitlines()} == set(phony)


@make
def test_an_old_python_is_refused_by_name(tmp_path: Path, root: Path) -> None:
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(root / name, tmp_path)
    old = tmp_path / "old-python"
    pretence = "import sys; sys.version_info = (3, 10); exec(sys.argv[1])"
    old.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{pretence}" "$2"\n', encoding="utf-8")
    old.chmod(0o755)
    done = run(tmp_path, "install", f"PYTHON={old}")
    assert done.returncode == 2
    assert "needs Python 3.11 or newer" in done.stderr
    assert not (tmp_path / ".venv").exists()
