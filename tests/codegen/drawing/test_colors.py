"""The colours of pictures stand out from their ground, and from each other for everyone."""

from itertools import combinations

import numpy as np
import pytest

from codegen.drawing.styles import COUNT, DARK, LIGHT

Palette = dict[str, str]

# G. Machado, M. Oliveira, L. Fernandes: A physiologically-based model for simulation of color
# vision deficiency, IEEE TVCG 15 (2009), severity 1.
VISION = {
    "full": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
         [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
         [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
         [0.004733, 0.691367, 0.303900]]
    ),
}  # fmt: skip
RGB_TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)


def linear(color: str) -> np.ndarray:
    part = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


def contrast(one: str, other: str) -> float:
    low, high = sorted(float(RGB_TO_XYZ[1] @ linear(color)) for color in (one, other))
    return (high + 0.05) / (low + 0.05)


def lab(color: str, vision: str) -> np.ndarray:
    xyz = RGB_TO_XYZ @ np.clip(VISION[vision] @ linear(color), 0.0, 1.0)
    x, y, z = np.cbrt(np.maximum(xyz / (RGB_TO_XYZ @ np.ones(3)), 1e-4))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def numbered(palette: Palette, word: str) -> list[str]:
    return [palette[f"{word}-{k}"] for k in range(COUNT)]


@pytest.fixture(params=[LIGHT, DARK], ids=["light", "dark"], name="palette")
def _palette(request: pytest.FixtureRequest) -> Palette:
    return dict(request.param)


def test_texts_are_read_on_background_and_panel(palette: Palette) -> None:
    for text in ("ink", "muted", "accent", "good", "bad"):
        for ground in ("background", "panel"):
            assert contrast(palette[text], palette[ground]) >= 4.5


def test_lines_and_arrows_stand_out_from_the_background(palette: Palette) -> None:
    single = {"hatching", "joint", "spring", "damper", "actuator", "driver", "force", "reaction",
              "torque", "gravity", "contact", "trace", "cursor"}  # fmt: skip
    for color in (*numbered(palette, "line"), *(palette[name] for name in single)):
        assert contrast(color, palette["background"]) >= 3.0, color


def test_outlines_stand_out_from_their_insides(palette: Palette) -> None:
    for line, fill in zip(numbered(palette, "line"), numbered(palette, "fill"), strict=True):
        assert contrast(line, fill) >= 2.3, (line, fill)


@pytest.mark.parametrize("vision", VISION)
def test_lines_differ_for_every_vision(palette: Palette, vision: str) -> None:
    for one, other in combinations(numbered(palette, "line"), 2):
        distance = np.linalg.norm(lab(one, vision) - lab(other, vision))
        assert distance > 9.0, (one, other, distance)
