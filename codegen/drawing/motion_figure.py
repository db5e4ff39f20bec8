"""Figures of a motion: one that follows poses fast, and one of several positions at once."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.annotations import trace_strokes
from codegen.drawing.arrows import driver_strokes
from codegen.drawing.colors import LIGHT
from codegen.drawing.matplotlib_painter import PictureArtist, Writer, inches, prepare_axes
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import FloatArray
from codegen.drawing.shapes import Force, Torque
from codegen.presentation import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 100  # layout: pixels of a movie per inch, so that letters have their usual size
SAMPLED = 120  # layout: positions from which the view of a motion is found
FARTHEST = 2.5  # layout: what is farther away, in typical lengths, may leave the view
PALEST = 0.22  # layout: strength of the colours of the first of several positions
TALLEST = 1.1  # layout: height of a movie over its width, at most
LEAST = 0.34  # layout: the same, at least
TITLE, FOOT, SIDE = 0.42, 0.55, 0.75  # layout: room round the axes, in inches


def view(frames: Sequence[Picture], artist: PictureArtist) -> tuple[FloatArray, FloatArray]:
    """Least and greatest x and y, m, of all positions, but for what leaves the machine far behind.

    A ball that is thrown leaves the view, which is wider than the machine by `FARTHEST` at most.
    """
    chosen = np.unique(np.linspace(0, len(frames) - 1, SAMPLED).astype(int))
    lows, highs = zip(*(artist.bounds(frames[k]) for k in chosen), strict=True)
    low, high = lows[0], highs[0]
    reach = FARTHEST * frames[0].size
    lowest, highest = np.min(lows, axis=0), np.max(highs, axis=0)
    return np.maximum(lowest, low - reach), np.minimum(highest, high + reach)


class MovieFigure:
    """A figure whose frames are drawn on one background.

    Parameters
    ----------
    frames, width
        Pictures one after the other; pixels.
    motion
        Poses of the motion of which the frames are a part, (instants, bodies, 3): guides and
        surfaces are as long as it needs.

    Attributes
    ----------
    size
        Width and height in pixels, both even, as video codecs want them.
    """

    def __init__(self, frames: Sequence[Picture], width: int, motion: FloatArray) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        first = frames[0]
        self.frames, self.motion = frames, motion
        self.artists: dict[tuple[tuple[str, str], ...], PictureArtist] = {}
        low, high = view(frames, self._artist_of(first))
        size, fractions = _shape(width / DPI, (high - low)[1] / (high - low)[0])
        self.figure = new_figure("movie", *size)
        self.figure.set_layout_engine("none")
        self.figure.set_dpi(DPI)
        canvas: Any = FigureCanvasAgg(self.figure)  # matplotlib leaves its methods untyped
        self.canvas = canvas
        self.axes = self.figure.add_axes(fractions)
        prepare_axes(self.axes, low, high, first.title)
        for stroke in trace_strokes(first, np.array([frame.poses for frame in frames])):
            x, y = stroke.points.real, stroke.points.imag
            self.axes.plot(x, y, color=LIGHT.trace, linewidth=0.9, zorder=1.5)
        self.clock = self.axes.text(0.99, 1.015, "", transform=self.axes.transAxes, ha="right",
                                    fontsize=9, color=LIGHT.muted, animated=True)  # fmt: skip
        self.canvas.draw()
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        width, height = self.canvas.get_width_height()
        return width, height

    def _artist_of(self, frame: Picture) -> PictureArtist:
        """The artist of frames with these symbols."""
        key = tuple((symbol.element, symbol.shape.kind) for symbol in frame.symbols)
        if key not in self.artists:
            self.artists[key] = PictureArtist(frame, self.motion, gaps=False)
        return self.artists[key]

    def pixels(self, number: int, clock: str) -> npt.NDArray[np.uint8]:
        """A frame as red, green, blue and opacity, (height, width, 4), 0 to 255."""
        frame = self.frames[number]
        artist = self._artist_of(frame)
        artist.signs = list(driver_strokes(frame))
        if artist.collection is None:
            artist.add_to(self.axes, frame).set_animated(True)
        else:
            artist.update(frame)
        self.clock.set_text(clock)
        self.canvas.restore_region(self.background)
        self.axes.draw_artist(artist.collection)
        self.axes.draw_artist(self.clock)
        return np.asarray(self.canvas.buffer_rgba(), dtype=np.uint8)


def _shape(
    width: float, ratio: float
) -> tuple[tuple[float, float], tuple[float, float, float, float]]:
    """Size of a figure in inches, and its axes in parts of it, for contents of a ratio y : x."""
    inner = width - SIDE - 0.15
    height = float(np.clip(inner * ratio, LEAST * width, TALLEST * width)) + TITLE + FOOT
    width, height = (2 * round(side * DPI / 2) / DPI for side in (width, height))
    axes = (SIDE / width, FOOT / height, inner / width, 1 - (TITLE + FOOT) / height)
    return (width, height), axes


def phase_figure(frames: Sequence[Picture], motion: FloatArray) -> "Figure":
    """Several positions of a motion over each other, the first pale and the last with names.

    `motion` as for `MovieFigure`.
    """
    artists = [PictureArtist(frame, motion, gaps=False) for frame in frames]
    low, high = view(frames, artists[-1])
    result = new_figure("picture", *inches(high - low))
    axes, last = result.add_subplot(), frames[-1]
    prepare_axes(axes, low, high, last.title)
    shades = np.linspace(PALEST, 1.0, len(frames)) ** 1.5 if len(frames) > 1 else [1.0]
    for number, (artist, frame) in enumerate(zip(artists, frames, strict=True)):
        artist.strength = float(shades[number])
        if frame is not last:
            artist.rigid = [s for s in artist.rigid if not frame.is_ground(s.body)]
        artist.add_to(axes, frame, 2.0 + number / len(frames))
    result.draw_without_rendering()
    forces = {k for k, s in enumerate(last.symbols) if isinstance(s.shape, Force | Torque)}
    writer = Writer(axes, artists[-1].global_lines(last))
    writer.add_names(last.without(forces), None, False)
    return result
