"""The examples of docs/how-to/assembly-modes.md, as written, against independent solutions."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.documented import run_cells
from tests.runtime import linkages


@pytest.fixture(scope="module")
def documented(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Everything that the page's code defines."""
    page = root / "docs" / "how-to" / "assembly-modes.md"
    return run_cells(page, tmp_path_factory.mktemp("modes"))


def test_linkages_are_those_with_known_modes(documented: dict[str, Any]) -> None:
    triad = ["crank", "coupler", "rocker", "link"]
    wings = ["wing_2", "wing_3", "wing_4", "bar_EH", "bar_GJ", "bar_FK"]
    pivot, second = -0.1 + 1.6j, -0.3 + 0.2j + 0.4 * np.exp(0.7j)
    for modes, names, true in (
        ("six", triad, linkages.triad_modes(0j, 2.2, pivot + 0.5 * np.exp(0.26854j))),
        ("seven", triad, linkages.triad_modes(second, 2.2, pivot + 0.5)),
        ("eight", wings, linkages.butterfly_modes(0.6)),
    ):
        found = [[mode[f"{name}.phi"] for name in names] for mode in documented[modes]]
        assert linkages.disagreement(found, true) < 1e-8


def test_double_butterfly_has_fourteen(documented: dict[str, Any]) -> None:
    assert [len(documented[name]) for name in ("six", "seven", "eight")] == [6, 6, 14]
