"""Figures 8.4.2 and 8.4.5 to 8.4.9 of the book, arranged as there, with our numbers."""

from collections.abc import Iterator, Mapping

import numpy as np
from matplotlib.figure import Figure

from models.studies.coil_spring import STIFFNESSES, arrival, separations, study
from runtime import Result

SPRING, LAST, STRIKER = "#8d99ae", "#00798c", "#d1495b"
BODIES = range(1, 7)
POSITION = "x, m"


def figures() -> Iterator[tuple[str, Figure]]:
    """(number in the book, picture)."""
    runs = study()
    yield "8_4_2", _surge(runs.surge)
    for number, k in zip(("8.4.5", "8.4.6", "8.4.7"), STIFFNESSES, strict=True):
        yield number.replace(".", "_"), _positions(number, k, runs.impact[k])
    yield "8_4_8", _chattering("8.4.8", "no damping", runs.impact, 3.0)
    yield "8_4_9", _chattering("8.4.9", "a damper of 200 N s/m", runs.damped, 3.0)


def _surge(run: Result) -> Figure:
    """Figure 8.4.2: position of each mass over time; dots where the first wave passes."""
    figure = Figure(figsize=(7.5, 6.5), layout="constrained")
    axes = figure.subplots()
    shown = run.t <= 4.0
    passing = []
    for i in BODIES:
        x = run.q(f"mass_{i}.x")[shown]
        axes.plot(run.t[shown], x, color=LAST)
        axes.text(4.03, x[-1], f"x$_{i}$", va="center")
        if i < BODIES[-1]:
            time = arrival(run.t, run.v(f"mass_{i}.x"), run.a(f"mass_{i}.x"))
            passing.append((time, np.interp(time, run.t[shown], x)))
    axes.plot(*np.array(passing).T, "o", color=STRIKER, markersize=4, label="the first wave passes")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.06))
    axes.set(title="8.4.2 Surge waves, k = 200 N/m", xlabel="t, s", ylabel=POSITION, xlim=(0, 4))
    return figure


def _positions(number: str, k: float, run: Result) -> Figure:
    """Figures 8.4.5 to 8.4.7: the striker and each mass over time."""
    figure = Figure(figsize=(7.5, 4.6), layout="constrained")
    axes = figure.subplots()
    for i in BODIES:
        axes.plot(run.t, run.q(f"mass_{i}.x"), color=LAST if i == BODIES[-1] else SPRING)
        axes.text(18.1, run.q(f"mass_{i}.x")[-1], f"x$_{i}$", va="center")
    axes.plot(run.t, run.q("striker.x"), color=STRIKER)
    axes.text(18.1, run.q("striker.x")[-1], "x$_8$", va="center", color=STRIKER)
    time, place = separations(run)[-1]
    axes.plot(time, place, "o", color=STRIKER, markersize=4)
    axes.annotate(
        f"last separation\n{time:.3f} s, {place:.4f} m",
        (time, place),
        (time - 0.4, place + 0.12),
        ha="right",
        arrowprops={"arrowstyle": "-", "linewidth": 0.6},
    )
    axes.set(
        title=f"{number} Impact of the striker, k = {k:g} N/m",
        xlabel="t, s",
        ylabel=POSITION,
        xlim=(0, 18),
        ylim=(0, 1.95),
    )
    return figure


def _chattering(number: str, what: str, runs: Mapping[float, Result], end: float) -> Figure:
    """Figures 8.4.8 and 8.4.9: bodies 6 and 8 for three stiffnesses, expanded in time."""
    figure = Figure(figsize=(7.5, 6.5), layout="constrained")
    panels = figure.subplots(len(STIFFNESSES), 1, sharex=True, sharey=True)
    for axes, k in zip(panels, sorted(STIFFNESSES), strict=True):
        run = runs[k]
        shown = run.t <= end
        axes.plot(run.t[shown], run.q("striker.x")[shown], color=STRIKER, label="x$_8$")
        axes.plot(run.t[shown], run.q("mass_6.x")[shown], color=LAST, label="x$_6$")
        ends = np.array([e for e in separations(run) if e[0] <= end])
        axes.plot(*ends.T, ".", color="black", markersize=5, label="separation")
        axes.set(ylabel=POSITION)
        axes.text(0.99, 0.9, f"k = {k:g} N/m", ha="right", transform=axes.transAxes)
    panels[0].set(title=f"{number} Chattering between bodies 6 and 8, {what}", xlim=(0, end))
    panels[0].legend(loc="lower left", ncols=3)
    panels[-1].set(xlabel="t, s")
    return figure
