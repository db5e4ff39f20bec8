"""Figures 8.3.2 to 8.3.5 of the book, arranged as there, with our numbers."""

from collections.abc import Callable, Iterator

import numpy as np
from matplotlib.figure import Figure

from models.studies.quick_return import FLYWHEELS, SLIDERS, Study, study
from runtime import Result

NOMINAL = 50.0
FIRST, SECOND, THIRD = "#d1495b", "#00798c", "#30638e"
MASS_COLOURS = dict(zip(SLIDERS, (FIRST, SECOND, THIRD), strict=True))
INERTIA_LOOKS = {
    inertia: {"color": colour, "linestyle": style}
    for inertia, colour, style in zip(
        FLYWHEELS, (FIRST, SECOND, THIRD), ("-", "-", "--"), strict=True
    )
}


def figures() -> Iterator[tuple[str, Figure]]:
    """(number in the book, picture)."""
    runs = study()
    yield "8_3_2", _driven(runs)
    yield "8_3_3", _over_time(runs, "8.3.3 Slider position", "x₆, m", lambda r: r.q("slider.x"))
    yield "8_3_4", _over_time(runs, "8.3.4 Flywheel angular velocity", "φ̇₃, rad/s",
                              lambda r: r.v("crank.phi"))  # fmt: skip
    yield "8_3_5", _over_time(runs, "8.3.5 Reaction at the flywheel bearing, x component",
                              "ground on flywheel, kN",
                              lambda r: r.reaction("B", "fx") / 1e3)  # fmt: skip


def _driven(runs: Study) -> Figure:
    """Figure 8.3.2: driving torque over one turn, for three sliders."""
    figure = Figure(figsize=(7.5, 3.9), layout="constrained")
    axes = figure.subplots()
    for mass, colour in MASS_COLOURS.items():
        run = runs.driven[mass]
        torque = run.reaction("crank_drive", "torque") / 1e3
        axes.plot(run.t, torque, color=colour, label=f"m₆ = {mass:g} kg")
    # One curve of inertia alone shows what the cut adds; elsewhere it covers its own slider's.
    run = runs.inertial[NOMINAL]
    torque = run.reaction("crank_drive", "torque") / 1e3
    axes.plot(run.t, torque, ":", color="black", label=f"m₆ = {NOMINAL:g} kg, inertia alone")
    axes.annotate("cut", (0.73, 430.0), ha="center")
    axes.set(
        title="8.3.2 Driving torque, flywheel at 2π rad/s from just after the cut",
        xlabel="t, s",
        ylabel="T, kN m",
        xlim=(0, 1),
    )
    axes.legend(loc="upper right")
    return figure


def _over_time(
    runs: Study, title: str, unit: str, quantity: Callable[[Result], np.ndarray]
) -> Figure:
    """A quantity over two seconds for the three flywheels."""
    figure = Figure(figsize=(7.5, 3.6), layout="constrained")
    axes = figure.subplots()
    for inertia, look in INERTIA_LOOKS.items():
        run = runs.running[inertia]
        axes.plot(run.t, quantity(run), label=f"J₃ = {inertia:g} kg m²", **look)
    axes.set(title=title, xlabel="t, s", ylabel=unit, xlim=(0, 2))
    axes.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    return figure
