"""Parallel cranks and equal rods: on the branch of continuous velocity each is one rotor."""

import mpmath as mp
import numpy as np

from models.hard.suite.case import Array
from models.hard.suite.closed import DIGITS, Number, OneFreedom, pendulum, washboard

G = 9.81
STEP = 1e-6


def rotor(loops: int) -> float:
    """k in ψ̈ = k sin ψ, 1/s², for a row of loops: ψ from the upright position."""
    inertia = (loops + 1) / 3 + loops  # cranks of 1 kg about their ends, couplers that only travel
    return G * ((loops + 1) / 2 + loops) / inertia


def crank_angle(loops: int, times: Array, speed: float = 1.0) -> Array:
    """φ of the cranks of `n_four_bar`, rad, `speed` rad/s at the start."""
    return np.pi / 2 - washboard(times, np.pi, speed, rotor(loops))


def crank_growth(loops: int, times: Array) -> Array:
    """What an error of one unit of tolerance has become, as `Reference.growth`, shape (k,).

    The speed is largest at the bottom, ω_b, where the tolerance for it is ω_b rtol; it changes
    the energy as an error of ω_b² rtol at the top does, where the speed is 1 rad/s.
    """
    apart = crank_angle(loops, times, 1 + STEP) - crank_angle(loops, times, 1 - STEP)
    return _envelope(apart / (2 * STEP), 1.0 + 4 * rotor(loops))


def table_angle(cranks: int, times: Array, begin: float = np.pi / 3) -> Array:
    """φ of the cranks of `parallel_linkage` let go at `begin`, rad."""
    return pendulum(times, begin + np.pi / 2, _table(cranks)) - np.pi / 2


def table_growth(cranks: int, times: Array) -> Array:
    """As `crank_growth`: ω_b² rtol at the bottom changes the swing by ω_b² / (k sin θ0) rtol."""
    swing = 5 * np.pi / 6
    k = _table(cranks)
    apart = table_angle(cranks, times, np.pi / 3 + STEP) - table_angle(
        cranks, times, np.pi / 3 - STEP
    )
    fastest = 2 * k * (1 - np.cos(swing))
    return _envelope(apart / (2 * STEP), fastest / (k * np.sin(swing)))


def _table(cranks: int) -> float:
    """k in θ̈ = -k sin θ, 1/s²: cranks of 1 kg and 1 m, a table of 5 kg that only travels."""
    return G * (cranks / 2 + 5) / (cranks / 3 + 5)


def _envelope(sensitivity: Array, factor: float) -> Array:
    """The largest so far, times what an error is worth."""
    return np.asarray(1.0 + factor * np.maximum.accumulate(np.abs(sensitivity)))


def equal_rods_angle(times: Array, speed: float = 2.0) -> Array:
    """φ of the crank of `equal_rods` whose slider goes through A, rad; nothing works on it."""
    with mp.workdps(DIGITS):
        rotor = OneFreedom(_equal_rods, mp.mpf(np.pi / 4), mp.mpf(speed))
        return np.array([float(rotor.periodic(float(t))) for t in times])


def _equal_rods(phi: Number) -> tuple[Number, Number]:
    """Inertia felt: rod at -φ, slider at 2 cos φ; crank and rod of 1 kg and 1 m, slider of 1 kg."""
    s, c = mp.sin(phi), mp.cos(phi)
    crank, slider = mp.mpf(1) / 3, 4 * s**2
    rod = (3 * s / 2) ** 2 + (c / 2) ** 2 + mp.mpf(1) / 12
    return crank + rod + slider, mp.mpf(0)
