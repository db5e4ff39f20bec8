"""The examples of docs/how-to/motion-programs.md, as written."""

import re
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen.tables.motion_laws import SHAPES
from tests.documented import run_cells


@pytest.fixture(scope="module")
def page(root: Path) -> Path:
    return root / "docs" / "how-to" / "motion-programs.md"


@pytest.fixture(scope="module")
def documented(page: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Everything that the page's code defines."""
    return run_cells(page, tmp_path_factory.mktemp("programs"))


def test_follower_stays_on_its_cam(documented: dict[str, Any]) -> None:
    assert 0.0 < documented["force"].min() < documented["force"].max()
    undercut = next(text for text in documented["shown"] if "undercut" in str(text))
    assert re.match(r"the cam is undercut at its angle (31|48)\.", undercut)


def test_drawing_is_the_cams(documented: dict[str, Any]) -> None:
    points = documented["profile"].points(720)
    assert len(documented["outline"].vertices) == 720
    assert np.hypot(*points.T).min() == pytest.approx(0.03, rel=1e-5)
    assert documented["move"].length == pytest.approx(0.2 + 0.9 + 0.1 + 0.85)


def test_table_of_laws_is_true(page: Path, documented: dict[str, Any]) -> None:
    text = page.read_text(encoding="utf-8")
    rows = re.findall(r"^\| `\"(.+)\"` \| ([\d.]+) \| ([\d.]+) \|", text, re.MULTILINE)
    assert [name for name, *_ in rows] == [*SHAPES]
    at = np.linspace(1e-9, pi - 1e-9, 4001)
    for name, *told in rows:
        moves = [(180, 1, name), (180, 0, name)]
        program = documented["lw"].motion_program(moves, units=("deg", "m"))
        peaks = [program.values(at, order).max() * pi**order for order in (1, 2)]
        assert peaks == pytest.approx([*map(float, told)], abs=5.1e-4)
