"""Simulations in which joints come and go: one run after the other, each with those that act.

Every set of joints is a scene of its own, with its own module, coordinates and partition. A run
ends where joints are released or engage, all those whose conditions begin to hold at one instant,
and the next begins there. Positions and velocities stay, but for velocities that a joint which
engages does not permit: these end in one impact of all constraints of the new set, M Δv + Φ_qᵀ Λ =
Gᵀ P, Φ_q (v + Δv) = ν, in which closed contacts and freewheels take part by their impulses P ≥ 0.
What an impact makes true is a change of its own, at the same instant. The runs have one result, in
the tables of all their machines.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import LinkwrightError, ModelError
from codegen.object_display import counted
from runtime.core.outcomes import Outcome
from runtime.dynamics.motion_at_instants import Found, SimulatedMotion, resumed
from runtime.dynamics.simulation import simulate_joints
from runtime.mechanism.dense_equations import Contradiction, Equations, FloatArray, impact
from runtime.mechanism.mechanism import Mechanism, Values, sibling, sibling_named
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import Assembly, DiscreteState, State
from runtime.results.motion_at_instants import Motion, keep
from runtime.results.result import Result
from runtime.results.run_records import Ending, Reconnection, sentences
from runtime.results.samples import Samples
from runtime.results.saved_result import saved_fields
from runtime.validation.arguments import parameter_values, uniform

_MOST = 10_000  # safety: changes of joints in a run
_AT_ONCE = 16  # safety: changes of joints at one instant, each that of all that come or go
_IN_A_ROW, _SHORT = 64, 1e-5  # safety: so many changes within that part of a run have no end
_CLOSED = 1e-6  # safety: of the size of its equation; a joint further open does not engage
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


def simulate(
    mechanism: Mechanism, t_end: float, t_eval: Any = None, *,
    part: Callable[..., Result] = simulate_joints, **settings: Any,
) -> Result:  # fmt: skip
    """Integrate the equations of motion, with other joints from where these come or go.

    `part` makes the run of one set of joints, with these settings.
    """
    if not any(row.reconnects for row in mechanism.description.watched):
        return part(mechanism, t_end, t_eval, **settings)
    start = settings.get("start")
    first = start.t if isinstance(start, Assembly | State) else settings.get("t_start", 0.0)
    if (t_eval is None or isinstance(t_eval, int)) and first <= t_end:
        t_eval = uniform(first, t_end, t_eval)
    parameters = dict(settings.pop("parameters", None) or {})
    idle = mechanism.description.unused  # some scenes that follow may depend on them
    values = {name: value for name, value in parameters.items() if name not in idle}
    results = [part(mechanism, t_end, t_eval, parameters=values, **settings)]
    changes = list[Change]()
    settings |= {"part": part, "parameters": parameters}
    follow(results, changes, mechanism, t_end, t_eval, t_end - first, **settings)
    if len(results) == 1:
        return results[0]
    found, motion = joined(results, changes), results[0]._motion
    found.message += motion.ready.note if isinstance(motion, SimulatedMotion) else ""
    return found


def follow(
    results: list[Result], changes: list[Change], mechanism: Mechanism, t_end: float,
    t_eval: Any, span: float, *, parameters: Values, part: Callable[..., Result] = simulate_joints,
    **settings: Any,
) -> None:  # fmt: skip
    """Append the runs that follow the last of the results, with other joints, and the changes.

    `mechanism` is that of the last one, `span` the time of the whole run, s.
    """
    while True:
        run = results[-1]
        end = run.reconnection
        if end is None or run.outcome is not Outcome.OK or end.state.t >= t_end:
            return
        if endless := _without_end([*filter(None, changes)], end.state.t, span):
            _end_at_change(run, Outcome.ZENO, endless)
            return
        try:
            after = sibling(mechanism, (row.target for row in end.rows))
            begin, change = cross(mechanism, after, end, parameters)
        except Gap as gap:
            _end_at_change(run, Outcome.INCONSISTENT, str(gap))
            return
        except ModelError as error:
            why = f"{_what_changes(end)}, and the joints that act then permit no motion: {error}"
            remedy = "Or let another joint be released by the same condition."
            _end_at_change(run, Outcome.INCONSISTENT, f"{why} {remedy}")
            return
        mechanism, values = after, known_parameters(after, parameters)
        settings |= {"start": begin, "length": end.length, "guess": None, "t_start": 0.0}
        if settings.get("max_steps"):
            done = run.stats["steps"] + run.stats["rejected"]
            settings["max_steps"] = max(1, int(settings["max_steps"] - done))
        instants, none_left = t_eval, False
        if isinstance(t_eval, np.ndarray | list | tuple):
            times: FloatArray = np.asarray(t_eval, dtype=np.float64)
            instants = times[times > begin.t]
            none_left = not len(instants)
        try:
            run = part(
                mechanism, t_end, np.array([t_end]) if none_left else instants, parameters=values,
                **settings,
            )  # fmt: skip
        except LinkwrightError as error:
            _end_at_change(results[-1], Outcome.INCONSISTENT, f"{sentences(change)} {error}")
            return
        if none_left and run.outcome is Outcome.OK and not run.ended_by:
            run.samples = run.samples.at(slice(0))
            run.works = {name: work[:0] for name, work in run.works.items()}
        results.append(run)
        changes.append(change)


def _end_at_change(run: Result, outcome: Outcome, message: str) -> None:
    """Let a run end where a joint should have come or gone, with the state there."""
    end, motion = run.reconnection, run._motion
    assert end is not None
    if motion is not None and (not len(run.t) or run.t[-1] < end.state.t):
        row, works = motion.at(run, np.array([end.state.t]))
        run.samples = Samples.joined([run.samples, row])
        run.works = {name: np.append(work, works[name]) for name, work in run.works.items()}
    run.outcome, run.message = outcome, message


def _without_end(changes: list[Change], t: float, span: float) -> str:
    """That joints come and go for ever at the instant `t` of a run over a `span`, s; else empty."""
    count = len(changes)
    at_once = count >= _AT_ONCE and changes[-_AT_ONCE][0].time == t
    in_a_row = count >= _IN_A_ROW and t - changes[-_IN_A_ROW][0].time < _SHORT * span
    if not (at_once or in_a_row or count >= _MOST):
        return ""
    last = changes[-1][-1]
    return (
        f"Stopped at t = {last.time:.9g} s. Joints come and go without end, {count} times, "
        f"the last '{last.joint}': each change makes the condition of the next one hold. "
        "Leave a margin between the conditions under which a joint engages and is released."
    )


class Gap(Exception):  # noqa: N818 (it is caught where runs follow one another)
    """A joint that does not close where it is to engage."""


def cross(
    before: Mechanism, after: Mechanism, end: Ending, parameters: Values
) -> tuple[State, Change]:
    """The state behind the instant at which joints come or go; raises Gap."""
    description, engaged = after.description, [r.target for r in end.rows if r.action == "engage"]
    t, was = end.state.t, before.description.coordinates.names
    known = [was.index(name) if name in was else -1 for name in description.coordinates.names]
    q, v = (np.append(x, 0.0)[known] for x in (end.state.q, end.state.v))
    impulses = {row.target: (dict[str, float](), dict[str, str]()) for row in end.rows}
    lost = 0.0
    if engaged:
        equations = Equations(after, parameter_values(after, known_parameters(after, parameters)))
        _require_closed(equations, engaged, t, q, end.length)
        rest = v
        try:
            v, multipliers, work = impact(equations, t, q, rest, end.length)
        except Contradiction as found:
            where = f"{_what_changes(end)}, and {found}"
            raise Gap(f"{where}. Choose another instant, or release it.") from None
        states = [row.column for row in description.states]
        v[states] = rest[states]  # to the last bit
        lost = float((rest - v) @ equations.mass(q) @ (rest + v)) / 2 + work
        reactions = np.zeros(len(description.reactions))
        if "reactions" in description.kernels:
            after.kernels.reactions(t, q, v, equations.p, multipliers, reactions)
        for row, value in zip(description.reactions, reactions.tolist(), strict=True):
            if row.element in engaged:
                impulse, units = impulses[row.element]
                impulse[row.component] = 0.0 + value
                units[row.component] = f"{row.unit} s" if row.unit else ""
    change = []
    for _, action, joint, _ in end.rows:
        impulse, units = impulses[joint]
        own = lost if joint in engaged[:1] else 0.0
        change.append(Reconnection(t, joint, action, impulse, own, units))
    start = State(t, q, v, description.coordinates, discrete=end.state.discrete)
    return start, tuple(change)


def _what_changes(end: Ending) -> str:
    """Which joints are to come or go, and when."""
    t, joints = end.state.t, [f"'{row.target}' is to {row.action}" for row in end.rows]
    return f"Joint {' and '.join(joints)} at t = {t:.9g} s".replace("release", "be released")


def known_parameters(mechanism: Mechanism, parameters: Values) -> dict[str, float]:
    """Those of the values whose parameters the mechanism has."""
    names = mechanism.description.parameters.names
    return {name: value for name, value in parameters.items() if name in names}


def _require_closed(
    equations: Equations, joints: Sequence[str], t: float, q: FloatArray, length: float
) -> None:
    gaps = np.abs(equations.constraints(t, q))
    least = _CLOSED * equations.row_scale(t, q, max(length, equations.size(t, q)))
    open_rows = [
        (row, f"{row.name} by {gap:.3g}")
        for row, gap, most in zip(equations.description.constraints, gaps, least, strict=True)
        if row.element in joints and gap > most
    ]
    if open_rows:
        raise Gap(
            f"Joint '{open_rows[0][0].element}' is to engage at t = {t:.9g} s, where it is open: "
            f"{', '.join(text for _, text in open_rows)}. Choose a condition under which it closes "
            "by itself, or a joint with fewer constraints."
        )


def scene_of_start(mechanism: Mechanism, start: object) -> Mechanism:
    """The mechanism with the joints that act in the state `start`, where these come and go.

    A state of any other scene, and values by name, leave the mechanism as it is.
    """
    state = start.state() if isinstance(start, Result) else start
    scene = state.scene if isinstance(state, State) else ""
    return sibling_named(mechanism, scene) or mechanism


def parameters_there(
    there: Mechanism, mechanism: Mechanism, parameters: Values | None
) -> Values | None:
    """Values of the parameters of `mechanism`, without those that only its other scenes need.

    `there` is the mechanism of the scene in which a run begins.
    """
    changes = any(row.reconnects for row in there.description.watched)
    if not parameters or there is mechanism or changes:
        return parameters
    idle = {*there.description.unused} - {*mechanism.description.unused}
    return {name: value for name, value in parameters.items() if name not in idle}


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
    held = [one._held.strip() for one in results[:-1]]
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
    """Samples and works of parts that follow one another, in the tables of all of them.

    What does not act exerts nothing, and works go on from those at the end of the part before.
    """
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
