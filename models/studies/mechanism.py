"""A mechanism of straight bars drawn in its plane."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes

from models.studies.paths import ComplexArray

BAR, GROUND = "#5f6b76", "#202a33"


def bars(axes: Axes, points: Iterable[complex], faint: bool = False) -> None:
    """Bars from joint to joint, the joints as circles."""
    line = np.array(list(points), dtype=np.complex128)
    axes.plot(
        line.real, line.imag, "o-", color=BAR, markersize=4, markerfacecolor="white",
        linewidth=1.0 if faint else 2.0, alpha=0.45 if faint else 1.0, zorder=3,
    )  # fmt: skip


def plate(axes: Axes, corners: Iterable[complex]) -> None:
    """A body with more than two points, as a filled outline."""
    line = np.array(list(corners), dtype=np.complex128)
    axes.fill(line.real, line.imag, facecolor=BAR, alpha=0.18, edgecolor="none", zorder=2)


def ground(axes: Axes, points: Iterable[complex], names: Iterable[str]) -> None:
    """Joints on the ground, as triangles with their names below."""
    for point, name in zip(points, names, strict=True):
        axes.plot(point.real, point.imag, "^", color=GROUND, markersize=8, zorder=4)
        axes.annotate(name, (point.real, point.imag), (0, -14), textcoords="offset points",
                      ha="center", va="top")  # fmt: skip


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
