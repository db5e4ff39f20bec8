"""A figure of curves over the time."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from matplotlib.figure import Figure

COLOURS = ("#d1495b", "#00798c", "#30638e")


def over_time(title: str, unit: str, curves: Mapping[str, tuple[Any, Any]]) -> Figure:
    """Curves (t, values) by label, the third dashed."""
    figure = Figure(figsize=(7.5, 3.6), layout="constrained")
    axes = figure.subplots()
    for (label, (t, values)), colour, style in zip(
        curves.items(), COLOURS, ("-", "-", "--"), strict=False
    ):
        axes.plot(t, values, style, color=colour, label=label)
        axes.set_xlim(t[0], t[-1])
    axes.set(title=title, xlabel="t, s", ylabel=unit)
    if len(curves) > 1:
        axes.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    return figure


Plot = tuple[str, str, str, Callable[[Any], Any]]
"""Number, title, unit, and a run's values."""


def of_runs(runs: Mapping[str, Any], *plots: Plot) -> Iterator[tuple[str, Figure]]:
    """(number, picture) of each plot, with a curve a run by its label."""
    for number, title, unit, values in plots:
        curves = {label: (run.t, values(run)) for label, run in runs.items()}
        yield number, over_time(title, unit, curves)
