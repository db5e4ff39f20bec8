"""Stills, movies and positions as figures of Matplotlib, which is loaded when one is drawn."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing import annotations
from codegen.drawing.labels import Writer, labels
from codegen.drawing.lines_between_bodies import lines_between_bodies
from codegen.drawing.lines_in_bodies import lines_in_bodies
from codegen.drawing.picture import Picture, SpacePicture
from codegen.drawing.plane_geometry import FloatArray, Points, origin, pairs
from codegen.drawing.solids import solids
from codegen.drawing.space_strokes import arrows_in_space, frames_in_space, strokes_in_space
from codegen.drawing.styles import LIGHT, STYLES, Stroke, color_of, ordered
from codegen.errors import InputError
from codegen.presentation import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDEST, TALLEST, LEAST = 7.2, 5.6, 2.6  # layout: sizes of a figure, in inches
MARGINS = (0.75, 0.8)  # layout: room for ticks and titles, in inches
FLATTEST, HIGHEST = 3.2, 1.8  # layout: width over height, and height over width, of the axes
HIGHEST_WITH_FORCES = 0.9  # layout: height over width of axes with texts at forces
BORDER = 0.07  # layout: room round a mechanism, in typical lengths
DPI = 100  # layout: pixels of a movie per inch, so that letters have their usual size
SAMPLED = 120  # layout: positions from which the view of a motion is found
FARTHEST = 2.5  # layout: what is farther away, in typical lengths, may leave the view
PALEST = 0.22  # layout: strength of the colours of the first of several positions
TALLEST_MOVIE, FLATTEST_MOVIE = 1.1, 0.34  # layout: height of a movie over its width
TRIAD = 24.0  # layout: length of the arrows of the global axes, in points
TITLE_ROOM = 0.85  # layout: room above and below the axes of a movie, inches
SIDE = 0.75  # layout: room beside the axes of a movie, inches


def figure(
    picture: Picture, dimensions: bool = False, forces: bool = False, *, frames: bool = False,
    names: bool = True, view: str = "usual", series: annotations.Series | None = None,
    run: Iterable[annotations.Load] = (),
) -> "Figure":  # fmt: skip
    """Draw a picture, whose bodies all have outlines: see `body_outlines.complete_picture`.

    Places of a joint that do not coincide are joined by a dashed line that says how far they are
    apart. The words are those of `Model.draw`; without `forces` arrows of one length say where
    forces act, and which way. `series` are what joints, drivers and forces exert at this instant,
    by the names of their series, and `run` is all that acts in the run. Raises InputError where
    Matplotlib is not installed.
    """
    if isinstance(picture, SpacePicture):
        picture = replace(picture, seen=view)
    elif view != "usual":
        raise InputError(f"{picture.title}: view= is there for machines in space alone.")
    acting = annotations.acting_loads(picture, series, run)
    scale = annotations.force_scale(picture, acting) if forces else None
    if isinstance(picture, SpacePicture):
        if dimensions:
            raise InputError(f"{picture.title}: dimensions= is there for machines in the plane "
                             "alone; the picture of one in space is seen at an angle.")  # fmt: skip
        arrows, axes_of_bodies = arrows_in_space(picture, acting, forces), frames_in_space(picture)
    else:
        arrows = annotations.drawn_loads(picture, acting, forces)
        axes_of_bodies = annotations.frame_strokes(picture)
    measured = annotations.dimension_lines(picture) if dimensions else []
    artist = _artist(picture)
    artist.signs = [
        *annotations.driver_strokes(picture),
        *(stroke for _, strokes in arrows for stroke in strokes),
        *(axes_of_bodies if frames else ()),
        *(annotations.trace_strokes(picture) if picture.motion is not None else ()),
        *(stroke for strokes in measured for stroke in strokes),
    ]
    highest = HIGHEST if scale is None else HIGHEST_WITH_FORCES  # their texts are long
    drawn, axes = _still(picture, *artist.bounds(picture, highest))
    artist.add_to(axes, picture)
    drawn.draw_without_rendering()
    writer = Writer(axes, artist.global_lines(picture))
    for line, *_ in measured:
        writer.add_dimension(line.points)
    if scale is not None:
        writer.add_scale(scale, picture.size)
    for label in labels(picture, arrows, forces) if names else ():
        writer.add(label)
    return drawn


def _still(picture: Picture, low: FloatArray, high: FloatArray) -> tuple["Figure", "Axes"]:
    """A figure whose axes have these proportions."""
    span, room = high - low, np.array([WIDEST - MARGINS[0], TALLEST - MARGINS[1]])
    width, height = np.maximum(span * float(np.min(room / span)) + MARGINS, LEAST)
    drawn = new_figure("picture", float(width), float(height))
    axes = drawn.add_subplot()
    _prepare_axes(axes, low, high, picture)
    return drawn, axes


def _prepare_axes(axes: "Axes", low: FloatArray, high: FloatArray, picture: Picture) -> None:
    """Equal axes with title and units, their edges pale; in space three arrows in a corner."""
    for part in (axes.figure, axes):
        part.set_facecolor(LIGHT["background"])
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    bins = [max(2, round(7 * span / (high - low).max())) for span in high - low]
    axes.locator_params("x", nbins=bins[0])
    axes.locator_params("y", nbins=bins[1])
    for name, axis in zip("xy", (axes.xaxis, axes.yaxis), strict=True):
        axis.set_label_text(f"{name}, m", color=LIGHT["muted"], fontsize=8.5)
    axes.set_title(picture.title, color=LIGHT["ink"], fontsize=10.5)
    axes.tick_params(colors=LIGHT["muted"], labelsize=8, length=3, width=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(LIGHT["grid"])
    if isinstance(picture, SpacePicture):
        axes.set_axis_off()
        for letter, way in zip("xyz", picture.flat(np.eye(3)), strict=True):
            axes.annotate(
                letter, (0.04, 0.05), (TRIAD * way.real, TRIAD * way.imag), "axes fraction",
                "offset points", {"arrowstyle": "<-", "color": LIGHT["muted"]}, ha="center",
                va="center", fontsize=8.5, color=LIGHT["muted"],
            )  # fmt: skip


class PictureArtist:
    """The strokes of a picture as one collection, which follows poses.

    It draws one picture, then others with the same symbols, and `signs` besides. Without `gaps` it
    leaves out those of joints that are not closed; of colours of less `strength` than 1 are pale
    pictures, which have no ground.
    """

    def __init__(self, picture: Picture, gaps: bool = True, strength: float = 1.0) -> None:
        self.picture, self.gaps, self.strength = picture, gaps, strength
        self.rigid = lines_in_bodies(picture)
        if strength < 1.0:
            self.rigid = [stroke for stroke in self.rigid if not picture.is_ground(stroke.body)]
        self.signs: Iterable[Stroke] = ()
        self.collection: Any = None

    def strokes(self, picture: Picture) -> list[Stroke]:
        """All strokes at the poses of a picture, in the order in which they are drawn."""
        shifts = picture.shifts(self.picture)
        rigid = [
            one._replace(points=one.points + shifts.get((one.element, one.body), 0.0))
            for one in self.rigid
        ]
        between = lines_between_bodies(picture)
        moving = [stroke for stroke in between if self.gaps or stroke.style != "gap"]
        return ordered(picture, (*rigid, *moving, *self.signs))

    def global_lines(self, picture: Picture) -> list[Points]:
        """All visible lines in the global frame, (k,) each, m."""
        strokes = self.strokes(picture)
        return [_line(picture, stroke) for stroke in strokes if STYLES[stroke.style].line]

    def bounds(self, picture: Picture, highest: float = HIGHEST) -> tuple[FloatArray, FloatArray]:
        """Least and greatest x and y of the picture, with a border, m."""
        lines = np.concatenate(self.global_lines(picture) or [origin(picture.poses)])
        points = pairs(lines[np.isfinite(lines)])
        border = BORDER * picture.size
        low, high = points.min(axis=0) - border, points.max(axis=0) + border
        width, height = high - low
        more = np.maximum(np.array([height / highest - width, width / FLATTEST - height]), 0.0) / 2
        return low - more, high + more

    def add_to(self, axes: "Axes", picture: Picture, zorder: float = 2.0) -> Any:
        """Draw on axes, and return the collection."""
        from matplotlib.collections import PathCollection

        strokes = self.strokes(picture)
        self.collection = PathCollection(
            _paths(picture, strokes),
            **self._looks(strokes),
            capstyle="round",
            joinstyle="round",
            snap=False,  # lines and insides would be moved by different parts of a pixel
            zorder=zorder,
        )
        axes.add_collection(self.collection, autolim=False)
        return self.collection

    def _looks(self, strokes: Iterable[Stroke]) -> dict[str, Any]:
        """Colours and lines of strokes, for Matplotlib."""
        both = [(STYLES[stroke.style], stroke.body) for stroke in strokes]
        return {
            "facecolors": [self._shade(color_of(s.fill, body), s.opacity) for s, body in both],
            "edgecolors": [self._shade(color_of(style.line, body)) for style, body in both],
            "linewidths": [style.width for style, _ in both],
            "linestyles": [style.dashes for style, _ in both],
        }

    def _shade(self, color: str, opacity: float = 1.0) -> Any:
        """The colour, or its mixture with the background; "none" for the empty one."""
        from matplotlib.colors import to_rgb

        if not color:
            return "none"
        shades = np.array([to_rgb(color), to_rgb(LIGHT["background"])])
        return (*(np.array([self.strength, 1 - self.strength]) @ shades), opacity)

    def update(self, picture: Picture) -> None:
        """Move the strokes to the poses of a picture with the same shapes."""
        self.collection.set_paths(_paths(picture, self.strokes(picture)))


class SpaceArtist(PictureArtist):
    """The same of a picture in space, whose strokes change their order."""

    def __init__(self, picture: SpacePicture, gaps: bool = True, strength: float = 1.0) -> None:
        self.picture, self.gaps, self.strength = picture, gaps, strength
        self.signs, self.collection = (), None
        self.solids = [
            one for one in solids(picture) if strength == 1.0 or not picture.is_ground(one.body)
        ]

    def strokes(self, picture: Picture) -> list[Stroke]:
        """All strokes, the nearest last."""
        assert isinstance(picture, SpacePicture)
        return [*strokes_in_space(picture, self.solids, self.gaps), *self.signs]

    def update(self, picture: Picture) -> None:
        """Move the strokes, with their colours."""
        strokes = self.strokes(picture)
        self.collection.set(paths=_paths(picture, strokes), **self._looks(strokes))


def _artist(picture: Picture, gaps: bool = True, strength: float = 1.0) -> PictureArtist:
    """The artist of a picture in the plane or in space."""
    if isinstance(picture, SpacePicture):
        return SpaceArtist(picture, gaps, strength)
    return PictureArtist(picture, gaps, strength)


def _paths(picture: Picture, strokes: Iterable[Stroke]) -> list[Any]:
    from matplotlib.path import Path

    return [Path(pairs(_line(picture, stroke)), closed=stroke.closed) for stroke in strokes]


def _line(picture: Picture, stroke: Stroke) -> Points:
    """A stroke in the global frame, (k,), m; the first point comes again if it is closed."""
    points = picture.placed(stroke.points, stroke.body)
    return np.append(points, points[:1]) if stroke.closed else np.asarray(points)


def _view(frames: Sequence[Picture], artist: PictureArtist) -> tuple[FloatArray, FloatArray]:
    """Least and greatest x and y of all positions, m, but for what flies far away."""
    chosen = np.unique(np.linspace(0, len(frames) - 1, SAMPLED).astype(int))
    lows, highs = zip(*(artist.bounds(frames[k]) for k in chosen), strict=True)
    reach = FARTHEST * frames[0].size
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    return np.maximum(low, lows[0] - reach), np.minimum(high, highs[0] + reach)


class MovieFigure:
    """A figure of a width in pixels, whose frames are drawn on one background.

    Width and height in pixels, `size`, are even, as video codecs want them.
    """

    def __init__(self, frames: Sequence[Picture], width: int) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        self.frames, first = frames, frames[0]
        self.artists: dict[tuple[tuple[str, str], ...], PictureArtist] = {}
        low, high = _view(frames, self._artist_of(first))
        wide = width / DPI
        height = (wide - SIDE) * float(np.divide(*(high - low)[::-1]))
        height = float(np.clip(height, FLATTEST_MOVIE * wide, TALLEST_MOVIE * wide))
        even = (2 * round(side / 2) / DPI for side in (width, DPI * (height + TITLE_ROOM)))
        figure = new_figure("movie", *even, dpi=DPI)
        canvas: Any = FigureCanvasAgg(figure)  # matplotlib leaves its methods untyped
        self.canvas, self.axes = canvas, figure.add_subplot()
        self.size: tuple[int, int] = canvas.get_width_height()
        _prepare_axes(self.axes, low, high, first)
        shown = replace(first, motion=np.array([frame.poses for frame in frames]))
        for stroke in annotations.trace_strokes(shown):
            self.axes.plot(*pairs(stroke.points).T, color=LIGHT["trace"], linewidth=0.9, zorder=1.5)
        self.clock = self.axes.text(0.99, 1.015, "", transform=self.axes.transAxes, ha="right",
                                    fontsize=9, color=LIGHT["muted"], animated=True)  # fmt: skip
        canvas.draw()
        figure.set_layout_engine("none")  # that of the first frame is kept
        self.background = canvas.copy_from_bbox(figure.bbox)

    def _artist_of(self, frame: Picture) -> PictureArtist:
        """The artist of frames with these symbols."""
        key = tuple((symbol.element, symbol.shape.kind) for symbol in frame.symbols)
        if key not in self.artists:
            self.artists[key] = _artist(frame, gaps=False)
        return self.artists[key]

    def pixels(self, number: int, clock: str) -> npt.NDArray[np.uint8]:
        """A frame as red, green, blue and opacity, (height, width, 4), 0 to 255."""
        frame = self.frames[number]
        artist = self._artist_of(frame)
        artist.signs = list(annotations.driver_strokes(frame))
        if artist.collection is None:
            artist.add_to(self.axes, frame).set_animated(True)
        else:
            artist.update(frame)
        self.clock.set_text(clock)
        self.canvas.restore_region(self.background)
        self.axes.draw_artist(artist.collection)
        self.axes.draw_artist(self.clock)
        return np.asarray(self.canvas.buffer_rgba(), dtype=np.uint8)


def phase_figure(frames: Sequence[Picture]) -> "Figure":
    """Several positions of a motion over each other, the first pale and the last with names."""
    shades = np.linspace(PALEST, 1.0, len(frames)) ** 1.5 if len(frames) > 1 else [1.0]
    artists = [
        _artist(frame, gaps=False, strength=float(shade))
        for frame, shade in zip(frames, shades, strict=True)
    ]
    last = frames[-1]
    result, axes = _still(last, *_view(frames, artists[-1]))
    for number, (artist, frame) in enumerate(zip(artists, frames, strict=True)):
        artist.add_to(axes, frame, 2.0 + number / len(frames))
    result.draw_without_rendering()
    writer = Writer(axes, artists[-1].global_lines(last))
    for label in labels(last):
        writer.add(label)
    return result
