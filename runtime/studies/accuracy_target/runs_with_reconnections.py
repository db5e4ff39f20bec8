"""Runs in which joints come and go: their result, and one trajectory of all their parts."""

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from runtime.dynamics.connected_simulation import simulate
from runtime.dynamics.formulations import formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import finish_simulation
from runtime.integrate.problem import Formulation, Options
from runtime.integrate.trajectory import Partitions, Statistics, Trajectory
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result

_LARGEST = {"largest_dq"}  # entries of statistics that are no counts


def run_with_reconnections(
    ready: PreparedSimulation, given: Mapping[str, Any], formulation: Formulation,
    options: Options, progress: Progress,
) -> tuple[Result, Trajectory]:  # fmt: skip
    """A run from the start that was prepared from what is `given`, and its samples as a trajectory.

    Each part returns onto the constraints as `options` say, or as its own constraints ask for.
    """
    paths: list[Trajectory] = []

    def part(
        mechanism: Mechanism, t_end: float, t_eval: Any, max_steps: int | None, **start: Any
    ) -> Result:
        began = clock.perf_counter()
        own = PreparedSimulation(mechanism, t_end, **start)
        coordinates = formulate(own, formulation, options.method, options.correction)
        chosen = replace(
            options, t_eval=own.instants(t_eval), max_steps=max_steps,
            correction=coordinates.correction,
        )  # fmt: skip
        paths.append(own.run(coordinates, chosen, progress))
        return finish_simulation(own, coordinates, chosen, began, silent, paths[-1], repeats=True)

    result = simulate(
        ready.mechanism, ready.t_end, options.t_eval, part=part, max_steps=options.max_steps,
        **given,
    )  # fmt: skip
    return result, _as_one(paths, result, np.asarray(options.t_eval))


def _as_one(paths: Sequence[Trajectory], result: Result, t_eval: Any) -> Trajectory:
    """The last of the parts with the samples of all, in all coordinates, and with all costs."""
    first, last, samples = paths[0], paths[-1], result.samples
    rows = np.isin(samples.t, t_eval)
    chosen = first.partitions.independent
    independent = np.zeros((len(chosen), samples.q.shape[1]), np.bool_)
    independent[:, : chosen.shape[1]] = chosen
    counts = [vars(path.statistics) for path in paths]
    total = {
        name: (max if name in _LARGEST else sum)(one[name] for one in counts) for name in counts[0]
    }
    ended = {"final_q": samples.q[-1], "final_v": samples.v[-1]} if result.ended_by else {}
    return replace(
        last, t=samples.t[rows], q=samples.q[rows], v=samples.v[rows], modes=samples.modes[rows],
        outcome=result.outcome, first_t=first.first_t, statistics=Statistics(**total),
        partitions=Partitions(first.partitions.t, independent),
        methods=tuple(method for path in paths for method in path.methods),
        decay=max(path.decay for path in paths), checkpoints=None, **ended,
    )  # fmt: skip
