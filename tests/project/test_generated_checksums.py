"""The checksums that stand for the texts of machines that are not checked in."""

import hashlib
import runpy
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="module")
def script(root: Path) -> dict[str, Any]:
    return runpy.run_path(str(root / "docs" / "make_checksums.py"))


def test_modules_that_are_checked_in_have_their_checksums(
    script: dict[str, Any], root: Path, project_files: tuple[Path, ...]
) -> None:
    listed = script["listed"]()
    kept = [p for p in project_files if p.parent == root / "generated" and "__" in p.stem[1:-2]]
    assert len(kept) > 30
    for path in kept:
        assert hashlib.sha256(path.read_bytes()).hexdigest() == listed[path.name], path.name


def test_each_text_of_a_model_is_listed(script: dict[str, Any], root: Path) -> None:
    listed = script["listed"]()
    ours = {name: digest for name, digest in listed.items() if name.startswith("pendulum__")}
    assert script["built"](root / "models" / "hard" / "pendulum.py", set(ours)) == ours
    assert any(name.endswith("__tangents.py") for name in ours)


@pytest.mark.parametrize(
    ("change", "status"),
    [
        (lambda text: text, 0),
        (lambda text: text.replace("0", "1", 1), 1),
        (lambda text: "", 1),
        (lambda text: text + f"{'0' * 64}  gone__scene.py\n", 1),
    ],
)
def test_a_check_finds_what_differs(
    script: dict[str, Any], root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    change: Callable[[str], str], status: int,
) -> None:  # fmt: skip
    model = tmp_path / "models" / "hard" / "jump_law.py"
    model.parent.mkdir(parents=True)
    shutil.copy(root / "models" / "hard" / "jump_law.py", model)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(script["main"].__globals__, "SUMS", tmp_path / "SHA256SUMS")
    monkeypatch.setattr(sys, "argv", ["make_checksums.py", str(model)])
    assert script["main"]() == 0
    listed = tmp_path / "SHA256SUMS"
    text = change(listed.read_text())
    listed.write_text(text)
    monkeypatch.setattr(sys, "argv", ["make_checksums.py", "--check", str(model)])
    assert script["main"]() == status
    assert listed.read_text() == text
