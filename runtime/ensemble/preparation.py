"""What the runs of an ensemble have in common, made once; and what each thread has of its own."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np

from runtime.assembly.masses_far_apart import DOUBTFUL, MOST_SPREAD
from runtime.assembly.regular_start import allow, let_lead
from runtime.assembly.start_values import Start, start_note, start_values
from runtime.dynamics.checks.end_checks import sentence_of_unresolved
from runtime.dynamics.checks.screening import APART, CLOSED, RESIDUAL
from runtime.dynamics.formulations import CartesianCoordinates
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import text_of_end
from runtime.dynamics.sliding_outputs import wire_mixing
from runtime.ensemble.member_arrays import Common, Own
from runtime.ensemble.members import FloatArray, Members
from runtime.integrate.problem import Options
from runtime.integrate.run import Run
from runtime.integrate.wiring import Wiring
from runtime.linalg.sparse_least_norm import SPARSE_FROM
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.mechanism.start_table import StartTable, start_table
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.validation.scene_support import driven_note

_EVENTS = 64  # safety: room for events beyond twice those of the run that was made beforehand


class Preparation(NamedTuple):
    """A run of an ensemble, made ready as a single one, and what is common to all."""

    ready: PreparedSimulation
    coordinates: CartesianCoordinates
    options: Options
    start: Start  # of that run
    common: Common
    event_rows: int

    def own(self) -> tuple[Own, tuple[Run, Wiring, StartTable]]:
        """The arrays of one thread, and what its tables point to, which must live as long."""
        return _own(self)

    def message(
        self, steps: int, start: Mapping[str, float], unresolved: FloatArray, events: int
    ) -> str:
        """What `simulate` says of a run to its end, with these start values.

        `unresolved`, (s, 4), are those of its `events` that lie within the tolerance.
        """
        mechanism, begin = self.ready.mechanism, self.ready.begin
        note = start_note(mechanism, begin, None, start) if start else ""
        note += sentence_of_unresolved(mechanism.description, unresolved, events)
        return text_of_end(self.ready.t_end, steps) + note + driven_note(mechanism, begin)


def prepare(
    mechanism: Mechanism, t_end: float, times: FloatArray, members: Members, run: int,
    pattern: Result, given: Mapping[str, Any],
) -> Preparation | None:  # fmt: skip
    """What all members share with the member `run`, whose result is the `pattern`.

    `given` are options of `simulate`. None where runs of this scene need more than the compiled
    loop: functions of time, sampled values, conditions that are watched, rigid contacts, friction
    that sticks, works, redundant constraints, or many coordinates.
    """
    description, system = mechanism.description, mechanism.system
    beyond = (
        description.time_functions, description.sampled, description.watched, description.profiles,
        description.work_rows, system.rigid, system.sticking, system.one_way, system.shares,
        system.stiction,
    )  # fmt: skip
    if any(len(rows) for rows in beyond) or len(description.coordinates) >= SPARSE_FROM:
        return None
    words = dict(given)
    start, t_start = members.start_of(run) or None, words.pop("t_start", 0.0)
    parameters = members.parameters_of(run) or None
    ready = PreparedSimulation(
        mechanism, t_end, t_start=t_start, parameters=parameters, guess=None, start=start
    )
    method = words.get("method", "dop853")
    coordinates = CartesianCoordinates(ready, method, "step")
    begin = ready.begin
    if begin.redundant or begin.is_determined or coordinates.mechanism is not mechanism:
        return None
    if len(description.constraints) > len(description.coordinates):
        return None
    atol = words.get("atol")
    options = Options(
        method=method, rtol=words.get("rtol", 1e-8), atol_q=atol, atol_v=atol, t_eval=times,
        h_max=words.get("max_step"), max_steps=words.get("max_steps"),
    )  # fmt: skip
    begins = start_values(mechanism, None, start)
    common = _common(mechanism, members, begins, coordinates, options)
    return Preparation(
        ready, coordinates, options, begins, common, 2 * len(pattern.events) + _EVENTS
    )


def _common(
    mechanism: Mechanism, members: Members, start: Start,
    coordinates: CartesianCoordinates, options: Options,
) -> Common:  # fmt: skip
    description, ready = mechanism.description, coordinates.ready
    t = ready.begin.t
    names = description.coordinates.names
    velocities = [row.velocity for row in description.coordinates]
    columns, kinds, places = list[FloatArray](), list[int](), list[int]()
    for name, column in members.parameters.items():
        columns.append(column)
        kinds.append(0)
        places.append(description.parameters.names.index(name))
    for name, column in members.starts.items():
        columns.append(column)
        kinds.append(1 if name in names else 2)
        places.append((names if name in names else velocities).index(name))
    p = np.zeros(len(coordinates.p))
    p[: len(description.parameters)] = [row.default for row in description.parameters]
    bodies = [row.name.rpartition(".")[0] in description.bodies for row in description.coordinates]
    shown = np.cumsum([0, *(row.shown for row in description.conditions)])
    n, sizes = len(names), np.ones(len(names))
    absolute = np.full(2 * n, np.nan)
    if options.atol_q is not None:
        absolute[:] = options.absolute(sizes, options.rtol)
    weak = description.weak_pivot
    return Common(
        np.column_stack(columns), np.array(kinds, np.int64), np.array(places, np.int64),
        p, start.q, start.v, absolute, description.mass_diagonal, np.array(bodies, np.int64),
        _bounds(row.low for row in description.conditions),
        _bounds(row.high for row in description.conditions),
        np.array([row.open for row in description.conditions], np.int64),
        shown[:-1].astype(np.int64), float(t),
        DOUBTFUL * MOST_SPREAD / weak if weak else np.inf,
        RESIDUAL * max(options.rtol, CLOSED), APART * max(abs(t), abs(ready.t_end)),
    )  # fmt: skip


def _bounds(values: Any) -> FloatArray:
    return np.array([np.nan if value is None else value for value in values], np.float64)


def _own(made: Preparation) -> tuple[Own, tuple[Run, Wiring, StartTable]]:
    """New arrays for a thread, and what lives as long as its tables, which point to it."""
    ready, mechanism = made.ready, made.ready.mechanism
    description: Description = mechanism.description
    begin, k = ready.begin, np.size(made.options.t_eval)  # type: ignore[arg-type]
    n, m, s = len(begin.q), len(description.constraints), len(description.switches)
    start, nonzeros = start_table(mechanism), len(description.jacobian_rows)
    allow(start, made.start)
    let_lead(start)
    problem = made.coordinates.problem(begin.t, begin.q, begin.v)
    problem = replace(problem, p=problem.p.copy())
    run = Run(made.coordinates.system, problem, made.options)
    run.recording.make_room_for_events(made.event_rows + 3 * s)
    wiring, e = run.state.wiring, made.event_rows + 3 * s
    record = wiring.arrays["record"].view(np.int64)
    widths = n, n, n, m, len(description.reactions), len(description.powers), 2, 2
    floats = (np.zeros((k, width)) for width in widths)
    fields = np.zeros(k), *floats, np.zeros((k, s), np.int64), np.zeros((k, s))
    samples = Samples(*cast(Any, fields))
    mixing = wire_mixing(mechanism, run.state.p)
    numbers = sum(row.shown for row in description.conditions)
    q, v, sizes, mobility, inertia = np.zeros((5, n))
    return Own(
        wiring.table, wiring.block, record, wiring.table.copy(), wiring.block.copy(),
        record.copy(), run.state.p, q, v, sizes, mobility, inertia,
        np.zeros(len(description.mass_rows)), np.zeros(numbers),
        start.table, samples, np.zeros((k, s), np.int64),
        np.zeros(nonzeros), np.zeros(m), np.zeros((5 + s, max(s, 2 * n))),
        np.zeros((2, s), np.int64), np.zeros(e, np.int64), np.zeros(e), np.zeros(s),
        np.full(1, -1), mixing.table, mixing.block, mixing.block.copy(),
        np.zeros((2, len(description.powers))),
    ), (run, mixing, start)  # fmt: skip
