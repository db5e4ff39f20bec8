"""Figures, and series of a result drawn over time."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from runtime.results.result import Result


def new_figure(purpose: str, width: float, height: float, **options: Any) -> "Figure":
    """An empty figure for a "plot", "picture" or "report", sizes in inches."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError(
            f"A {purpose} needs matplotlib, which is not installed. Install linkwright[plot]."
        ) from error
    return Figure(figsize=(width, height), layout="constrained", **options)


def finish_axes(axes: "Axes", **grid: Any) -> None:
    """A left and a lower edge only, and a pale grid behind the curves."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(visible=True, **grid)
    axes.set_axisbelow(True)


def check_parent(path: Path) -> None:
    """Refuse a place for a picture whose folder does not exist."""
    if not path.resolve().parent.is_dir():
        raise InputError(f"--out {path}: the folder {path.resolve().parent} does not exist.")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Say which place cannot be written, and why."""
    try:
        yield
    except OSError as error:
        raise InputError(f"--out {path}: {error.strerror or error}.") from error


def plot(result: "Result", names: Sequence[str] = ()) -> "Figure":
    """Draw series of a result (as in `Result.series`; or every angle), one panel for each unit."""
    coordinates = result.description.coordinates
    chosen = list(names) or [row.name for row in coordinates if row.is_angle]
    panels: dict[str, list[str]] = {}
    for name in chosen or coordinates.names:
        panels.setdefault(result.series(name)[1], []).append(name)
    figure = new_figure("plot", 7.0, 2.4 * len(panels))
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (unit, members) in zip(axes, panels.items(), strict=True):
        for name in members:
            axis.plot(result.t, result.series(name)[0], label=name)
        axis.set_ylabel(unit)
        axis.legend(frameon=False)
        axis.grid(visible=True, alpha=0.3)
    axes[-1].set_xlabel("time (s)")
    axes[0].set_title(result.description.title, loc="left")
    return figure
