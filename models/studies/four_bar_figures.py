"""Pictures of section 5.3: the coupler curve, the motion, and the lock-up."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from models.studies.four_bar import SHORT, SPEED, Study, study, tracer
from models.studies.mechanism import machine, mark, trace
from models.studies.paths import ComplexArray, path
from runtime import Result

TEAL, RED, BLUE = "#00798c", "#d1495b", "#30638e"


def figures() -> Iterator[tuple[str, Figure]]:
    """(section and number of the picture, picture)."""
    runs = study()
    yield "5_3_1", _curve(runs)
    yield "5_3_2", _motion(runs)
    yield "5_3_3", _lock_up(runs)


def _joints(run: Result) -> tuple[ComplexArray, ...]:
    """A, B, C, D over time."""
    half = run.parameters["AB"] / 2
    ends = path(run, "crank", -half).at, path(run, "crank", half).at
    return *ends, path(run, "coupler").at, path(run, "rocker", -run.parameters["CD"] / 2).at


def _curve(runs: Study) -> Figure:
    """The coupler curve with the linkage in three positions, and how straight it is."""
    figure = Figure(figsize=(7.5, 4.4), layout="constrained")
    plane, error = figure.subplots(1, 2, width_ratios=(1.35, 1))
    curve, joints = tracer(runs.turn).at, _joints(runs.turn)
    trace(plane, curve, RED, "path of P")
    for degrees in (180, 270, 90):
        k = 2 * degrees
        machine(plane, runs.turn, k, faint=degrees != 90)
    k = 180
    points = zip("ABCDP", (*(joint[k] for joint in joints), curve[k]), strict=True)
    for name, point in points:
        mark(plane, point, name, (7, -10) if name == "C" else (6, 4))
    plane.set(
        title="Coupler curve; φ₁ = 90°, 180°, 270°", xlabel="x, m", ylabel="y, m", aspect="equal"
    )
    plane.margins(0.1)
    part = slice(170, 551)
    error.plot(np.degrees(SPEED * runs.turn.t[part]), 1e3 * (curve.imag[part] - 4), color=RED)
    error.set(
        title="Height of P over y = 4 m",
        xlabel="φ₁, degrees",
        ylabel="mm",
        xlim=(85, 275),
        xticks=range(90, 271, 45),
        ylim=(-0.5, 12),
    )
    return figure


def _motion(runs: Study) -> Figure:
    """Angles, angular velocities, and the driving torque over a turn."""
    figure = Figure(figsize=(7.5, 6.6), layout="constrained")
    angles, rates, torques = figure.subplots(3, 1, sharex=True)
    turn = np.degrees(SPEED * runs.turn.t)
    for body, name, colour in (("coupler", "₃", TEAL), ("rocker", "₄", RED)):
        angles.plot(turn, np.degrees(runs.turn.q(f"{body}.phi")), color=colour, label=f"φ{name}")
        rates.plot(turn, runs.turn.v(f"{body}.phi"), color=colour, label=f"φ̇{name}")
    torques.plot(turn, runs.driven.reaction("crank_drive", "torque"), color=BLUE)
    angles.set(title="5.3: angles, crank at 2π rad/s", ylabel="degrees")
    rates.set(title="Angular velocities", ylabel="rad/s")
    torques.set(
        title="Driving torque, rods of 1 kg/m under gravity",
        ylabel="T, N m",
        xlabel="φ₁, degrees",
        xlim=(0, 360),
        xticks=range(0, 361, 45),
    )
    angles.legend(ncols=2)
    rates.legend(ncols=2)
    return figure


def _lock_up(runs: Study) -> Figure:
    """The linkage stretched, and the rates of the bars on the way there."""
    figure = Figure(figsize=(7.5, 3.5), layout="constrained")
    plane, rates = figure.subplots(1, 2, width_ratios=(1.1, 1))
    run = runs.locked
    joints = _joints(run)
    machine(plane, run, 0, faint=True)
    machine(plane, run, -1)
    trace(plane, joints[1], TEAL, "B")
    trace(plane, joints[2], RED, "C")
    for name, joint in zip("ABCD", joints, strict=True):
        mark(plane, joint[-1], name, (-12, 6) if name == "B" else (4, 7))
    end = np.degrees(run.q("crank.phi")[-1])
    plane.set(
        title=f"BC = CD = {SHORT:g} m: locked at φ₁ = {end:.4f}°",
        xlabel="x, m",
        ylabel="y, m",
        aspect="equal",
        xlim=(-1.1, 2.3),
        ylim=(-0.45, 1.6),
    )
    plane.legend(title="path of", loc="upper left", ncols=2)
    turn = np.degrees(run.q("crank.phi"))
    for body, name, colour in (("coupler", "₃", TEAL), ("rocker", "₄", RED)):
        # The last sample is the lock-up itself, where the rates are infinite.
        rates.plot(turn[:-1], run.v(f"{body}.phi")[:-1], color=colour, label=f"φ̇{name}")
    rates.axvline(end, color="#202a33", linewidth=0.8, linestyle=":")
    rates.set(
        title="Angular velocities",
        xlabel="φ₁, degrees",
        ylabel="rad/s",
        xlim=(0, 150),
        ylim=(-40, 40),
    )
    rates.legend(loc="upper left")
    return figure
