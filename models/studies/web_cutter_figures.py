"""Pictures of projects 5.2 and 8.2: the tips of the knives, the torque, and the run."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from models.studies.mechanism import arrow, machine, mark, millimetres, trace
from models.studies.paths import path
from models.studies.web_cutter import SPEED, Study, cut, cuts, study, tips

TEAL, RED, BLUE = "#00798c", "#d1495b", "#30638e"


def figures() -> Iterator[tuple[str, Figure]]:
    """(number of the project and of the picture, picture)."""
    runs = study()
    yield "p8_2_1", _paths(runs)
    yield "p8_2_2", _speeds(runs)
    yield "p8_2_3", _torque(runs)
    yield "p8_2_4", _running(runs)


def _paths(runs: Study) -> Figure:
    """The machine where the tips meet, and their paths."""
    figure = Figure(figsize=(7.5, 4.6), layout="constrained")
    plane, close = figure.subplots(1, 2)
    run = runs.turn
    k = int(np.argmin(np.abs(SPEED * run.t - cut()[1])))
    A, B, C, D = (
        path(run, body, place).at[k]
        for body, place in (
            ("crank", -0.02),
            ("crank", 0.02),
            ("coupler", 0),
            ("rocker", 0.26 - 0.07j),
        )
    )
    upper, lower = (tip.at for tip in tips(run))
    machine(plane, run, k)
    mark(plane, A, "A", (-12, 6))
    mark(plane, B, "B", (7, 6))
    mark(plane, D, "D", (7, 4))
    mark(plane, C, "C", (4, 6))
    for axes in (plane, close):
        millimetres(axes)
        trace(axes, upper, RED, "upper knife")
        trace(axes, lower, BLUE, "lower knife")
    plane.set(title="Tips meeting, φ₁ = 102.9°", xlabel="x, mm", ylabel="y, mm", aspect="equal")
    for tip, colour in ((upper, RED), (lower, BLUE)):
        close.plot(tip[k].real, tip[k].imag, "o", color=colour, markersize=4)
        arrow(close, tip[k + 300], tip[k + 310], colour)
    close.set(title="Paths of the tips", xlabel="x, mm", ylabel="y, mm", aspect="equal")
    close.legend(loc="center")
    return figure


def _speeds(runs: Study) -> Figure:
    """The speeds of the tips, and the gap."""
    figure = Figure(figsize=(7.5, 6.6), layout="constrained")
    along, down, gap = figure.subplots(3, 1, sharex=True)
    turn = np.degrees(SPEED * runs.turn.t)
    upper, lower = tips(runs.turn)
    for tip, colour, name in ((upper, RED, "upper knife"), (lower, BLUE, "lower knife")):
        along.plot(turn, tip.velocity.real, color=colour, label=name)
        down.plot(turn, tip.velocity.imag, color=colour)
    gap.plot(turn, 1e3 * (upper.at - lower.at).imag, color=TEAL)
    for axes in (along, down, gap):
        axes.axvspan(*np.degrees(cut()), color="#d9a441", alpha=0.5, linewidth=0)
    along.set(
        title="Project 5.2: speed of the tips along the web (shaded: the cut)", ylabel="ẋ, m/s"
    )
    down.set(title="Speed of the tips across the web", ylabel="ẏ, m/s")
    gap.set(
        title="Gap between the tips", ylabel="mm", xlabel="φ₁, degrees", xlim=(0, 360),
        xticks=range(0, 361, 45),
    )  # fmt: skip
    along.legend(loc="upper center")
    return figure


def _torque(runs: Study) -> Figure:
    """The torque at constant speed, whole and without the cut."""
    figure = Figure(figsize=(7.5, 5.0), layout="constrained")
    whole, idle = figure.subplots(2, 1, sharex=True)
    for name, axes, colour in (("cutting", whole, RED), ("idle", idle, TEAL)):
        run = runs.driven[name]
        axes.plot(np.degrees(SPEED * run.t), run.reaction("crank_drive", "torque"), color=colour)
        axes.set(ylabel="T, N m")
    whole.set_title("Project 8.2: driving torque at 2π rad/s, cutting with 1000 N")
    idle.set(title="The same without a web", xlabel="φ₁, degrees", xlim=(0, 360),
             xticks=range(0, 361, 45))  # fmt: skip
    return figure


def _running(runs: Study) -> Figure:
    """The speed on the motor, and the first cut from near by."""
    figure = Figure(figsize=(7.5, 3.8), layout="constrained")
    speed, near = figure.subplots(1, 2, width_ratios=(1.6, 1), sharey=True)
    run = runs.running
    begin, end = cuts(run)[0]
    for axes in (speed, near):
        axes.plot(run.t, run.v("crank.phi"), color=BLUE)
        axes.axhline(SPEED, color="#202a33", linewidth=0.8, linestyle=":")
    near.axvspan(begin, end, color="#d9a441", alpha=0.4, linewidth=0)
    speed.set(title="Project 8.2: on a motor of 20 N m s", xlabel="t, s", ylabel="φ̇₁, rad/s",
              xlim=(0, run.t[-1]))  # fmt: skip
    near.set(
        title="The first cut; shaded: its force", xlabel="t, s", xlim=(begin - 0.005, end + 0.01)
    )
    return figure
