"""Work of effects and drivers: the integral of their power along the steps of a simulation.

A power is smooth within a step and may jump at an event, where a step ends. So a run with works
samples each step at Gauss' nodes of the intervals between its ends and the output instants in it
(`runtime.integrate.sampling`), which integrates each interval to the order of ten. An impact
changes velocities at an instant; the energy that it takes away is no power, and in no work.
"""

import numpy as np
import numpy.typing as npt

from runtime.integrate.sampling import INTERVAL, WEIGHTS
from runtime.mechanism.dense_equations import FloatArray
from runtime.results.result import Result
from runtime.results.samples import Samples


def along_intervals(t: FloatArray, power: FloatArray) -> FloatArray:
    """Integrals of a power, W, over the intervals of a quadrature: (k,) each, k samples of it."""
    nodes = power[1:].reshape(-1, INTERVAL)[:, :-1]
    pieces: FloatArray = 0.5 * np.diff(t[::INTERVAL]) * (nodes @ WEIGHTS)
    return pieces


def integrate_works(result: Result, count: int, times: npt.ArrayLike | None) -> None:
    """Add the works that its scene asks for to a result, and drop the samples at nodes.

    The result's run has the start as its first sample, then for each interval its nodes and its
    end: `count` samples; possibly then the state in which it stopped. `times` are the output
    instants in s; None: the end of every step.
    """
    samples = result.samples
    ends = samples.t[:count:INTERVAL]
    kept = np.zeros(len(samples.t), dtype=np.bool_)
    kept[:count:INTERVAL] = True if times is None else np.isin(ends, times)
    if result.failed or result.ended_by:
        kept[-1:] = True
    for name, column in result.description.work_rows.items():
        pieces = along_intervals(samples.t[:count], samples.power[:count, column])
        work = np.full(len(samples.t), np.nan)
        work[:count:INTERVAL] = np.concatenate([[0.0], np.cumsum(pieces)])[: len(ends)]
        result.works[name] = work[kept]
        result.work_at_end[name] = float(pieces.sum())
    result.samples = Samples._make(array[kept] for array in samples)
