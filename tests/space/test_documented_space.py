"""The example of docs/how-to/space.md, run as it stands there, against a planar calculation."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.documented import run_cells


@pytest.fixture(scope="module")
def shown(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Everything that the page's code defines."""
    page = root / "docs" / "how-to" / "space.md"
    return run_cells(page, tmp_path_factory.mktemp("space"))


def test_the_slider_crank(shown: dict[str, Any]) -> None:
    r = shown["r"]
    y, z = r.point("pin")[:, 1:].T
    assert_allclose(r.q("slider.x"), np.sqrt(0.09 - y**2 - z**2), rtol=0.0, atol=1e-9)
    # no force does work: gravity acts on bodies that keep their height
    kinetic = 0.5e-4 * r.v("crank.omega_x") ** 2 + 1.0 * r.v("slider.vx") ** 2
    assert_allclose(kinetic, kinetic[0], rtol=1e-6)


def test_the_differential(shown: dict[str, Any]) -> None:
    """The mean of both wheels turns with all inertia, half their difference with theirs alone."""
    left, right = shown["speeds"]["left"], shown["speeds"]["right"]
    mean = 5.0 / (0.02 + 2 * 2e-3 + 1e-4 + 0.2 * 0.05**2)  # engine and grip
    apart = -1.0 / (2 * 2e-3 + 4 * 1e-4)  # the pinion turns by twice that against the cage
    times = shown["turned"].t
    assert_allclose((left + right) / 2, mean * times, rtol=1e-9, atol=1e-12)
    assert_allclose((left - right) / 2, apart * times, rtol=1e-9, atol=1e-12)
