"""What the kernels of machines in space cost, and which of their constraints follow from others."""

from collections.abc import Callable
from pathlib import Path

import pytest

from codegen import Model
from codegen.driver import build
from tests.space.machines import bricard, heavy_top, slider_crank

MOST = {
    "heavy_top": (heavy_top, 175, 360),
    "slider_crank_2": (lambda: slider_crank(False), 460, 730),
    "slider_crank_1": (lambda: slider_crank(True), 1030, 2000),
    "bricard": (bricard, 4100, 7900),
}
"""Machine → the most operations of `accelerations`, with all multipliers, and of `correction`."""


@pytest.mark.parametrize("name", MOST)
def test_operations(name: str, tmp_path: Path) -> None:
    declare, accelerations, correction = MOST[name]
    (scene,) = build(declare(), out=tmp_path, compile=False).scenes
    assert scene.operations["accelerations"] <= accelerations
    assert scene.operations["correction"] <= correction


@pytest.mark.parametrize(
    ("declare", "freedom"), [(heavy_top, 3), (lambda: slider_crank(True), 1), (bricard, 1)]
)
def test_freedom_and_redundancy(declare: Callable[[], Model], freedom: int, tmp_path: Path) -> None:
    (scene,) = build(declare(), out=tmp_path, compile=False).scenes
    assert scene.degrees_of_freedom == freedom
    found = [note for note in scene.notes if "redundant: J6.g (revolute in space)" in note]
    assert bool(found) is (declare is bricard)
