"""Pictures of section 5.5: the two mechanisms, their motion, and the torques."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from models.studies.gear_slider import (
    CRANK,
    DRIVERS,
    OFFSET,
    OFFSETS,
    PLANET,
    ROD,
    SPEED,
    Study,
    study,
)
from models.studies.mechanism import machine, mark, millimetres, trace
from models.studies.paths import path
from runtime import Result

TEAL, RED, BLUE = "#00798c", "#d1495b", "#30638e"
WORDS = {"train": "pinion", "planetary": "carrier"}


def figures() -> Iterator[tuple[str, Figure]]:
    """(section and number of the picture, picture)."""
    runs = study()
    yield "5_5_1", _machines(runs)
    yield "5_5_2", _motion(runs)
    yield "5_5_3", _torques(runs)


def _machines(runs: Study) -> Figure:
    """The train an eighth of a turn of the wheel on, and the planetary gear likewise."""
    figure = Figure(figsize=(7.5, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.35, 1))
    _train(left, runs.moved["train"], 1260)
    _planetary(right, runs.moved["planetary"], 180)
    for axes in (left, right):
        millimetres(axes)
    left.set(title="The train", xlabel="x, mm", ylabel="y, mm", aspect="equal")
    right.set(title="The planetary gear", xlabel="x, mm", aspect="equal")
    return figure


def _train(axes: Axes, run: Result, k: int) -> None:
    places = {"A": ("pinion", 0), "B": ("wheel", 0), "P": ("wheel", CRANK), "C": ("rod", ROD / 2)}
    machine(axes, run, k)
    trace(axes, path(run, "wheel", CRANK).at, RED)
    trace(axes, path(run, "slider").at, TEAL)
    axes.axhline(OFFSET, color="#202a33", linewidth=0.6, linestyle=":", zorder=1)
    for name, place in places.items():
        mark(axes, path(run, *place).at[k], name, (-3, 14) if name == "C" else (6, 6))


def _planetary(axes: Axes, run: Result, k: int) -> None:
    machine(axes, run, k)
    trace(axes, path(run, "planet", PLANET).at, TEAL)
    trace(axes, path(run, "planet").at, RED)
    mark(axes, path(run, "carrier", -PLANET / 2).at[k], "O", (-14, 6))
    mark(axes, path(run, "planet", PLANET).at[k], "C", (6, 8))


def _motion(runs: Study) -> Figure:
    """Where the sliders are and how fast, over the angle of the body that is driven."""
    figure = Figure(figsize=(7.5, 5.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex="col", width_ratios=(1.35, 1))
    for offset, colour in zip(OFFSETS, (TEAL, RED, BLUE), strict=True):
        _over_angle(panels[:, 0], runs.offsets[offset], colour, f"e = {1e3 * offset:g} mm")
    _over_angle(panels[:, 1], runs.moved["planetary"], TEAL, None)
    panels[0, 0].set(title="The train, guide e above the centre", ylabel="x, mm")
    panels[0, 0].legend(loc="upper center")
    panels[0, 1].set(title="The planetary gear: x = 120 cos φ")
    panels[1, 0].set(xlabel="φ of the pinion, degrees", ylabel="ẋ, m/s", xlim=(0, 720),
                     xticks=range(0, 721, 180))  # fmt: skip
    panels[1, 1].set(xlabel="φ of the carrier, degrees", xlim=(0, 360), xticks=range(0, 361, 90))
    return figure


def _over_angle(panels: np.ndarray, run: Result, colour: str, label: str | None) -> None:
    turned = np.degrees(SPEED * run.t)
    panels[0].plot(turned, 1e3 * run.q("slider.x"), color=colour, label=label)
    panels[1].plot(turned, run.v("slider.x"), color=colour)


def _torques(runs: Study) -> Figure:
    """Driving torques at constant speed, and the train on a motor."""
    figure = Figure(figsize=(7.5, 5.6), layout="constrained")
    panels = figure.subplots(3, 1)
    for axes, (name, run) in zip(panels, runs.driven.items(), strict=False):
        torque = run.reaction(DRIVERS[name], "torque")
        axes.plot(np.degrees(SPEED * run.t), torque, color=TEAL)
        end = 720 if name == "train" else 360
        axes.set(title=f"{name.capitalize()}: torque on the {WORDS[name]} at 4π rad/s",
                 xlabel=f"φ of the {WORDS[name]}, degrees", ylabel="T, N m", xlim=(0, end),
                 xticks=range(0, end + 1, end // 8))  # fmt: skip
    run = runs.running
    panels[2].plot(run.t, run.v("pinion.phi"), color=BLUE)
    panels[2].set(title=f"Train: from rest, {run.parameters['pinion_torque']:g} N m on the pinion",
                  xlabel="t, s", ylabel="φ̇, rad/s", xlim=(0, run.t[-1]))  # fmt: skip
    return figure
