"""Series of a result drawn over time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from codegen.presentation import new_figure
from runtime.results.motion_at_instants import for_curves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.results.result import Result


def plot(result: "Result", names: Sequence[str] = ()) -> "Figure":
    """Draw series of a result (as in `Result.series`; or every angle), one panel for each unit.

    Tracked points are drawn by their paths, y over x in equal axes, in a panel below.
    """
    result = for_curves(result)
    coordinates = result.description.positions
    points = [name for name in names if name in result.description.tracked]
    chosen = [name for name in names if name not in points]
    chosen = chosen or ([] if points else [row.name for row in coordinates if row.is_angle])
    panels: dict[str, list[str]] = {}
    for name in chosen or ([] if points else [row.name for row in coordinates]):
        panels.setdefault(result.series(name)[1], []).append(name)
    count = len(panels) + bool(points)
    figure = new_figure("plot", 7.0, 2.4 * len(panels) + 5.0 * bool(points))
    shares = [1.0] * len(panels) + [2.0] * bool(points)
    axes = figure.subplots(count, 1, squeeze=False, height_ratios=shares)[:, 0]
    for axis in axes[1 : len(panels)]:
        axis.sharex(axes[0])
    for axis in axes[: len(panels) - 1]:
        axis.tick_params(labelbottom=False)
    for axis, (unit, members) in zip(axes, panels.items(), strict=False):
        for name in members:
            axis.plot(result.t, result.series(name)[0], label=name)
        axis.set_ylabel(unit)
        axis.legend(frameon=False)
        axis.grid(visible=True, alpha=0.3)
    if panels:
        axes[len(panels) - 1].set_xlabel("time (s)")
    for name in points:
        axes[-1].plot(*result.point(name).T, label=name)
    if points:
        axes[-1].set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
        axes[-1].legend(frameon=False)
        axes[-1].grid(visible=True, alpha=0.3)
    axes[0].set_title(result.description.title, loc="left")
    return figure
