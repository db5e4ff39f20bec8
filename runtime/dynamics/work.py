"""Work of effects and drivers: the integral of their power along the steps of a simulation.

A power is smooth within a step and may jump at an event, where a step ends. So a run is made twice:
once to learn where its steps end, and again with output at Gauss' nodes between these ends and the
instants that are asked for. Outputs do not change steps, so both are the same run, and each
interval is integrated to the order of ten. An impact changes velocities at an instant; what it
takes away is no power, and in no work.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.results.result import Result
from runtime.results.samples import Samples

FloatArray = npt.NDArray[np.float64]
PLACES, WEIGHTS = np.polynomial.legendre.leggauss(5)


class Quadrature(NamedTuple):
    """Where the powers of a run are wanted.

    Attributes
    ----------
    edges
        Ends of the intervals, s, (e + 1,).
    nodes
        Gauss' nodes in each, s, (e, 5); NaN where an interval is too short to hold them.
    times
        The instants of the result, among the edges.
    """

    edges: FloatArray
    nodes: FloatArray
    times: FloatArray

    @property
    def instants(self) -> FloatArray:
        """Nodes and instants of the result, increasing."""
        inside = self.nodes[np.isfinite(self.nodes)]
        found: FloatArray = np.unique(np.concatenate([inside, self.times]))
        return found


def laid(begin: float, ends: FloatArray, times: FloatArray | None) -> Quadrature:
    """Nodes for a run from `begin` with steps to `ends`; without `times`, output at these ends."""
    wanted = ends if times is None else times
    last = ends[-1] if len(ends) else begin
    known = wanted[(wanted >= begin) & (wanted <= last)]
    edges = np.unique(np.concatenate([[begin], ends, known]))
    low, high = edges[:-1, None], edges[1:, None]
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * PLACES
    between = np.diff(np.concatenate([low, nodes, high], axis=1), axis=1) > 0.0
    nodes[~between.all(axis=1)] = np.nan
    return Quadrature(edges, nodes, np.unique(wanted))


def with_works(result: Result, plan: Quadrature) -> Result:
    """The result at its own instants, with the works that its scene asks for."""
    samples = result.samples
    order = np.searchsorted(samples.t, plan.nodes)
    reached = order < len(samples.t)
    reached &= samples.t[np.minimum(order, len(samples.t) - 1)] == plan.nodes
    whole = reached.all(axis=1)
    nowhere = np.isnan(plan.nodes).all(axis=1)
    spans = np.diff(plan.edges)
    known = np.logical_and.accumulate(whole | nowhere)
    nodes = plan.nodes[whole].ravel()
    kept = ~np.isin(samples.t, nodes[~np.isin(nodes, plan.times)])
    for name, column in result.description.working.items():
        pieces = np.zeros(len(spans))
        power = samples.power[order[whole], column]
        pieces[whole] = 0.5 * spans[whole] * (power @ WEIGHTS)
        pieces[~known] = np.nan
        total = np.concatenate([[0.0], np.cumsum(pieces)])
        place = np.searchsorted(plan.edges, samples.t[kept])
        exact = plan.edges[np.minimum(place, len(plan.edges) - 1)] == samples.t[kept]
        result.works[name] = np.where(exact, total[np.minimum(place, len(total) - 1)], np.nan)
    result.samples = Samples._make(array[kept] for array in samples)
    return result
