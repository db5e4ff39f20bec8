"""The joined result of successive runs with different joints, and its motion at any instant."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.object_display import counted
from runtime.dynamics.motion_at_instants import Found, resumed
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
_COLUMNS = {
    **dict.fromkeys("qva", ("coordinates", np.nan)), "lam": ("constraints", 0.0),
    "reaction": ("reactions", 0.0), "power": ("powers", 0.0), "modes": ("switches", 0),
    "share": ("switches", np.nan),
}  # fmt: skip
"""Samples → the table of their columns, and what stands where a machine has no such row."""
_LARGEST = {"crossing_error", "largest_correction"}  # entries of statistics that are no counts

Change = tuple[Reconnection, ...]
"""The joints that come or go at one instant."""


def joined(
    results: Sequence[Result], changes: Sequence[Change], since: float = -np.inf, told: int = 0
) -> Result:
    """One result of runs that follow one another, in the tables of all their machines.

    Between two of them is the change of joints, empty where the second goes on past the condition
    that ended the first. The result is that from the instant `since` on, s; an earlier one has told
    the first of the changes, so many.
    """
    passed = [one for change in changes[told:] for one in change if one.time >= since]
    description = _union([result.description for result in results])
    parts, ends = [], set[float]()
    final = results[-1].t[0] if len(results[-1].t) == 1 else np.inf  # perhaps just behind a change
    for k, one in enumerate(results):
        last = np.inf if one is results[-1] else min(final, since if k < told else np.inf)
        rows = one.t < last
        rows[:1] &= not (len(one.t) and float(one.t[0]) in ends)
        ends.update(one.t[rows][-1:].tolist())
        parts.append(
            (one, one.samples.at(rows), {name: work[rows] for name, work in one.works.items()})
        )
    names = dict.fromkeys(name for one in results for name in one.works)
    samples, works = _one_after_another(parts, description, names)
    last, stats = results[-1], dict[str, float]()
    for name in results[0].stats:
        counts = [one.stats.get(name, 0) for one in results]
        stats[name] = max(counts) if name in _LARGEST else sum(counts)
    own, all_steps = (f" in {counted(int(n['steps']), 'step')}." for n in (last.stats, stats))
    end = last.message.replace(own, all_steps, 1)
    held = [one._held.strip() for one in results[told:-1]]
    values = {name: value for one in results for name, value in one.parameters.items()}
    result = Result(
        description, samples, np.array([values[row.name] for row in description.parameters]),
        analysis=last.analysis, outcome=last.outcome,
        message=" ".join(filter(None, (sentences(passed), *held, end))), stats=stats,
        events=tuple(event for one in results for event in one.events),
        partitions=tuple(choice for one in results for choice in one.partitions),
        not_unique=tuple(dict.fromkeys(name for one in results for name in one.not_unique)),
        singular=tuple(position for one in results for position in one.singular),
        contradiction=" ".join(filter(None, (one.contradiction for one in results))),
        reconnections=tuple(passed), ended_by=last.ended_by, site=last.site, works=works,
        _mechanism=results[0]._mechanism,
    )  # fmt: skip
    if all(one._motion is not None for one in results):
        result._motion = JoinedMotion(tuple(results), tuple(changes), description, since, told)
    if since > -np.inf:
        keep(result, result.t >= since, since, np.inf)
    return result


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


def _one_after_another(
    parts: Iterable[tuple[Result, Samples, Mapping[str, FloatArray]]], description: Description,
    names: Iterable[str],
) -> Found:  # fmt: skip
    """Samples and works of parts in a row: what does not act exerts nothing, and works go on."""
    tables, works, before = [], [], dict.fromkeys(names, 0.0)
    for one, samples, found in parts:
        tables.append(_in_tables(one.description, description, samples))
        none = np.zeros(len(samples.t))
        works.append({name: total + found.get(name, none) for name, total in before.items()})
        for name, work in one.work_at_end.items():
            before[name] += work
    return Samples.joined(tables), {
        name: np.concatenate([work[name] for work in works]) for name in before
    }


def _in_tables(own: Description, description: Description, samples: Samples) -> Samples:
    """Samples by the rows of other tables."""
    fields = dict[str, npt.NDArray[Any]]()
    for name, (table, missing) in _COLUMNS.items():
        values, rows = getattr(samples, name), list(getattr(description, table))
        places = {row: k for k, row in enumerate(getattr(own, table))}
        fields[name] = np.full((len(values), len(rows)), missing, values.dtype)
        for k, row in enumerate(rows):
            if row in places:
                fields[name][:, k] = values[:, places[row]]
    return samples._replace(**fields)


@dataclass(frozen=True)
class JoinedMotion:
    """The motions behind a joined result."""

    results: tuple[Result, ...]
    changes: tuple[Change, ...]  # between them
    description: Description
    since: float = -np.inf  # from where on the result is, s
    told: int = 0  # changes before that

    @cached_property
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

    @property
    def behind(self) -> float:
        """That of the first part."""
        return self._motions[0].behind

    @cached_property
    def _bounds(self) -> list[float]:
        """Up to where the parts last, s: up to a change, but for one at an end of the whole."""
        *ends, last = (motion.span[1] for motion in self._motions)
        before = [self.since if k < self.told else last for k in range(len(ends))]
        return [*np.minimum(ends, np.nextafter(before, -np.inf)).tolist(), np.inf]

    def _place(self, t: float) -> int:
        """The part at an instant of the span, s; at a change of joints the one before it."""
        return next(k for k, bound in enumerate(self._bounds) if t <= bound)

    def scene(self, t: float) -> str:
        """The scene whose joints act at an instant of the span, s."""
        return self._motions[self._place(t)].scene(t)

    def clocks(self, result: Result, t: float) -> tuple[bool, DiscreteState | None]:
        """Where clocks and conditions stand at an instant, s; at a change just before it."""
        place = self._place(t)
        return self._motions[place].clocks(self.results[place], t)

    def at(self, result: Result, times: FloatArray) -> Found:
        """At ascending instants, (k,), of the span, s; at a change of joints just before it."""
        parts, low = [], -np.inf
        for one, motion, high in zip(self.results, self._motions, self._bounds, strict=True):
            here, low = times[(times > low) & (times <= high)], high
            none: Found = one.samples.at(slice(0)), {}
            parts.append((one, *(motion.at(one, here) if len(here) else none)))
        return _one_after_another(parts, self.description, result.works)

    def saved(self) -> dict[str, Any]:
        """What a file keeps of each of them."""
        source, parts = self._motions[0].saved()["source"], [*map(saved_fields, self.results)]
        return {"source": source, "parts": parts, "changes": [*self.changes], "since": self.since,
                "told": self.told}  # fmt: skip

    resumed = resumed
