"""Runs of a search, also those in which joints come and go, and the values of quantities."""

import time as clock
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.accuracy_target.error_norms import group_magnitude, series_values
from runtime.dynamics.connected_simulation import simulate
from runtime.dynamics.formulations import formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import run_prepared
from runtime.integrate.problem import Formulation, Options, Partitions, Statistics, Trajectory
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result
from runtime.results.run_records import Trial


@dataclass(frozen=True)
class Quantities:
    """Series of a run whose errors count."""

    names: tuple[str, ...]
    scales: FloatArray  # typical sizes, (c,); NaN: the largest value in the run of it or its whole
    state_columns: npt.NDArray[np.int64]  # in [q, v], (c,); -1: of a result, such as a reaction

    @property
    def are_states(self) -> bool:
        """Whether all are coordinates and velocities."""
        return bool(np.all(self.state_columns >= 0))

    def of_result(self, result: Result) -> FloatArray:
        """The values, (k, c)."""
        return series_values(result, self.names)

    def wholes(self, result: Result) -> FloatArray:
        """Magnitudes of the wholes that the series are parts of, (c,); 0 of those with a size."""
        sizes = zip(self.names, np.isnan(self.scales), strict=True)
        return np.array([group_magnitude(result, name) if free else 0.0 for name, free in sizes])


def quantities_of(
    description: Description, names: Sequence[str] | None, sizes: FloatArray
) -> Quantities:
    """The quantities of these names: all that is integrated without `names`.

    `sizes`, (n,): of coordinates, and of velocities per second. A result refuses unknown names.
    """
    if names is not None and not len(names):
        raise InputError(
            f"{description.title}: quantities is {names!r}; it must be names of series, such as "
            f'("{description.coordinates.names[0]}",).'
        )
    rows = description.coordinates
    states = [*rows.names, *(row.velocity for row in rows)]
    column = {name: k for k, name in enumerate(states)}
    chosen = description.variables if names is None else tuple(dict.fromkeys(names))
    state_columns = np.array([column.get(name, -1) for name in chosen], dtype=np.int64)
    both = np.concatenate([sizes, sizes, [np.nan]])
    return Quantities(chosen, both[state_columns], state_columns)


@dataclass
class Run:
    """A run with the settings that it had."""

    formulation: Formulation
    options: Options
    path: Trajectory
    values: FloatArray  # of the quantities, (≥ k, c); of a run that a condition ended, there too
    wholes: FloatArray  # magnitudes of the wholes that they are parts of, (c,) or (1,)
    ended_by: str  # the condition that ended it
    instants: dict[str, float]  # of joints that came or went, of that end, s
    result: Result | None  # of a run in which joints come and go
    difference: float | None = None  # largest, from the run with which it was compared

    @property
    def t(self) -> FloatArray:
        """Instants that are compared with those of the same time in other runs, s."""
        path = self.path
        return path.t[path.t < path.final_t] if self.ended_by else path.t

    @property
    def record(self) -> Trial:
        """Settings, cost and outcome."""
        counts, options = self.path.statistics, self.options
        return Trial(
            options.method, self.formulation, options.rtol, counts.seconds, counts.rhs,
            counts.steps, counts.events, self.path.outcome.name, self.difference,
        )  # fmt: skip


def own_instants(result: Result) -> dict[str, float]:
    """The instants of a run's changes and of its end by a condition, s: ``t(latch)#2``."""
    ends = [(result.ended_by, float(result.t[-1]))] if result.ended_by else []
    found, counts = dict[str, float](), Counter[str]()
    for name, t in [*((one.joint, one.time) for one in result.reconnections), *ends]:
        counts[name] += 1
        found[f"t({name})" if counts[name] == 1 else f"t({name})#{counts[name]}"] = t
    return found


def run_with_reconnections(
    ready: PreparedSimulation, formulation: Formulation, options: Options, progress: Progress
) -> tuple[Result, Trajectory]:
    """A run in which joints come and go: its result, and one trajectory of all its parts."""
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
        return run_prepared(coordinates, chosen, began, silent, paths[-1], repeats=True)

    result = simulate(
        ready.mechanism, ready.t_end, options.t_eval, part=part, max_steps=options.max_steps,
        **ready.given,
    )  # fmt: skip
    return result, _as_one(paths, result, options.t_eval)


def _as_one(paths: Sequence[Trajectory], result: Result, t_eval: Any) -> Trajectory:
    """The last of the parts with the samples of all, in all coordinates, and with all costs."""
    first, samples = paths[0], result.samples
    rows, chosen = np.isin(samples.t, t_eval), first.partitions.independent
    chosen = np.pad(chosen, ((0, 0), (0, samples.q.shape[1] - chosen.shape[1])))
    counts = [vars(path.statistics) for path in paths]
    total = {name: sum(one[name] for one in counts) for name in counts[0]}
    total["largest_dq"] = max(one["largest_dq"] for one in counts)
    ended = {"final_q": samples.q[-1], "final_v": samples.v[-1]} if result.ended_by else {}
    return paths[-1]._replace(
        t=samples.t[rows], q=samples.q[rows], v=samples.v[rows], outcome=result.outcome,
        first_t=first.first_t, statistics=Statistics(**total),
        partitions=Partitions(first.partitions.t, chosen),
        methods=tuple(method for path in paths for method in path.methods),
        decay=max(path.decay for path in paths), **ended,
    )  # fmt: skip
