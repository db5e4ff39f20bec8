"""A picture as a figure of Matplotlib, which is loaded when a figure is drawn."""

from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.drawing.colors import LIGHT, Palette
from codegen.drawing.force_arrows import Reactions, force_scale, force_strokes
from codegen.drawing.labels import draw_dimensions, draw_labels, draw_scale
from codegen.drawing.moving_strokes import moving_strokes
from codegen.drawing.picture import Picture
from codegen.drawing.place_shifts import place_shifts, shifted
from codegen.drawing.polygons import FloatArray, placed
from codegen.drawing.rigid_strokes import rigid_strokes
from codegen.drawing.signs import (
    dimension_lines,
    driver_strokes,
    frame_strokes,
    trace_strokes,
)
from codegen.drawing.stroke_styles import Painted, extent, painted
from codegen.drawing.strokes import Stroke
from codegen.figures_and_html import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDEST, TALLEST, LEAST = 7.2, 5.6, 2.6  # layout: sizes of a figure, in inches
MARGINS = (0.75, 0.8)  # layout: room for ticks and titles, in inches
FLATTEST, HIGHEST = 3.2, 1.8  # layout: width over height, and height over width, of the axes
HIGHEST_WITH_FORCES = 0.9  # layout: height over width of axes with texts at forces
BORDER = 0.07  # layout: room round a mechanism, in typical lengths


def figure(
    picture: Picture,
    dimensions: bool = False,
    forces: bool = False,
    axes: "Axes | None" = None,
    *,
    frames: bool = False,
    names: bool = True,
    reactions: Reactions | None = None,
    motion: FloatArray | None = None,
    colors: Palette = LIGHT,
) -> "Figure":
    """Draw a picture.

    Parameters
    ----------
    picture
        With outlines of all bodies: see `outlines.complete_picture`.
    dimensions
        Distances between the places of each body, in m, to four digits.
    forces
        Arrows to scale, with the scale and values; otherwise arrows of one length say where forces
        act, and which way.
    axes
        Where to draw; by default a figure of its own.
    frames
        The axes x' and y' of bodies, and their centres of mass.
    names
        Names of bodies, joints, drivers and forces.
    reactions
        Joint → fx, fy (N) and torque (N m) that act on its second body, in the joint's axes;
        those of drivers as well.
    motion
        Poses of a motion, shape (instants, bodies, 3): guides are as long as it needs.
    colors
        Those of a light or of a dark ground.

    Returns
    -------
    A figure of Matplotlib; places of a joint that do not coincide are joined by a dashed line that
    says how far they are apart.

    Raises
    ------
    InputError
        If Matplotlib is not installed.
    """
    scale = force_scale(picture, reactions) if forces else None
    artist = PictureArtist(picture, motion, colors)
    artist.signs = (
        *driver_strokes(picture),
        *force_strokes(picture, scale, reactions if forces else None),
        *(frame_strokes(picture) if frames else ()),
        *(trace_strokes(picture, motion) if motion is not None else ()),
    )
    measured = dimension_lines(picture) if dimensions else []
    artist.signs += tuple(stroke for line in measured for stroke in line.strokes)
    low, high = artist.bounds(picture)
    if scale is not None:
        low, high = _widened(low, high)
    if axes is None:
        axes = new_figure("picture", *inches(high - low), facecolor=colors.background).add_subplot()
    prepare_axes(axes, low, high, colors)
    axes.set_title(picture.title, color=colors.ink, fontsize=10.5)
    artist.add_to(axes, picture)
    root: Any = axes.figure
    while not hasattr(root, "draw_without_rendering"):  # of axes in a part of a figure
        root = root.figure
    root.draw_without_rendering()
    lines = artist.global_lines(picture)
    boxes = draw_dimensions(axes, measured, colors)
    if scale is not None:
        boxes += draw_scale(axes, scale, picture.size, colors)
    if names:
        draw_labels(axes, picture, lines, boxes, colors, reactions if forces else None, forces)
    drawn: Figure = root
    return drawn


def _widened(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds with room beside a tall machine, m: texts at forces are long."""
    more = np.array([max((high - low)[1] / HIGHEST_WITH_FORCES - (high - low)[0], 0.0) / 2, 0.0])
    return low - more, high + more


def inches(span: FloatArray) -> tuple[float, float]:
    """Width and height of a figure whose axes have these proportions."""
    room = np.array([WIDEST - MARGINS[0], TALLEST - MARGINS[1]])
    inner = span * float(np.min(room / span))
    width, height = np.maximum(inner + MARGINS, LEAST)
    return float(width), float(height)


def prepare_axes(axes: "Axes", low: FloatArray, high: FloatArray, colors: Palette) -> None:
    """Equal axes with units, their edges pale."""
    spans = high - low
    axes.set_facecolor(colors.background)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x, m", color=colors.muted, fontsize=8.5)
    axes.set_ylabel("y, m", color=colors.muted, fontsize=8.5)
    axes.tick_params(colors=colors.muted, labelsize=8, length=3, width=0.6)
    axes.locator_params("x", nbins=max(2, round(7 * spans[0] / spans.max())))
    axes.locator_params("y", nbins=max(2, round(7 * spans[1] / spans.max())))
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(colors.grid)


class PictureArtist:
    """The strokes of a picture as one collection, which follows poses.

    Attributes
    ----------
    signs
        Strokes in the global frame, or in those of bodies, that are drawn besides.
    strength
        How strong the colours are, from 0, that of the background, to 1.
    gaps
        Whether gaps of joints that are not closed are drawn.
    """

    def __init__(
        self, picture: Picture, motion: FloatArray | None = None, colors: Palette = LIGHT,
        gaps: bool = True,
    ) -> None:  # fmt: skip
        self.gaps = gaps
        self.first, self.motion = picture, motion
        self.rigid = rigid_strokes(picture, motion)
        self.signs: tuple[Stroke, ...] = ()
        self.colors = colors
        self.strength = 1.0
        self.collection: Any = None

    def _painted(self, picture: Picture) -> list[Painted]:
        moving = [s for s in moving_strokes(picture, self.motion) if self.gaps or s.style != "gap"]
        rigid = shifted(self.rigid, place_shifts(self.first, picture))
        return painted(picture, (*rigid, *moving, *self.signs), self.colors)

    def global_lines(self, picture: Picture) -> list[FloatArray]:
        """All visible lines in the global frame, (k, 2) each, m."""
        return [
            _closed(placed(one.stroke.points, picture.poses[one.stroke.body]), one.stroke.closed)
            for one in self._painted(picture)
            if one.pen.line
        ]

    def bounds(self, picture: Picture) -> tuple[FloatArray, FloatArray]:
        """Least and greatest x and y of the picture, with a border, m."""
        lines = self.global_lines(picture) or [picture.poses[:, :2]]
        low, high = extent(lines)
        low, high = low - BORDER * picture.size, high + BORDER * picture.size
        width, height = high - low
        more = np.maximum(np.array([height / HIGHEST - width, width / FLATTEST - height]), 0.0) / 2
        return low - more, high + more

    def add_to(self, axes: "Axes", picture: Picture, zorder: float = 2.0) -> Any:
        """Draw on axes, and return the collection."""
        from matplotlib.collections import PathCollection

        strokes = self._painted(picture)
        pens = [one.pen for one in strokes]
        self.collection = PathCollection(
            self._paths(picture, strokes),
            facecolors=[self._shade(pen.fill) for pen in pens],
            edgecolors=[self._shade(pen.line) for pen in pens],
            linewidths=[pen.width for pen in pens],
            linestyles=[pen.dashes for pen in pens],
            capstyle="round",
            joinstyle="round",
            snap=False,  # lines and insides would be moved by different parts of a pixel
            zorder=zorder,
        )
        axes.add_collection(self.collection, autolim=False)
        return self.collection

    def _shade(self, color: str) -> str:
        """The colour, or its mixture with the background; "none" for the empty one."""
        if not color or self.strength == 1.0:
            return color or "none"
        parts = np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in
                          (color, self.colors.background)])  # fmt: skip
        mixed = np.round(np.array([self.strength, 1 - self.strength]) @ parts).astype(int)
        return "#" + "".join(f"{part:02x}" for part in mixed)

    def _paths(self, picture: Picture, strokes: list[Painted]) -> list[Any]:
        from matplotlib.path import Path

        return [
            Path(_closed(placed(s.points, picture.poses[s.body]), s.closed), closed=s.closed)
            for s, _ in strokes
        ]

    def update(self, picture: Picture) -> None:
        """Move the strokes to the poses of a picture with the same shapes."""
        strokes = self._painted(picture)
        self.collection.set_paths(self._paths(picture, strokes))


def _closed(points: FloatArray, closed: bool) -> FloatArray:
    return np.concatenate([points, points[:1]]) if closed else points
