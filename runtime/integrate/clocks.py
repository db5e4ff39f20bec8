"""The clocks of sampled values: their periods, and where they stand at the start of a run."""

import numpy as np

from codegen.errors import InputError
from runtime.core.arrays import EPS, Integers, Matrix, Vector
from runtime.core.system import System

CLOCK = 8.0 * EPS  # accuracy: of the time; instants nearer to each other are one
_MOST_WAITING = 1_000_000  # safety: samples that may wait for their delay at the same time


def read_clocks(system: System, p: Vector) -> Matrix:
    """Period and delay of each sampled value, s, (count, 2); InputError where one is no time."""
    clocks, names = np.zeros((len(system.sampled), 2)), system.sampled_names
    if not len(clocks):
        return clocks
    system.clocks(p, clocks.ravel())
    every, delay = clocks.T
    bad = ~((every > 0.0) & (delay >= 0.0) & np.isfinite(every) & (delay <= _MOST_WAITING * every))
    problems = [
        f"The period of '{names[k]}' is {every[k]:g} s and its delay {delay[k]:g} s; give a "
        f"positive period, and a delay from 0 to {_MOST_WAITING} periods."
        for k in np.flatnonzero(bad)
    ]
    if problems:
        raise InputError(problems)
    return clocks


def queue_length(clocks: Matrix) -> int:
    """Samples of one value that wait for their delay at the same time, at most."""
    return int(np.max(np.ceil(clocks[:, 1] / clocks[:, 0]), initial=0.0)) + 2


def set_clocks(t: float, clocks: Matrix, ticks: Integers, *, taken: bool = False) -> None:
    """Write the numbers of each value's next sample, and of the next that acts, at the start t.

    Samples of the instant t itself are taken then, unless they have been `taken`.
    """
    for k, (every, _) in enumerate(clocks):
        first = int(np.ceil((t - CLOCK * abs(t)) / every))
        if taken and first * every <= t + CLOCK * abs(t):
            first += 1
        ticks[2 * k : 2 * k + 2] = first
