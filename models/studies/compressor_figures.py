"""Figures 8.2.4 to 8.2.8 of the book, arranged as there, with our numbers."""

from collections.abc import Callable, Iterator
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from models.studies.compressor import FLYWHEELS, Study, study
from runtime import Result

COLOURS = {225.0: "#d1495b", 450.0: "#00798c", 900.0: "#30638e"}
SLOW, FAST = "#00798c", "#d1495b"


def figures() -> Iterator[tuple[str, Figure]]:
    """(number in the book, picture)."""
    runs = study()
    yield "8_2_4", _driven(runs)
    yield "8_2_5", _over_time(runs, "Angular velocity of the flywheel", "φ̇₁, rad/s",
                              lambda r: r.v("crank.phi"))  # fmt: skip
    yield "8_2_6", _over_time(runs, "Position of the slider", "x₃, m", lambda r: r.q("slider.x"))
    yield "8_2_7", _over_time(runs, "Velocity of the slider", "ẋ₃, m/s", lambda r: r.v("slider.x"))
    yield "8_2_8", _over_time(runs, "Reaction at the flywheel bearing, x component",
                              "ground on crank, kN",
                              lambda r: r.reaction("A", "fx") / 1e3)  # fmt: skip


def _driven(runs: Study) -> Figure:
    """Figure 8.2.4: (a) driving torque, (b) reaction force, over one turn of the crank."""
    figure = Figure(figsize=(7.5, 6.5), layout="constrained")
    torque, force = figure.subplots(2, 1, sharex=True)
    for (scene, speed), run in runs.driven.items():
        with_gas = scene == "inverse_dynamics"
        look = {"color": SLOW if speed == "2π" else FAST, "linestyle": "-" if with_gas else "--"}
        label = f"ω = {speed} rad/s, {'with' if with_gas else 'without'} gas"
        turn = np.degrees(run.q("crank.phi") - run.q("crank.phi")[0])
        torque.plot(turn, run.reaction("crank_drive", "torque") / 1e3, label=label, **look)
        size = np.hypot(run.reaction("A", "fx"), run.reaction("A", "fy"))
        force.plot(turn, size / 1e3, **look)
    torque.set(title="8.2.4 (a) Driving torque, crank at constant speed", ylabel="T, kN m")
    torque.legend(loc="upper left")
    force.set(
        title="8.2.4 (b) Reaction force at the crank bearing A",
        xlabel="turn of the crank since t = 0, degrees",
        ylabel="|F|, kN",
        xlim=(0, 360),
        xticks=range(0, 361, 45),
    )
    return figure


def _over_time(
    runs: Study, title: str, unit: str, quantity: Callable[[Result], np.ndarray]
) -> Figure:
    """A quantity over one second for the three flywheels; a cross marks where one stalls."""
    figure = Figure(figsize=(7.5, 3.6), layout="constrained")
    axes: Axes = figure.subplots()
    number = {"φ̇₁": "8.2.5", "x₃": "8.2.6", "ẋ₃": "8.2.7"}.get(unit.partition(",")[0], "8.2.8")
    styles = cycle(["-", "-", "--"])
    for inertia in FLYWHEELS:
        run, values = runs.running[inertia], quantity(runs.running[inertia])
        label = f"J₁ = {inertia:g} kg m²"
        if run.events and run.events[-1].what == "holds":
            stall = run.events[-1].time
            at = np.interp(stall, run.t, values)
            axes.plot(stall, at, "x", color=COLOURS[inertia], markersize=8)
            label += f" (stalls at {stall:.4f} s)"
        axes.plot(run.t, values, next(styles), color=COLOURS[inertia], label=label)
    axes.set(title=f"{number} {title}", xlabel="t, s", ylabel=unit, xlim=(0, 1))
    axes.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    return figure
