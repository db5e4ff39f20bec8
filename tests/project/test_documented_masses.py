"""The examples of docs/how-to/masses-that-vary.md, run as they stand there."""

import re
from pathlib import Path
from typing import Any

import pytest


def test_masses_that_vary(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page compares each of its machines with a closed form."""
    text = (root / "docs" / "how-to" / "masses-that-vary.md").read_text(encoding="utf-8")
    cells = re.findall(r"```\{code-cell\} ipython3\n(.*?)```", text, re.DOTALL)
    names: dict[str, Any] = {"__name__": "documented_masses"}
    monkeypatch.chdir(tmp_path)
    for cell in cells:
        exec(re.sub(r"^run\.plot.*$", "", cell, flags=re.MULTILINE), names)
    assert sum(cell.count("assert ") for cell in cells) == 6
