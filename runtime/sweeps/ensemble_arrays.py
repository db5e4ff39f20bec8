"""The arrays of the compiled loop over the members of an ensemble, and how they are made."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numba import types

from runtime.assembly.redundancy import DOUBTFUL, MOST_SPREAD
from runtime.assembly.regular_start import allow, let_lead
from runtime.assembly.start_values import Start, start_note, start_values
from runtime.core.arrays import (
    Integers,
    Matrix,
    Vector,
    f8,
    i8,
    integer_matrix,
    integers,
    matrix,
    named_tuple_type,
    vector,
)
from runtime.dynamics.checks.end_checks import sentence_of_unresolved
from runtime.dynamics.checks.screening import APART, CLOSED, RESIDUAL
from runtime.dynamics.formulations import Coordinates
from runtime.dynamics.output_quantities import wire_mixing
from runtime.dynamics.simulation import prepare_run, text_of_end
from runtime.integrate.problem import Options
from runtime.integrate.run import Run
from runtime.linalg.least_norm import SPARSE_FROM
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.typical_sizes import start_table
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.sweeps.ensemble_arguments import Members
from runtime.validation.scene_support import driven_note

_EVENTS = 64  # safety: room for events beyond twice those of the run that was made beforehand
WAITING, DONE, LEFT = 0, 1, 2
"""What became of a member: not made yet, made, left to `simulate`."""


class Common(NamedTuple):
    """What all members have in common."""

    values: Matrix  # (r, k): what the members differ in
    kinds: Integers  # (k,): 0: parameters, 1: positions, 2: velocities
    places: Integers  # (k,)
    p: Vector  # parameters before the members' own values, without constants
    q: Vector  # start values likewise, (n,) each
    v: Vector
    absolute: Vector  # (2n,): tolerances that are given, else no number
    diagonal: Integers  # (nm,): coordinate of a non-zero of M on its diagonal, else -1
    bodies: Integers  # (n,): 1 of coordinates that need a mass
    # (c, 3), of the conditions on parameters: bounds, no number where there is none; 1 where the
    # least value is itself too small
    bounds: Matrix
    first: Integers  # (c,): place of each condition's number
    t: float  # first instant, s
    widest: float  # spread of the masses from which on kernels may not suit them; infinite: none
    part: float  # of a typical size, that a residual may reach
    near: float  # s; events are nearer to their instants


class Own(NamedTuple):
    """What a thread has of its own: the table of a run, its memory before a run, and room."""

    table: Integers
    block: Integers  # memory of the table's arrays
    record: Integers  # the record of the run
    fresh_table: Integers
    fresh_block: Integers
    fresh_record: Integers
    p: Vector
    q: Vector
    v: Vector
    sizes: Vector
    mobility: Vector
    inertia: Vector
    masses: Vector
    numbers: Vector  # of the conditions
    start: Integers  # the table of `start_table`
    modes: Matrix  # (k, s) of int64: those of the samples, 0 and 1
    slopes: Vector
    phi: Vector
    scratch: Matrix  # of the screening
    switches: Matrix  # (2, s) of int64
    reversed_event: Integers  # (e,)
    reached: Vector  # (e,)
    permitted: Vector  # (s,)
    begun: Integers  # (1,): the member that has begun, or -1
    mixing_table: Integers  # of `mix_rows`, as the next two; of no words where nothing slides
    mixing_block: Integers
    fresh_mixing: Integers
    powers: Matrix  # (2, rows of POWERS)


class Results(NamedTuple):
    """What becomes of the members, (r, ...) each; a thread writes those of its own members."""

    samples: Samples  # of one more dimension in front, (r, k, ...)
    status: Integers
    steps: Integers
    events: Integers  # that results show
    logged: Integers  # all of them
    unresolved: Any  # (r, s, 4): events within the tolerance, see `count_unresolved`


COMMON = named_tuple_type(
    [
        matrix, integers, integers, *[vector] * 4, integers, integers, matrix, integers, *[f8] * 4
    ], Common,
)  # fmt: skip
OWN = named_tuple_type(
    [
        *[integers] * 6, *[vector] * 8, integers, integer_matrix, vector, vector, matrix,
        integer_matrix, integers, vector, vector, *[integers] * 4, matrix,
    ], Own,
)  # fmt: skip
_cube, _modes = (types.Array(kind, 3, "C") for kind in (f8, i8))
RESULTS = named_tuple_type(
    [named_tuple_type([matrix, *[_cube] * 8, _modes, _cube], Samples), *[integers] * 4, _cube],
    Results,
)


class Preparation(NamedTuple):
    """A run of an ensemble, made ready as a single one, and what is common to all."""

    coordinates: Coordinates
    options: Options
    start: Start  # of that run
    common: Common
    event_rows: int

    def own(self) -> tuple[Own, Any]:
        """The arrays of one thread, and what its tables point to, which must live as long."""
        ready = self.coordinates.ready
        mechanism, begin, k = ready.mechanism, ready.begin, np.size(self.options.t_eval)  # type: ignore[arg-type]
        description = mechanism.description
        n, m, s = len(begin.q), len(description.constraints), len(description.switches)
        start, e = start_table(mechanism), self.event_rows + 3 * s
        allow(start, self.start)
        let_lead(start)
        problem = self.coordinates.problem(begin.t, begin.q, begin.v)
        run = Run(self.coordinates.system, problem._replace(p=problem.p.copy()), self.options)
        run.recording.make_room_for_events(e)
        table, block = run.state.wiring.table, run.state.wiring.block
        record = run.state.wiring.arrays["record"].view(np.int64)
        mixing = wire_mixing(mechanism, run.state.p)
        q, v, sizes, mobility, inertia = np.zeros((5, n))
        return Own(
            table, block, record, table.copy(), block.copy(), record.copy(), run.state.p,
            q, v, sizes, mobility, inertia, np.zeros(len(description.mass_rows)),
            np.zeros(sum(row.shown for row in description.conditions)), start.table,
            np.zeros((k, s), np.int64), np.zeros(len(description.jacobian_rows)), np.zeros(m),
            np.zeros((5 + s, max(s, 2 * n))), np.zeros((2, s), np.int64), np.zeros(e, np.int64),
            np.zeros(e), np.zeros(s), np.full(1, -1), mixing.table, mixing.block,
            mixing.block.copy(), np.zeros((2, len(description.powers))),
        ), (run, mixing, start)  # fmt: skip

    def message(self, results: Results, run: int, start: Mapping[str, float] | None) -> str:
        """What `simulate` says of the run of a member to its end, with these start values."""
        ready, unresolved = self.coordinates.ready, results.unresolved[run]
        begin = replace(ready.begin, note="")  # which is that of one member
        note = start_note(ready.mechanism, begin, None, start) if start else ""
        note += sentence_of_unresolved(
            ready.mechanism.description, unresolved, int(results.logged[run])
        )
        end = text_of_end(ready.t_end, int(results.steps[run]))
        return end + note + driven_note(ready.mechanism, ready.begin)


def prepare(
    mechanism: Mechanism, t_end: float, times: Vector, members: Members, run: int,
    pattern: Result, given: Mapping[str, Any],
) -> Preparation | None:  # fmt: skip
    """What all members share with the member `run`, whose result is the `pattern`.

    `given` are options of `simulate`. None where runs of this scene need more than the compiled
    loop: guesses, functions of time, sampled values, conditions that are watched, rigid contacts,
    friction that sticks, works, redundant constraints, outlines with parameters, or many
    coordinates.
    """
    description, system = mechanism.description, mechanism.system
    beyond = (
        description.time_functions, description.sampled, description.watched, description.profiles,
        description.work_rows, system.rigid, system.sticking, system.one_way, system.shares,
        system.stiction, members.guesses, [row for row in description.conditions if row.bulges],
    )  # fmt: skip
    n = len(description.coordinates)
    if any(map(len, beyond)) or n >= SPARSE_FROM or len(description.constraints) > n:
        return None
    words = members.of(run)
    coordinates, options = prepare_run(
        mechanism, t_end, times, parameters=words["parameters"], start=words["start"], **given
    )
    begin = coordinates.begin
    if begin.redundant or begin.is_determined or coordinates.equations.mechanism is not mechanism:
        return None
    begins = start_values(mechanism, None, words["start"])
    if begins.spins:
        return None
    common = _common(members, begins, coordinates, options)
    return Preparation(coordinates, options, begins, common, 2 * len(pattern.events) + _EVENTS)


def _common(members: Members, start: Start, coordinates: Coordinates, options: Options) -> Common:
    ready = coordinates.ready
    description, begin, t = ready.mechanism.description, ready.begin, ready.begin.t
    table, n = description.coordinates, len(description.coordinates)
    tables = (
        (members.parameters, description.parameters.names), (members.starts, table.names),
        (members.starts, tuple(row.velocity for row in table)),
    )  # fmt: skip
    columns, kinds, places = zip(*(
        (column, kind, known.index(name))
        for kind, (given, known) in enumerate(tables)
        for name, column in given.items() if name in known
    ), strict=True)  # fmt: skip
    p, absolute = np.zeros(len(coordinates.problem(t, begin.q, begin.v).p)), np.full(2 * n, np.nan)
    p[: len(description.parameters)] = [row.default for row in description.parameters]
    if options.atol_q is not None:
        absolute[:] = options.absolute(np.ones(n), options.rtol)
    bounds = [(row.low, row.high, row.open) for row in description.conditions]
    numbers = np.cumsum([0, *(row.shown for row in description.conditions)])
    weak = description.weak_pivot
    return Common(
        np.column_stack(columns), np.array(kinds, np.int64), np.array(places, np.int64),
        p, start.q, start.v, absolute, description.mass_diagonal,
        np.array([row.name.rpartition(".")[0] in description.bodies for row in table], np.int64),
        np.array(bounds, np.float64).reshape(-1, 3), numbers[:-1].astype(np.int64), float(t),
        DOUBTFUL * MOST_SPREAD / weak if weak else np.inf,
        RESIDUAL * max(options.rtol, CLOSED), APART * max(abs(t), abs(ready.t_end)),
    )  # fmt: skip
