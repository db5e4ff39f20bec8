"""Switching: a machine that stalls on its boundary, a cam far too fast, a law that jumps."""

from functools import cache
from math import log, pi

import numpy as np

from models.hard.suite.case import Array, Case, Reference, coordinates, table
from models.hard.suite.closed import steps_of_force
from models.hard.suite.closed_linkages import stall
from runtime import Result

STALL_INERTIA = 225.0
JUMPS = np.linspace(0.0, 4.0, 161)

SEPARATION = 1333.692329329099
"""Camshaft speed at which a cam of 0.2 mm eccentricity loses a rigid follower, rad/s.

The zero of the least contact force, (m3 + m5) s̈ + J4 θ' (θ' s̈ + θ'' ṡ²) + k (ℓ0 - ℓ + s).
"""

CAM, LEVEL = 2e-4, 0.0125 - 0.0025 + 0.15 - 0.075


@cache
def _stall() -> Reference:
    time, place = stall(STALL_INERTIA)
    # The crank is braked by 550 rad/s² in the end: a speed wrong by 30 rtol shifts the instant by
    # 0.06 s rtol, and by the energy the place by 30 · 30 rtol / 550 rad.
    values, times = np.array([time, place]), np.array([time, time])
    return Reference(values, times, np.array([0.06, 1.7]), 30, np.array([1e-15, 1e-14]))


def _stalled(run: Result) -> Array:
    """When the motion came to lie on a boundary, and where the crank is at the end."""
    sliding = [event.time for event in run.events if event.direction == 0]
    return np.array([sliding[0] if sliding else np.nan, run.q("crank.phi")[-1]])


def _work_until_stall(run: Result) -> Array:
    """Motor and gas, J: the slider only moves right."""
    x = run.q("slider.x")
    full = np.clip(x, 1.5, 5.0)
    gas = 282857 * np.array([log((6 - at) / 4.5) for at in full]) + 62857 * (full - 1.5)
    out = np.clip(x, 5.0, 5.5)
    gas -= 110000 * (out - 5 + np.cos(2 * pi * (out - 5.25)) / (2 * pi))
    return np.asarray(41450.0 * (run.q("crank.phi") - pi) + gas)


@cache
def _thrown() -> Reference:
    rows = table("valve_lifter_thrown.csv")
    times, last = rows[:-1, 0], rows[-1]
    # A flight of 4 cm/s more lands later by its share; measured: 7e3 m per metre of the start.
    values = np.concatenate([times, [LEVEL + last[2]]])
    grown = np.concatenate([np.geomspace(0.1, 1e2, len(times)), [7e3]])
    return Reference(values, np.append(times, last[0]), grown, 100, 1e-15)


def _landings(run: Result) -> Array:
    """Every time at which the follower leaves or lands, s, and its place at the end, m."""
    touch = next(row for row in run.description.switches if row.condition.endswith("> 0"))
    name = f"{touch.name}: {touch.condition}"
    # The run starts on the contact's boundary, to rounding: whether it touches there from the first
    # instant on, or from 1e-10 s later, is not asked.
    times = [event.time for event in run.events if event.name == name and event.time > 1e-8]
    return np.append(times, run.q("pushrod.y")[-1])


@cache
def _jumps() -> Reference:
    z = steps_of_force(JUMPS, 20.0, ((1.0, 2.0), (2.0, -4.0), (3.0, 2.0)))
    return Reference(0.5 + z[:, None], JUMPS, 1.0, 120, 1e-14)


CASES = (
    Case(
        name="compressor_stall",
        hard=(
            "Section 8.2.4 with J1 = 225 kg m²: the crank stops where the gas drives "
            "it back from both sides. A method without sliding modes chatters here for ever."
        ),
        see="Time and place of the stall to 1e-9; then rest.",
        model="slider_crank",
        scene="compressor",
        t_end=10.0,
        quantity="time of the stall in s, φ1 at the end in rad",
        measure=_stalled,
        reference=_stall,
        origin="quadrature of the energy integral in 25 digits",
        sampled=False,
        parameters={"J1": STALL_INERTIA},
        work=_work_until_stall,
        options={"max_steps": 100_000},
    ),
    Case(
        name="cam_thrown",
        hard=(
            "A cam at ten times the speed at which its follower leaves: impacts on a "
            "contact of 2e7 N/m with a damper that must not pull."
        ),
        see=(
            "No landing is missed; an error at the start is seven thousand times as "
            "large at the end."
        ),
        model="valve_lifter",
        scene="free_follower",
        t_end=0.05,
        quantity="times of leaving and landing in s, y of the pushrod at the end in m",
        measure=_landings,
        reference=_thrown,
        origin=(
            "hand-reduced equation of one freedom, extrapolation of order 20 in 34 "
            "digits, contacts located to 1e-25 s; growth by a second run from 1e-22 "
            "m away"
        ),
        sampled=False,
        tolerances=(1e-6, 1e-9, 1e-12),
        parameters={"e": CAM, "speed": 10 * SEPARATION},
        start={"pushrod.y": LEVEL + 0.0025 - CAM},
    ),
    Case(
        name="law_with_jumps",
        hard="A motion law whose acceleration jumps at 1, 2 and 3 s.",
        see="Three events; the method keeps its order across them.",
        model="hard/jump_law",
        scene="aboard",
        t_end=4.0,
        quantity="x of the load, m",
        measure=coordinates("load.x"),
        reference=_jumps,
        origin="closed form, a step response a jump",
    ),
)
