"""A picture as a figure of Matplotlib, which is loaded when a figure is drawn."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.drawing.annotations import (
    Dimension,
    dimension_lines,
    frame_strokes,
    trace_strokes,
)
from codegen.drawing.arrows import Series, drawn_loads, driver_strokes, force_scale
from codegen.drawing.colors import LIGHT
from codegen.drawing.label_placement import Label, place_labels, samples
from codegen.drawing.label_texts import NUMBER_SIZE, engineering, label_texts
from codegen.drawing.line_styles import STYLES, Stroke, colors_of, ordered
from codegen.drawing.lines_between_bodies import lines_between_bodies
from codegen.drawing.lines_in_bodies import lines_in_bodies
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import FloatArray, pairs
from codegen.presentation import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDEST, TALLEST, LEAST = 7.2, 5.6, 2.6  # layout: sizes of a figure, in inches
MARGINS = (0.75, 0.8)  # layout: room for ticks and titles, in inches
FLATTEST, HIGHEST = 3.2, 1.8  # layout: width over height, and height over width, of the axes
HIGHEST_WITH_FORCES = 0.9  # layout: height over width of axes with texts at forces
BORDER = 0.07  # layout: room round a mechanism, in typical lengths
SAMPLE = 3.0  # layout: distance of the samples of lines that names avoid, in points


def figure(
    picture: Picture,
    dimensions: bool = False,
    forces: bool = False,
    *,
    frames: bool = False,
    names: bool = True,
    series: Series | None = None,
    motion: FloatArray | None = None,
) -> "Figure":
    """Draw a picture.

    Parameters
    ----------
    picture
        With outlines of all bodies: see `body_outlines.complete_picture`.
    dimensions
        Distances between the places of each body, in m, to four digits.
    forces
        Arrows to scale, with the scale and values; otherwise arrows of one length say where forces
        act, and which way.
    frames
        The axes x' and y' of bodies, and their centres of mass.
    names
        Names of bodies, joints, drivers and forces.
    series
        Reactions of joints, drivers and contacts by the names of their series: forces in N in the
        joint's axes, and torques in N m, that act on its second body.
    motion
        Poses of a motion, shape (instants, bodies, 3): guides are as long as it needs.

    Returns
    -------
    A figure of Matplotlib; places of a joint that do not coincide are joined by a dashed line that
    says how far they are apart.

    Raises
    ------
    InputError
        If Matplotlib is not installed.
    """
    series = series if forces else None
    scale = force_scale(picture, series) if forces else None
    measured = dimension_lines(picture) if dimensions else []
    artist = PictureArtist(picture, motion)
    artist.signs = [
        *driver_strokes(picture),
        *(stroke for _, strokes in drawn_loads(picture, scale, series) for stroke in strokes),
        *(frame_strokes(picture) if frames else ()),
        *(trace_strokes(picture, motion) if motion is not None else ()),
        *(stroke for line in measured for stroke in line.strokes),
    ]
    low, high = artist.bounds(picture)
    if scale is not None:  # room beside a tall machine: texts at forces are long
        width, height = high - low
        more = np.array([max(height / HIGHEST_WITH_FORCES - width, 0.0) / 2, 0.0])
        low, high = low - more, high + more
    drawn = new_figure("picture", *inches(high - low))
    axes = drawn.add_subplot()
    prepare_axes(axes, low, high, picture.title)
    artist.add_to(axes, picture)
    drawn.draw_without_rendering()
    writer = Writer(axes, artist.global_lines(picture))
    writer.add_dimensions(measured)
    if scale is not None:
        writer.add_scale(scale, picture.size)
    if names:
        writer.add_names(picture, series, forces)
    return drawn


def inches(span: FloatArray) -> tuple[float, float]:
    """Width and height of a figure whose axes have these proportions."""
    room = np.array([WIDEST - MARGINS[0], TALLEST - MARGINS[1]])
    width, height = np.maximum(span * float(np.min(room / span)) + MARGINS, LEAST)
    return float(width), float(height)


def prepare_axes(axes: "Axes", low: FloatArray, high: FloatArray, title: str) -> None:
    """Equal axes with title and units, their edges pale."""
    spans = high - low
    for part in (axes.figure, axes):
        part.set_facecolor(LIGHT.background)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x, m", color=LIGHT.muted, fontsize=8.5)
    axes.set_ylabel("y, m", color=LIGHT.muted, fontsize=8.5)
    axes.set_title(title, color=LIGHT.ink, fontsize=10.5)
    axes.tick_params(colors=LIGHT.muted, labelsize=8, length=3, width=0.6)
    axes.locator_params("x", nbins=max(2, round(7 * spans[0] / spans.max())))
    axes.locator_params("y", nbins=max(2, round(7 * spans[1] / spans.max())))
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(LIGHT.grid)


class PictureArtist:
    """The strokes of a picture as one collection, which follows poses.

    Attributes
    ----------
    rigid
        The strokes that are fixed in bodies.
    signs
        Strokes in the global frame, or in those of bodies, that are drawn besides.
    strength
        How strong the colours are, from 0, that of the background, to 1.
    gaps
        Whether gaps of joints that are not closed are drawn.
    """

    def __init__(
        self, picture: Picture, motion: FloatArray | None = None, gaps: bool = True
    ) -> None:
        self.motion, self.gaps = motion, gaps
        self.rigid = lines_in_bodies(picture, motion)
        self.signs: Iterable[Stroke] = ()
        self.strength = 1.0
        self.collection: Any = None

    def strokes(self, picture: Picture) -> list[Stroke]:
        """All strokes at the poses of a picture, in the order in which they are drawn."""
        shifts = picture.shifts
        rigid = [
            one._replace(points=one.points + shifts.get((one.element, one.body), 0.0))
            for one in self.rigid
        ]
        between = lines_between_bodies(picture, self.motion)
        moving = [stroke for stroke in between if self.gaps or stroke.style != "gap"]
        return ordered(picture, (*rigid, *moving, *self.signs))

    def global_lines(self, picture: Picture) -> list[FloatArray]:
        """All visible lines in the global frame, (k, 2) each, m."""
        strokes = self.strokes(picture)
        return [_line(picture, stroke) for stroke in strokes if STYLES[stroke.style].line]

    def bounds(self, picture: Picture) -> tuple[FloatArray, FloatArray]:
        """Least and greatest x and y of the picture, with a border, m."""
        points = np.concatenate(self.global_lines(picture) or [picture.poses[:, :2]])
        points = points[np.isfinite(points).all(axis=1)]
        border = BORDER * picture.size
        low, high = points.min(axis=0) - border, points.max(axis=0) + border
        width, height = high - low
        more = np.maximum(np.array([height / HIGHEST - width, width / FLATTEST - height]), 0.0) / 2
        return low - more, high + more

    def add_to(self, axes: "Axes", picture: Picture, zorder: float = 2.0) -> Any:
        """Draw on axes, and return the collection."""
        from matplotlib.collections import PathCollection

        strokes = self.strokes(picture)
        colors = [colors_of(stroke.style, stroke.body) for stroke in strokes]
        styles = [STYLES[stroke.style] for stroke in strokes]
        self.collection = PathCollection(
            self._paths(picture),
            facecolors=[self._shade(fill) for fill, _ in colors],
            edgecolors=[self._shade(line) for _, line in colors],
            linewidths=[style.width for style in styles],
            linestyles=[style.dashes for style in styles],
            capstyle="round",
            joinstyle="round",
            snap=False,  # lines and insides would be moved by different parts of a pixel
            zorder=zorder,
        )
        axes.add_collection(self.collection, autolim=False)
        return self.collection

    def _shade(self, color: str) -> Any:
        """The colour, or its mixture with the background; "none" for the empty one."""
        from matplotlib.colors import to_rgb

        if not color:
            return "none"
        shades = np.array([to_rgb(color), to_rgb(LIGHT.background)])
        return tuple(np.array([self.strength, 1 - self.strength]) @ shades)

    def _paths(self, picture: Picture) -> list[Any]:
        from matplotlib.path import Path

        strokes = self.strokes(picture)
        return [Path(_line(picture, stroke), closed=stroke.closed) for stroke in strokes]

    def update(self, picture: Picture) -> None:
        """Move the strokes to the poses of a picture with the same shapes."""
        self.collection.set_paths(self._paths(picture))


def _line(picture: Picture, stroke: Stroke) -> FloatArray:
    """A stroke in the global frame, (k, 2), m; the first point comes again if it is closed."""
    points = picture.placed(stroke.points, stroke.body)
    return pairs(np.append(points, points[:1]) if stroke.closed else points)


class Writer:
    """Writes texts on axes, so that they do not overlap.

    Parameters
    ----------
    lines
        All lines of the picture in the global frame, (k, 2) each, m, which names avoid.
    """

    def __init__(self, axes: "Axes", lines: list[FloatArray]) -> None:
        self.axes = axes
        self.points = 72.0 / axes.figure.dpi
        self.obstacles = [samples([self._on_paper(line) for line in lines], SAMPLE)]

    def _on_paper(self, at: FloatArray) -> FloatArray:
        """Places (k, 2), m, in points of the paper."""
        return np.asarray(self.axes.transData.transform(at)) * self.points

    def _write(self, at: complex, text: str, **style: Any) -> tuple[Any, FloatArray]:
        """A text, and two corners of its box in points, (2, 2)."""
        style = {"ha": "center", "va": "center", "zorder": 8, **style}
        artist: Any = self.axes.text(at.real, at.imag, text, **style)
        return artist, artist.get_window_extent().get_points() * self.points

    def _avoid(self, box: FloatArray) -> None:
        """Let no name cover a text."""
        x, y = (np.arange(low, high + 1, 2.0) for low, high in box.T)
        self.obstacles.append(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))

    def add_names(self, picture: Picture, series: Series | None, values: bool) -> None:
        """Write the names of bodies, joints, drivers and forces beside them.

        `values` says whether forces have their sizes behind their names.
        """
        labels, artists = [], []
        meter = float(np.ptp(self._on_paper(np.array([[0.0, 0.0], [1.0, 0.0]]))[:, 0]))
        for one in label_texts(picture, series, values):
            artist, box = self._write(
                0j, one.text, fontsize=one.fontsize, color=one.color, fontstyle=one.fontstyle
            )
            room, size = one.room * meter + 2.0, box[1] - box[0]
            labels.append(Label(self._on_paper(pairs(one.places)), size, room))
            artists.append(artist)
        low, high = self.axes.get_window_extent().get_points() * self.points
        spots = place_labels(labels, np.concatenate(self.obstacles), low, high)
        back = self.axes.transData.inverted()
        for artist, spot in zip(artists, spots, strict=True):
            artist.set_position(tuple(back.transform(spot.center / self.points)))
            if spot.is_far:
                ends = back.transform(np.array([spot.center, spot.anchor]) / self.points)
                style = {"color": artist.get_color(), "linewidth": 0.5, "alpha": 0.6}
                self.axes.plot(*ends.T, zorder=7, **style)
            artist.set_bbox({"facecolor": LIGHT.background, "alpha": 0.72,
                             "edgecolor": "none", "boxstyle": "round,pad=0.08"})  # fmt: skip

    def add_dimensions(self, measured: list[Dimension]) -> None:
        """Write the distances along dimension lines, readable from below and from the right."""
        for _, middle, angle, distance in measured:
            _, box = self._write(
                middle, f"{distance:.4g}", rotation=(np.degrees(angle) + 90.0) % 180.0 - 90.0,
                fontsize=NUMBER_SIZE, color=LIGHT.ink,
                bbox={"facecolor": LIGHT.background, "edgecolor": "none", "pad": 0.6},
            )  # fmt: skip
            self._avoid(box)

    def add_scale(self, scale: float, size: float) -> None:
        """The scale of the forces, m/N: a bar in the lower right corner for a round force."""
        exact = 0.2 * size / scale
        power = 10.0 ** np.floor(np.log10(exact))
        value = power * max(m for m in (1, 2, 5) if m * power <= exact * (1 + 1e-9))
        end = complex(self.axes.get_xlim()[1], self.axes.get_ylim()[0]) + (-0.03 + 0.03j) * size
        x, y = pairs(np.array([end - value * scale, end])).T
        self.axes.plot(x, y, "|-", color=LIGHT.force, linewidth=1.4, markersize=6, zorder=8,
                       solid_capstyle="butt")  # fmt: skip
        at = end - value * scale / 2 + 0.015j * size
        style = {"va": "bottom", "fontsize": NUMBER_SIZE, "color": LIGHT.force}
        self._avoid(self._write(at, engineering(value, "N"), **style)[1])
