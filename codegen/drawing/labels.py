"""Labels, dimensions and scales in a figure, placed so that they do not overlap."""

from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.drawing.colors import Palette
from codegen.drawing.force_arrows import Reactions
from codegen.drawing.label_placement import Label, place_labels, samples
from codegen.drawing.label_texts import NUMBER_SIZE, engineering, label_texts
from codegen.drawing.picture import Picture
from codegen.drawing.polygons import FloatArray
from codegen.drawing.signs import Dimension

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SAMPLE = 3.0  # layout: distance of the samples of lines that names avoid, in points
Box = tuple[FloatArray, tuple[float, float]]  # centre and size of a text, in points


def draw_labels(
    axes: "Axes", picture: Picture, lines: list[FloatArray], boxes: list[Box], colors: Palette,
    reactions: Reactions | None = None, values: bool = False,
) -> None:  # fmt: skip
    """Write the names of bodies, joints, drivers and forces beside them.

    Parameters
    ----------
    lines
        All lines of the picture in the global frame, m, which names avoid.
    boxes
        Texts that stand already.
    values
        Whether forces have their sizes behind their names.
    """
    wanted = label_texts(picture, colors, reactions, values)
    if not wanted:
        return
    points = 72.0 / axes.figure.dpi

    def to_points(at: FloatArray) -> FloatArray:
        return np.asarray(axes.transData.transform(np.atleast_2d(at))) * points

    labels, texts = [], []
    for text, anchors, room, style in wanted:
        artist = axes.text(0, 0, text, ha="center", va="center", zorder=8, **style)
        extent = artist.get_window_extent()
        size = extent.width * points, extent.height * points
        distance = room * float(np.hypot(*(to_points(np.array([1.0, 0.0])) - to_points(
            np.array([0.0, 0.0])))[0]))  # fmt: skip
        labels.append(Label(to_points(anchors), size, distance + 2.0))
        texts.append(artist)
    inside = axes.get_window_extent()
    bounds = (
        points * inside.x0, points * inside.y0, points * inside.x1, points * inside.y1
    )  # fmt: skip
    obstacles = [samples([to_points(line) for line in lines], SAMPLE)]
    obstacles += [_filled(box) for box in boxes]
    placed_at = place_labels(labels, np.concatenate(obstacles), bounds)
    back = axes.transData.inverted()
    for artist, spot in zip(texts, placed_at, strict=True):
        artist.set_position(tuple(back.transform(spot.center / points)))
        if spot.is_far:
            ends = np.array([spot.center, spot.anchor])
            axes.plot(*back.transform(ends / points).T, color=artist.get_color(), linewidth=0.5,
                      alpha=0.6, zorder=7)  # fmt: skip
        artist.set_bbox({"facecolor": colors.background, "alpha": 0.72, "edgecolor": "none",
                         "boxstyle": "round,pad=0.08"})  # fmt: skip


def _filled(box: Box) -> FloatArray:
    """Samples all over a text, so that no name covers it."""
    center, size = box
    x, y = (np.arange(-s / 2, s / 2 + 1, 2.0) for s in size)
    return np.asarray(center + np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))


def draw_dimensions(axes: "Axes", measured: list[Dimension], colors: Palette) -> list[Box]:
    """Write the distances along dimension lines, readable from below and from the right."""
    boxes = []
    for _, middle, angle, distance in measured:
        degrees = (np.degrees(angle) + 90.0) % 180.0 - 90.0
        text = axes.text(
            float(middle[0]), float(middle[1]), f"{distance:.4g}",
            ha="center", va="center", rotation=degrees, zorder=8,
            fontsize=NUMBER_SIZE, color=colors.ink,
            bbox={"facecolor": colors.background, "edgecolor": "none", "pad": 0.6},
        )  # fmt: skip
        boxes.append(_box(axes, text))
    return boxes


def draw_scale(axes: "Axes", scale: float, size: float, colors: Palette) -> list[Box]:
    """The scale of the forces, m/N: a bar in the lower right corner for a round force."""
    exact = 0.2 * size / scale
    power = 10.0 ** np.floor(np.log10(exact))
    value = power * max(m for m in (1, 2, 5) if m * power <= exact * (1 + 1e-9))
    right, bottom = axes.get_xlim()[1], axes.get_ylim()[0]
    x = np.array([right - 0.03 * size - value * scale, right - 0.03 * size])
    y = bottom + 0.03 * size
    axes.plot(x, [y, y], "|-", color=colors.force, linewidth=1.4, markersize=6, zorder=8,
              solid_capstyle="butt")  # fmt: skip
    text = axes.text(x.mean(), y + 0.015 * size, engineering(value, "N"), ha="center", va="bottom",
                     fontsize=NUMBER_SIZE, color=colors.force, zorder=8)  # fmt: skip
    return [_box(axes, text)]


def _box(axes: "Axes", text: Any) -> Box:
    points = 72.0 / axes.figure.dpi
    extent = text.get_window_extent()
    center = np.array([(extent.x0 + extent.x1) / 2, (extent.y0 + extent.y1) / 2]) * points
    return center, (extent.width * points, extent.height * points)
