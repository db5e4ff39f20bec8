"""A machine on the axes of a study's figure, as all pictures draw it, with points and paths."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from codegen.drawing.matplotlib_painter import PictureArtist
from models.studies.paths import ComplexArray
from runtime import Result
from runtime.show.pictures import moving_picture

PALE = 0.35  # strength of the colours of positions beside the one that is meant


def machine(axes: Axes, run: Result, k: int, faint: bool = False) -> None:
    """The machine at the instant `t[k]` of a run, in m; faint without its ground."""
    frame = moving_picture(run).frames()[k]
    artist = PictureArtist(frame, gaps=False, strength=PALE if faint else 1.0)
    artist.add_to(axes, frame, 1.5 if faint else 2.0)
    axes.update_datalim(np.array(artist.bounds(frame)))
    axes.autoscale_view()


def millimetres(axes: Axes) -> None:
    """Number both axes, which are in m, in mm."""
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{1e3 * value:g}"))


def mark(axes: Axes, point: complex, name: str, shift: tuple[float, float] = (6, 4)) -> None:
    """The name of a point beside it; `shift` in points."""
    axes.annotate(name, (point.real, point.imag), shift, textcoords="offset points", zorder=5)


def arrow(axes: Axes, start: complex, end: complex, colour: str) -> None:
    """The head of an arrow at `start`, pointing to `end`: which way a point runs."""
    axes.annotate(
        "", (end.real, end.imag), (start.real, start.imag),
        arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 16, "linewidth": 0},
    )  # fmt: skip


def trace(axes: Axes, path: ComplexArray, colour: str, label: str | None = None) -> None:
    """The path of a point."""
    axes.plot(path.real, path.imag, color=colour, label=label, zorder=2.5)
