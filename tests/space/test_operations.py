"""What the kernels of machines in space cost, and which of their constraints follow from others."""

from collections.abc import Callable
from pathlib import Path

import pytest

from codegen import Model
from codegen.derive.equations import derive
from codegen.driver import build
from codegen.emit.module import LONGEST_KERNEL
from codegen.lower.kernels.accelerations import FAR, inverse_mass_ratio
from codegen.lower.lowered_scene import outline
from models.space.bricard import bricard
from models.space.heavy_top import heavy_top
from tests.space.machines import robot_arm, slider_crank

MOST = {
    "heavy_top": (heavy_top, 175, 315),
    "slider_crank_2": (lambda: slider_crank(False), 460, 730),
    "slider_crank_1": (lambda: slider_crank(True), 1030, 1740),
    "bricard": (bricard, 4100, 6100),
    "robot_arm": (robot_arm, 5900, 7100),
}
"""Machine → the most operations of `accelerations`, with all multipliers, and of `correction`."""


@pytest.mark.parametrize("name", MOST)
def test_operations(name: str, tmp_path: Path) -> None:
    declare, accelerations, correction = MOST[name]
    (scene,) = build(declare(), out=tmp_path, compile=False).scenes
    assert scene.operations["accelerations"] <= accelerations
    assert scene.operations["correction"] <= correction


@pytest.mark.parametrize(
    ("declare", "freedom"),
    [(heavy_top, 3), (lambda: slider_crank(True), 1), (bricard, 1), (robot_arm, 6)],
)
def test_freedom_and_redundancy(declare: Callable[[], Model], freedom: int, tmp_path: Path) -> None:
    (scene,) = build(declare(), out=tmp_path, compile=False).scenes
    assert scene.degrees_of_freedom == freedom
    found = [note for note in scene.notes if "redundant: J6.g (revolute in space)" in note]
    assert bool(found) is (declare is bricard)


def test_bars_are_alike_however_their_axes_lie() -> None:
    def ratio(model: Model) -> float:
        return inverse_mass_ratio(outline(derive(model, model.scenes["fall"])).scene)

    assert ratio(bricard()) < 100.0
    light = Model("light", space=True)
    bars = [light.body(name, 1.0, (j, j, j)) for name, j in (("a", 1.0), ("b", 1e-6))]
    light.revolute("J", *bars, at=(0.5, 0, 0), axis=(0.6, 0.8, 0))
    light.scene("fall")
    assert ratio(light) > FAR


def test_bricards_linkage_is_written_out(tmp_path: Path) -> None:
    (scene,) = build(bricard(), out=tmp_path, compile=False).scenes
    assert 3000 < scene.operations["correction"] < LONGEST_KERNEL
    text = scene.text.partition("def correction(")[2].partition("\ndef ")[0]
    assert text
    assert "for " not in text.partition('"""\n')[2]
