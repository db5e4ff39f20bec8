"""Pictures of projects 5.3 and 8.3: the two models, the driven swing, and the run on a torque."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from models.studies.mechanism import machine, mark, millimetres, trace
from models.studies.paths import path
from models.studies.rack_and_pinion import DEAD, HALF, MODELS, TORQUE, D, Study, study

TEAL, RED, BLUE = "#00798c", "#d1495b", "#30638e"
COLOURS = {"": TEAL, "_massless_coupler": RED}


def figures() -> Iterator[tuple[str, Figure]]:
    """(number of the project and of the picture, picture)."""
    runs = study()
    yield "p8_3_1", _models(runs)
    yield "p8_3_2", _driven(runs)
    yield "p8_3_3", _running(runs)


def _models(runs: Study) -> Figure:
    """Both models at φ = 0, at the ends of the swing faint, with the path of C."""
    figure = Figure(figsize=(7.5, 2.9), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, (ending, run) in zip(panels, runs.swung.items(), strict=True):
        for k in (360, 1080):
            machine(axes, run, k, faint=True)
        machine(axes, run, 0)
        millimetres(axes)
        trace(axes, path(run, "rack", HALF).at, COLOURS[ending])
        mark(axes, D, "D", (6, 4))
        mark(axes, 0, "O", (-3, 7))
        mark(axes, path(run, "rack", HALF).at[0], "C", (-3, 7))
        axes.set(xlabel="x, mm", aspect="equal")
    panels[0].set(title="Model 1: the coupler a body", ylabel="y, mm")
    panels[1].set(title="Model 2: a revolute-revolute joint")
    return figure


def _driven(runs: Study) -> Figure:
    """The rack, and the torque with and without the coupler's mass, over one swing."""
    figure = Figure(figsize=(7.5, 6.6), layout="constrained")
    angles, rates, torques = figure.subplots(3, 1, sharex=True)
    run = runs.swung[""]
    for body, colour in (("rack", TEAL), ("coupler", BLUE)):
        angles.plot(run.t, np.degrees(run.q(f"{body}.phi")), color=colour, label=body)
        rates.plot(run.t, run.v(f"{body}.phi"), color=colour)
    angles.plot(run.t, np.degrees(run.q("pinion.phi")), color=RED, label="pinion")
    rates.plot(run.t, run.v("pinion.phi"), color=RED)
    for ending, name in MODELS.items():
        driven = runs.driven[ending]
        torque = 1e3 * driven.reaction("pinion_drive", "torque")
        torques.plot(driven.t, torque, color=COLOURS[ending], label=name)
    angles.set(title="Project 5.3: pinion at 2.5 sin 2πt rad", ylabel="φ, degrees",
               yticks=range(-180, 181, 90))  # fmt: skip
    rates.set(title="Angular velocities", ylabel="φ̇, rad/s")
    torques.set(title="Project 8.3: driving torque", ylabel="T, N mm", xlabel="t, s", xlim=(0, 1))
    angles.legend(ncols=3, loc="lower left")
    torques.legend(ncols=2)
    return figure


def _running(runs: Study) -> Figure:
    """One period under a constant torque: through the dead centre, to rest, and back."""
    figure = Figure(figsize=(7.5, 5.2), layout="constrained")
    angle, rate = figure.subplots(2, 1, sharex=True)
    for ending, name in MODELS.items():
        run = runs.running[ending]
        colour = COLOURS[ending]
        angle.plot(run.t, run.q("pinion.phi"), color=colour, label=f"{name}, {run.t[-1]:.4f} s")
        rate.plot(run.t, run.v("pinion.phi"), color=colour)
    angle.axhline(DEAD[0], color="#202a33", linewidth=0.8, linestyle=":")
    angle.annotate("dead centre", (0.0, DEAD[0]), (2, -3), textcoords="offset points", va="top")
    angle.set(title=f"Project 8.3: from rest under {TORQUE:g} N m, one period",
              ylabel="φ of the pinion, rad", ylim=(-0.7, 5.4))  # fmt: skip
    angle.legend(loc="upper center", ncols=2)
    rate.set(title="Angular velocity of the pinion", ylabel="φ̇, rad/s", xlabel="t, s",
             xlim=(0, None))  # fmt: skip
    return figure
