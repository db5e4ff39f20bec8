"""The examples of docs/how-to/outputs.md, as written, against closed forms."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.documented import run_cells


@pytest.fixture(scope="module")
def documented(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Everything that the page's code defines."""
    page = root / "docs" / "how-to" / "outputs.md"
    return run_cells(page, tmp_path_factory.mktemp("outputs"))


def test_accelerations_and_reactions_are_in_global_axes(documented: dict[str, Any]) -> None:
    r = documented["r"]
    c, s = np.cos(r.q("coupler.phi")), np.sin(r.q("coupler.phi"))
    ax = r.a("coupler.x") - 2.5 * (r.a("coupler.phi") * s + r.v("coupler.phi") ** 2 * c)
    assert_allclose(r.point("tip", "ax"), ax, atol=1e-9)
    assert_allclose(r["bend"], r.a("rocker.phi"), rtol=1e-14)
    c, s = np.cos(r.q("crank.phi")), np.sin(r.q("crank.phi"))  # the axes of B are the crank's
    fx, fy = r.reaction("B", "fx"), r.reaction("B", "fy")
    assert_allclose(r.reaction("B", "global_fx"), c * fx - s * fy, atol=1e-9)


def test_counterweights_balance(documented: dict[str, Any]) -> None:
    """With none F = -m ẍ, at its largest 0.1 · 50² (1 + 1/4) N; with half some 60 % of it."""
    shaking = documented["shaking"]
    assert_allclose(shaking[0.0], 0.1 * 2500 * 1.25, rtol=1e-9)
    assert shaking[0.5] < 0.65 * shaking[0.0]
    assert shaking[0.5] < shaking[1.0]


def test_advantage_is_that_of_virtual_work(documented: dict[str, Any]) -> None:
    moved, rest = documented["moved"], documented["rest"]
    assert_allclose(moved["advantage"], 0.5 / np.tan(moved.q("first.phi")), rtol=1e-11)
    assert_allclose(rest["advantage"], 0.5 / np.tan(rest["first.phi"]), rtol=1e-8)
