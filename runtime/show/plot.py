"""Series of a result drawn over time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from codegen.figures_and_html import new_figure
from runtime.results.motion_at_instants import for_curves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.results.result import Result


def plot(result: "Result", names: Sequence[str] = ()) -> "Figure":
    """Draw series of a result (as in `Result.series`; or every angle), one panel for each unit."""
    result = for_curves(result)
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
