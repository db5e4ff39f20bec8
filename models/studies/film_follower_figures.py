"""Pictures of projects 5.1 and 8.1: the hook's path, the torque, and two ways to drive it."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from models.studies.film_follower import SPEED, Study, hook, study
from models.studies.mechanism import arrow, machine, mark, millimetres, trace
from models.studies.paths import path

TEAL, RED = "#00798c", "#d1495b"


def figures() -> Iterator[tuple[str, Figure]]:
    """(number of the project and of the picture, picture)."""
    runs = study()
    yield "p8_1_1", _path(runs)
    yield "p8_1_2", _torque(runs)
    yield "p8_1_3", _speed(runs)


def _path(runs: Study) -> Figure:
    """The path of the hook in the plane, and its height over time."""
    figure = Figure(figsize=(7.5, 4.6), layout="constrained")
    plane, time = figure.subplots(1, 2, width_ratios=(1, 1.5))
    places = {
        "A": ("crank", -0.0075),
        "B": ("crank", 0.0075),
        "C": ("coupler", 0),
        "D": ("rocker", 0.015),
    }
    points = {name: path(runs.turn, *place).at for name, place in places.items()}
    tip = hook(runs.turn).at
    trace(plane, tip, RED)
    trace(plane, points["C"], TEAL)
    for k in (80, 440):
        arrow(plane, tip[k], tip[k + 4], RED)
    machine(plane, runs.turn, 0)
    millimetres(plane)
    mark(plane, points["A"][0], "A", (-12, 6))
    mark(plane, points["B"][0], "B")
    mark(plane, points["D"][0], "D", (-3, 7))
    mark(plane, points["C"][0], "C", (7, -2))
    mark(plane, tip[0], "P", (-13, -2))
    plane.set(title="Hook P, linkage at φ₁ = 0", xlabel="x, mm", ylabel="y, mm", aspect="equal")
    plane.margins(0.1)
    time.plot(runs.turn.t, 1e3 * tip.imag, color=RED, label="y of P")
    time.plot(runs.turn.t, 1e3 * tip.real, color=RED, linestyle="--", label="x of P")
    time.set(title="One turn at 2π rad/s", xlabel="t, s", ylabel="mm", xlim=(0, 1))
    time.legend(loc="center right")
    return figure


def _torque(runs: Study) -> Figure:
    """The torque that holds the speed, for the two values of J3."""
    figure = Figure(figsize=(7.5, 3.6), layout="constrained")
    axes = figure.subplots()
    for (name, run), colour in zip(runs.driven.items(), (TEAL, RED), strict=True):
        torque = 1e6 * run.reaction("crank_drive", "torque")
        value = f"J₃ = {run.parameters['J3']:.2g} kg m², {name}"
        axes.plot(np.degrees(SPEED * run.t), torque, color=colour, label=value)
    axes.set(
        title="Project 8.1: driving torque at 2π rad/s",
        xlabel="φ₁, degrees",
        ylabel="T, µN m",
        xlim=(0, 360),
        xticks=range(0, 361, 45),
    )
    axes.legend()
    return figure


def _speed(runs: Study) -> Figure:
    """The crank from rest, under a constant torque and on the motor."""
    figure = Figure(figsize=(7.5, 5.4), layout="constrained")
    for axes, run, colour, title in zip(
        figure.subplots(2, 1),
        (runs.even, runs.motor),
        (TEAL, RED),
        ("a constant torque of 1 µN m", "a motor: 5 µN m standing, none at 4π rad/s"),
        strict=True,
    ):
        axes.plot(run.t, run.v("crank.phi"), color=colour)
        axes.set(
            title=f"Project 8.1: {title}", ylabel="φ̇₁, rad/s", xlim=(0, run.t[-1]), ylim=(0, None)
        )
    axes.set_xlabel("t, s")
    return figure
