"""One result of runs that follow one another with other joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.object_display import counted
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import DiscreteState
from runtime.results.motion_at_instants import Motion, keep
from runtime.results.result import Result
from runtime.results.run_records import Reconnection, sentences
from runtime.results.samples import Samples
from runtime.results.saved_result import saved_fields

_TABLES = (
    "coordinates", "constraints", "parameters", "effects", "switches", "reactions", "powers"
)  # fmt: skip


def joined(
    results: Sequence[Result], changes: Sequence[Reconnection | None], since: float = -np.inf
) -> Result:
    """One result of runs that follow one another, in the tables of all their machines.

    Between two of them is the change of joints, None where the second goes on past the condition
    that ended the first. The result is that from the instant `since` on, s.
    """
    passed = [change for change in changes if change is not None and change.time > since]
    description = _union([result.description for result in results])
    pieces = [_in_tables(result, description, result.samples) for result in results]
    kept = [np.ones(len(piece.t), np.bool_) for piece in pieces]
    for k in range(1, len(pieces)):
        if len(pieces[k].t) and any(len(p.t) and p.t[-1] == pieces[k].t[0] for p in pieces[:k]):
            kept[k][0] = False
    samples = Samples(
        *(
            np.concatenate([column[rows] for column, rows in zip(columns, kept, strict=True)])
            for columns in zip(*pieces, strict=True)
        )
    )
    last, stats = results[-1], _totals([result.stats for result in results])
    end = last.message.replace(_in_steps(last.stats), _in_steps(stats), 1)
    values = {name: value for one in results for name, value in one.parameters.items()}
    parameters = np.array([values[row.name] for row in description.parameters])
    result = Result(
        description, samples, parameters, analysis=last.analysis, outcome=last.outcome,
        message=" ".join(filter(None, (sentences(passed), end))), stats=stats,
        events=[event for result in results for event in result.events],
        partitions=[one for result in results for one in result.partitions],
        not_unique=tuple(dict.fromkeys(n for result in results for n in result.not_unique)),
        singular=[one for result in results for one in result.singular],
    )  # fmt: skip
    result.contradiction = " ".join(filter(None, (r.contradiction for r in results)))
    result.reconnections, result._mechanism = tuple(passed), results[0]._mechanism
    result.ended_by, result.site = last.ended_by, last.site
    motions = [one._motion for one in results]
    if all(motion is not None for motion in motions):
        result._motion = JoinedMotion(tuple(results), tuple(changes), description, since)
    totals: dict[str, float] = {}
    works: dict[str, list[FloatArray]] = {name: [] for r in results for name in r.works}
    for one, rows in zip(results, kept, strict=True):
        for name, parts in works.items():
            work = one.works.get(name, np.zeros(len(one.t)))
            parts.append(totals.get(name, 0.0) + work[rows])
            totals[name] = totals.get(name, 0.0) + one.work_at_end.get(name, 0.0)
    result.works.update({name: np.concatenate(parts) for name, parts in works.items()})
    if since > -np.inf:
        keep(result, result.t >= since, since, np.inf)
    return result


def _in_steps(stats: Mapping[str, float]) -> str:
    """What the message of a run says of its steps."""
    return f" in {counted(int(stats['steps']), 'step')}."


def _union(descriptions: Sequence[Description]) -> Description:
    """The first description with what the others have besides."""
    first = descriptions[0]
    tables = {}
    for name in _TABLES:
        rows = [row for d in descriptions for row in getattr(d, name)]
        tables[name] = type(getattr(first, name))(dict.fromkeys(rows))
    names = tables["coordinates"].names
    states = dict.fromkeys(row._replace(column=names.index(f"{row.name}.integral"))
                           for d in descriptions for row in d.states)  # fmt: skip
    tables["states"] = type(first.states)(states)
    tables["sampled"] = tuple(dict.fromkeys(name for d in descriptions for name in d.sampled))
    gone = {*tables["effects"]}
    tables["left_out"] = type(first.left_out)(row for row in first.left_out if row not in gone)
    drivers = tuple(dict.fromkeys(name for d in descriptions for name in d.drivers))
    return replace(first, **tables, drivers=drivers)


def _in_tables(result: Result, description: Description, samples: Samples) -> Samples:
    """Samples of a result by the rows of other tables; what does not act exerts nothing."""
    own = result.description

    def spread(values: npt.NDArray[Any], table: str, missing: float) -> npt.NDArray[Any]:
        rows = list(getattr(description, table))
        places = {row: k for k, row in enumerate(getattr(own, table))}
        out = np.full((len(values), len(rows)), missing, values.dtype)
        for k, row in enumerate(rows):
            if row in places:
                out[:, k] = values[:, places[row]]
        return out

    def rows_of(name: str, table: str, missing: float) -> npt.NDArray[Any]:
        return spread(getattr(samples, name), table, missing)

    return samples._replace(
        q=rows_of("q", "coordinates", np.nan), v=rows_of("v", "coordinates", np.nan),
        a=rows_of("a", "coordinates", np.nan), lam=rows_of("lam", "constraints", 0.0),
        reaction=rows_of("reaction", "reactions", 0.0), power=rows_of("power", "powers", 0.0),
        modes=rows_of("modes", "switches", 0), share=rows_of("share", "switches", np.nan),
    )  # fmt: skip


def _totals(stats: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Counts of all runs together; of what is a largest value the largest."""
    largest = {"crossing_error", "largest_correction"}
    return {
        name: (max if name in largest else sum)(one.get(name, 0) for one in stats)
        for name in stats[0]
    }


@dataclass(frozen=True)
class JoinedMotion:
    """The motions behind a joined result."""

    results: tuple[Result, ...]
    changes: tuple[Reconnection | None, ...]  # between them
    description: Description
    since: float = -np.inf  # from where on the result is, s

    @property
    def _motions(self) -> list[Motion]:
        return [one._motion for one in self.results if one._motion is not None]

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant, s."""
        return self._motions[0].span[0], self._motions[-1].span[1]

    @property
    def t_end(self) -> float:
        """The end that was asked for, s."""
        return max(motion.t_end for motion in self._motions)

    def _motion_at(self, t: float) -> Motion:
        """The motion at an instant of the span, s; at a change of joints the one before it."""
        return next((m for m in self._motions if t <= m.span[1]), self._motions[-1])

    def sampled(self, t: float) -> bool:
        """Whether clocks have renewed what is due in the state at an instant of the span, s."""
        return self._motion_at(t).sampled(t)

    def scene(self, t: float) -> str:
        """The scene whose joints act at an instant of the span, s."""
        return self._motion_at(t).scene(t)

    def discrete(self, result: Result, t: float) -> DiscreteState | None:
        """Where clocks and watched conditions stand at an instant; at a change just before it."""
        place = next((k for k, m in enumerate(self._motions) if t <= m.span[1]), -1)
        one, motion = self.results[place], self._motions[place]
        found = motion.discrete(one, t)
        if found is None or one is self.results[-1] or t < motion.span[1]:
            return found
        change, held = self.changes[place], found.stand.held.copy()
        if change is None:
            return found
        held[[row[1:] == (change.action, change.joint) for row in found.watched]] = 0.0  # it begins
        return found._replace(stand=found.stand._replace(held=held))

    def at(self, result: Result, times: FloatArray) -> tuple[Samples, dict[str, FloatArray]]:
        """At ascending instants, (k,), of the span, s; at a change of joints just before it."""
        parts, works = list[Samples](), list[dict[str, FloatArray]]()
        before = dict.fromkeys(result.works, 0.0)
        low = -np.inf
        for one, motion in zip(self.results, self._motions, strict=True):
            high = motion.span[1] if one is not self.results[-1] else np.inf
            here = times[(times > low) & (times <= high)]
            if len(here):
                samples, found = motion.at(one, here)
                parts.append(_in_tables(one, self.description, samples))
                works.append({k: total + found.get(k, 0.0 * here) for k, total in before.items()})
            for name, work in one.work_at_end.items():
                before[name] += work
            low = high
        joined_works = {name: np.concatenate([w[name] for w in works]) for name in result.works}
        return Samples._make(map(np.concatenate, zip(*parts, strict=True))), joined_works

    def saved(self) -> dict[str, Any]:
        """What a file keeps of each of them."""
        source = self._motions[0].saved()["source"]
        parts = [saved_fields(one) for one in self.results]
        changes = list(self.changes)
        return {"source": source, "parts": parts, "changes": changes, "since": self.since}

    def resumed(
        self, result: Result, t_end: Any, t_eval: Any, max_steps: int | None, progress: bool
    ) -> Result:
        """The run up to another end; see `Result.resume`."""
        from runtime.dynamics.resumption import resume  # which stands above

        return resume(result, self, t_end, t_eval, max_steps, progress)
