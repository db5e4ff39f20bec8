"""Members of an ensemble, checked all at once, and the arrays of the compiled loop over them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import types

from codegen.errors import InputError
from codegen.readers.values import KindError, shown
from runtime.assembly.regular_start import allow, let_lead
from runtime.assembly.start_values import Start, start_note, start_values
from runtime.assembly.substitute_kernels import DOUBTFUL, MOST_SPREAD
from runtime.core import arrays
from runtime.core.arrays import (
    Integers,
    Matrix,
    Vector,
    f8,
    integer_matrix,
    integers,
    matrix,
    vector,
)
from runtime.dynamics.checks.end_checks import sentence_of_unresolved
from runtime.dynamics.checks.screening import APART, CLOSED, RESIDUAL
from runtime.dynamics.formulations import CartesianCoordinates
from runtime.dynamics.output_quantities import SAMPLES, wire_mixing
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.dynamics.simulation import text_of_end
from runtime.integrate.problem import Options
from runtime.integrate.run import Run
from runtime.integrate.wiring import Wiring
from runtime.linalg.least_norm import SPARSE_FROM
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.table_rows import unknown
from runtime.mechanism.typical_sizes import StartTable, start_table
from runtime.results.result import Result
from runtime.results.samples import Samples, empty_samples
from runtime.validation.scene_support import driven_note

FloatArray = npt.NDArray[np.float64]
Columns = Mapping[str, npt.ArrayLike]
"""Values by name: a number for all members, or an array with one for each, (r,)."""
_EVENTS = 64  # safety: room for events beyond twice those of the run that was made beforehand
WAITING, DONE, LEFT = 0, 1, 2
"""What became of a member: not made yet, made, left to `simulate`."""

_cube: Any = types.Array(f8, 3, "C")


@dataclass(frozen=True)
class Members:
    """Values of r members by name, (r,) each: parameters in their units, starts in SI units."""

    count: int
    parameters: dict[str, FloatArray]
    starts: dict[str, FloatArray]

    def of(self, run: int) -> tuple[dict[str, float], dict[str, float]]:
        """The parameters and the start values of one member, by name."""
        parameters, starts = (
            {name: float(column[run]) for name, column in columns.items()}
            for columns in (self.parameters, self.starts)
        )
        return parameters, starts


def read_members(
    mechanism: Mechanism, parameters: Columns | None, starts: Columns | None
) -> Members:
    """The members; raises InputError with every name, shape, length and value that misfits."""
    description = mechanism.description
    velocities = [row.velocity for row in description.coordinates]
    tables: tuple[tuple[str, str, Any, Sequence[str]], ...] = (
        ("parameters", "parameter", parameters, description.parameters.names),
        ("starts", "coordinate or velocity", starts,
         [*description.coordinates.names, *velocities]),
    )  # fmt: skip
    problems, lengths = list[str](), dict[str, int]()
    found = dict[str, FloatArray](), dict[str, FloatArray]()
    for columns, (argument, kind, given, names) in zip(found, tables, strict=True):
        if given is not None and not isinstance(given, Mapping):
            problems.append(f"{argument} is {shown(given)}; it must be arrays by name.")
            continue
        for name, values in (given or {}).items():
            label = f"{argument}[{name!r}]"
            try:
                if name not in names:
                    raise KindError(unknown(kind, name, names))
                columns[name] = column = _column(values)
            except KindError as misfit:
                problems.append(f"{label}: {misfit}")
            else:
                lengths |= {label: len(column)} if column.ndim else {}
    if len({*lengths.values()}) > 1:
        named = ", ".join(f"{label} has {length}" for label, length in lengths.items())
        problems.append(
            f"the arrays disagree on the number of members: {named}. Give them one length."
        )
    if not lengths and not problems:
        problems.append(
            "no array says how many members there are: give at least one parameter or start value "
            "as an array, one value a member."
        )
    if problems:
        raise InputError([f"{mechanism.title}: ensemble: {problem}" for problem in problems])
    count = next(iter(lengths.values()))
    whole = ({k: np.broadcast_to(x, (count,)) for k, x in columns.items()} for columns in found)
    return Members(count, *whole)


def _column(values: npt.ArrayLike) -> FloatArray:
    """A number or one dimension of finite ones; KindError says what is wrong with it."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        raise KindError(f"{shown(values)}; it must be numbers.")
    if array.ndim > 1 or array.size == 0:
        raise KindError(
            f"the shape is {array.shape}; it must be a number, or one number a member, (runs,)."
        )
    column = array.astype(np.float64)
    wrong = np.flatnonzero(~np.isfinite(column))
    if len(wrong):
        raise KindError(
            f"{column.flat[wrong[0]]:g} in member {wrong[0]}, and not finite in {len(wrong)} of "
            f"{column.size}; give finite numbers."
        )
    return column


def forbidden_members(mechanism: Mechanism, members: Members) -> npt.NDArray[np.bool_]:
    """Whether a parameter of a member has a sign that it must not have, (r,)."""
    forbidden = np.zeros(members.count, np.bool_)
    for name, column in members.parameters.items():
        sign = mechanism.description.parameters[name].sign
        if sign:
            forbidden |= column <= 0.0 if sign == "positive" else column < 0.0
    return forbidden


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
    low: Vector  # (c,): bounds of the conditions on parameters; no number: none
    high: Vector
    beyond: Integers  # (c,): 1 where the least value is itself too small
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
    samples: Samples
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
    """What becomes of the members, and the samples of a block of them."""

    samples: Samples  # each of one more dimension, in front: the members of the block
    status: Integers  # (r,) of all members, as the others
    steps: Integers
    events: Integers  # that results show
    logged: Integers  # all of them
    unresolved: Any  # (r, s, 4): events within the tolerance, see `count_unresolved`


COMMON = arrays.named_tuple_type(
    [
        matrix, integers, integers, vector, vector, vector, vector, integers,
        integers, vector, vector, integers, integers, f8, f8, f8, f8,
    ], Common,
)  # fmt: skip
OWN = arrays.named_tuple_type(
    [
        *[integers] * 6, *[vector] * 8, integers, SAMPLES, integer_matrix, vector, vector, matrix,
        integer_matrix, integers, vector, vector, integers, integers, integers, integers, matrix,
    ], Own,
)  # fmt: skip
RESULTS = arrays.named_tuple_type(
    [arrays.named_tuple_type([matrix, *[_cube] * 10], Samples), *[integers] * 4, _cube], Results
)


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
        ready, mechanism = self.ready, self.ready.mechanism
        description = mechanism.description
        begin, k = ready.begin, np.size(self.options.t_eval)  # type: ignore[arg-type]
        n, m, s = len(begin.q), len(description.constraints), len(description.switches)
        start, nonzeros = start_table(mechanism), len(description.jacobian_rows)
        allow(start, self.start)
        let_lead(start)
        problem = self.coordinates.problem(begin.t, begin.q, begin.v)
        problem = replace(problem, p=problem.p.copy())
        run = Run(self.coordinates.system, problem, self.options)
        run.recording.make_room_for_events(self.event_rows + 3 * s)
        wiring, e = run.state.wiring, self.event_rows + 3 * s
        record = wiring.arrays["record"].view(np.int64)
        samples = empty_samples(description, k)
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
    parameters, start = (values or None for values in members.of(run))
    ready = PreparedSimulation(
        mechanism, t_end, t_start=given.get("t_start", 0.0), parameters=parameters, guess=None,
        start=start,
    )  # fmt: skip
    method, atol = given.get("method", "dop853"), given.get("atol")
    coordinates = CartesianCoordinates(ready, method, "step")
    begin = ready.begin
    if begin.redundant or begin.is_determined or coordinates.equations.mechanism is not mechanism:
        return None
    if len(description.constraints) > len(description.coordinates):
        return None
    options = Options(
        method=method, rtol=given.get("rtol", 1e-8), atol_q=atol, atol_v=atol, t_eval=times,
        h_max=given.get("max_step"), max_steps=given.get("max_steps"),
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
    t, names = ready.begin.t, description.coordinates.names
    tables: tuple[tuple[dict[str, FloatArray], Sequence[str]], ...] = (
        (members.parameters, description.parameters.names), (members.starts, names),
        (members.starts, [row.velocity for row in description.coordinates]),
    )  # fmt: skip
    columns, kinds, places = zip(*(
        (column, kind, known.index(name))
        for kind, (given, known) in enumerate(tables)
        for name, column in given.items() if name in known
    ), strict=True)  # fmt: skip
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
        np.array([row.low for row in description.conditions], np.float64),
        np.array([row.high for row in description.conditions], np.float64),
        np.array([row.open for row in description.conditions], np.int64),
        shown[:-1].astype(np.int64), float(t),
        DOUBTFUL * MOST_SPREAD / weak if weak else np.inf,
        RESIDUAL * max(options.rtol, CLOSED), APART * max(abs(t), abs(ready.t_end)),
    )  # fmt: skip
