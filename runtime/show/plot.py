"""Series of a result over time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from codegen.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.results.time_series import TimeSeries


def plot(result: "TimeSeries", names: Sequence[str] = ()) -> "Figure":
    """Draw series of a result, those of one unit in one panel.

    Parameters
    ----------
    names
        As in `Result.series`; without any, every angle.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError(
            "A plot needs matplotlib, which is not installed. Install linkwright[plot]."
        ) from error
    told = result.description
    chosen = list(names) or [row.name for row in told.coordinates if row.is_angle]
    panels: dict[str, list[str]] = {}
    for name in chosen or told.coordinates.names:
        panels.setdefault(result.series(name)[1], []).append(name)
    figure = Figure(figsize=(7.0, 2.4 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (unit, members) in zip(axes, panels.items(), strict=True):
        for name in members:
            axis.plot(result.t, result.series(name)[0], label=name)
        axis.set_ylabel(unit)
        axis.legend(frameon=False)
        axis.grid(visible=True, alpha=0.3)
    axes[-1].set_xlabel("time (s)")
    axes[0].set_title(told.title, loc="left")
    return figure
