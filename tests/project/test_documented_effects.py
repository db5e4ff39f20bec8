"""The examples of docs/explanation/effects.md and the law in pieces of README.md, as written."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from runtime import load
from tests.documented import run_cells


@pytest.fixture(scope="module")
def documented(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Everything that the page's code defines."""
    page = root / "docs" / "explanation" / "effects.md"
    return run_cells(page, tmp_path_factory.mktemp("effects"))


def test_ball_falls_with_drag(documented: dict[str, Any], tmp_path: Path) -> None:
    machine = load(documented["falling"], folder=tmp_path)
    run = machine.simulate(10.0, np.linspace(0, 10, 41), rtol=1e-10, atol=1e-10)
    terminal = np.sqrt(2 * 0.5 * 9.81 / (1.2 * 0.01))
    assert_allclose(run.v("ball.y"), -terminal * np.tanh(9.81 * run.t / terminal), atol=1e-7)


def test_wheel_coasts_to_rest(documented: dict[str, Any], tmp_path: Path) -> None:
    machine = load(documented["rolling"], folder=tmp_path)
    slowing = 0.02 * 4.0 * 9.81 * 0.2 / (0.08 + 4.0 * 0.2**2) * 0.2
    stop = 3.0 / slowing
    run = machine.simulate(0.9 * stop, np.linspace(0, 0.9 * stop, 31), rtol=1e-10, atol=1e-10)
    assert_allclose(run.v("wheel.x"), 3.0 - slowing * run.t, atol=1e-7)
    assert_allclose(run.q("wheel.phi"), -run.q("wheel.x") / 0.2, atol=1e-10)


def test_trapezoidal_profile_of_speed(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, section = (root / "README.md").read_text(encoding="utf-8").split("## A motion law in pieces")
    declared, run, *_ = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    Path("slide.py").write_text(declared, encoding="utf-8")
    names: dict[str, Any] = {}
    exec(run, names)
    result = names["r"]
    assert_allclose(result.q("slide.x"), [0.0625, 0.75, 1.4375, 1.5], atol=1e-12)
    assert_allclose(result.v("slide.x"), [0.5, 1.0, 0.5, 0.0], atol=1e-12)
    assert_allclose(result.reaction("feed", "fx"), [6.0, 0.0, -6.0, 0.0], atol=1e-9)


def test_strut_by_tables(documented: dict[str, Any], tmp_path: Path) -> None:
    """It comes to rest where the curve carries the weight: m g = 392.4 N."""
    machine = load(documented["strut"], folder=tmp_path)
    run = machine.simulate(20.0)
    assert not run.failed
    stretch = -1.0 * run.q("wheel.y")[-1]
    assert_allclose(documented["curve"].table(stretch), 40.0 * 9.81, rtol=1e-6)
    assert_allclose(machine.equilibrium().q("wheel.y")[-1], -stretch, rtol=1e-6)
