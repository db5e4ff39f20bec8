"""Arguments of the analyses as plain values, and parameter values, read before a computation.

Of arguments only kinds are distinguished (a number, a mapping, instants, an assembled state);
whether a value makes sense is decided where it is used. Parameters have the defaults, and the
user's values over them, checked all at once; masses and inertias that they make impossible are
refused, with the parameters behind them.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, InputError, ParameterError
from codegen.parameter_conditions import profile_problems, violated_conditions
from codegen.presentation import VIEWS
from codegen.readers import arguments as readers
from codegen.readers.arguments import Reader, count, either, optional
from codegen.readers.quantities import UnitError, finite_in_unit, is_quantity
from codegen.readers.values import KindError, finite_float, is_flag, shown
from runtime.core.kinds import ANALYSES, analysis_name, analysis_title
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown
from runtime.results.assembled_state import Assembly, State
from runtime.results.motion_at_instants import finite_numbers
from runtime.results.result import Result
from runtime.validation.profiles import sampled_profiles

STEPS = "steps"
POINTS = 501  # layout: output instants, where nothing else is said

Instants = npt.NDArray[np.float64]
_number_of_them = count(2, 10**9)


def instants(t_eval: npt.ArrayLike) -> Instants:
    """The output instants as an array, checked."""
    times = finite_numbers(t_eval, "s")
    if times is None:
        raise AnalysisError(
            f"t_eval is {shown(t_eval)}; it must be instants in s: at least one finite instant, in "
            "one dimension."
        )
    backwards = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backwards):
        place = int(backwards[0])
        raise AnalysisError(
            f"t_eval must increase: instant {place + 1} is {times[place + 1]:g} s "
            f"after {times[place]:g} s. Sort it and drop repetitions."
        )
    return times


def read_instants(t_eval: Any) -> int | str | Instants:
    """A number of instants, "steps", or the instants themselves."""
    if isinstance(t_eval, str):
        if t_eval != STEPS:
            raise KindError('it must be instants in s, how many of them, or "steps".')
        return STEPS
    if finite_float(t_eval) is None or is_flag(t_eval):
        return instants(t_eval)
    if not isinstance(t_eval, int) and not isinstance(t_eval, np.integer):
        raise KindError(
            f"of one instant it must be [{float(t_eval):g}]; a whole number says how many there "
            "are."
        )
    return int(_number_of_them(t_eval))


def uniform(first: float, last: float, number: int | None) -> Instants:
    """So many instants at equal distances, ends included, by default 501; one without a span."""
    times: Instants = np.linspace(first, last, number or POINTS if last > first else 1)
    return times


def instants_of_motion(
    t_end: Any, t_eval: int | str | Instants | None, first: float, analysis: str
) -> Instants:
    """The instants of a driven motion: up to `t_end`, or all of them given in its place."""
    if isinstance(t_eval, str):
        raise AnalysisError(
            f'{analysis}: t_eval = "steps" has no meaning, as drivers prescribe the motion at '
            "every instant. Give instants, or how many."
        )
    if isinstance(t_end, str) or (is_quantity(t_end) and not np.ndim(t_end.magnitude)):
        t_end = readers.read_arguments(analysis, KINDS, {"t_end": t_end})["t_end"]
    last = None if is_flag(t_end) else finite_float(t_end)
    if last is None and t_end is not None:
        if t_eval is not None:
            raise AnalysisError(
                f"{analysis}: t_end is {shown(t_end)}, and t_eval is given as well. Give the last "
                "instant in s, or the instants alone."
            )
        return instants(t_end)
    if isinstance(t_eval, np.ndarray):
        if last is not None and t_eval[-1] > last:
            raise AnalysisError(
                f"{analysis}: t_eval goes to {t_eval[-1]:g} s, beyond t_end = {last:g} s."
            )
        return t_eval
    if last is None:
        raise AnalysisError(f"{analysis}: give the last instant in s, or the instants in a list.")
    if last < first:
        raise AnalysisError(
            f"{analysis}: t_end = {last:g} s lies before t_start = {first:g} s. A number is the "
            f"last instant of a run; for this one instant give [{last:g}]."
        )
    return uniform(first, last, t_eval)


def read_analysis(value: Any) -> str:
    """The name of an analysis, in its usual spelling."""
    name = analysis_name(value) if isinstance(value, str) else ""
    if name not in ANALYSES:
        raise KindError(f"it must be the name of an analysis: {', '.join(ANALYSES)}.")
    return name


def refuse_integration(title: str, analysis: str, words: Iterable[str]) -> None:
    """Refuse arguments of a simulation, by name, for an analysis that integrates nothing."""
    if words := [*words]:
        raise InputError(
            f"{title}: {analysis_title(analysis)} integrates nothing, so {', '.join(words)} would "
            "be ignored. Leave out what a simulation takes."
        )


def check(
    mechanism: Mechanism, given: Mapping[str, Any], *, start_has_values: bool = False
) -> dict[str, Any]:  # fmt: skip
    """The arguments of an analysis among names and values, such as a method's own, as plain values.

    With `start_has_values` the argument `start` has values by name, and is no state.

    Raises InputError: one sentence for each argument that does not fit.
    """
    state = _state_of(
        mechanism,
        "it must be what assemble() returns, a result or its state(t), a saved one as "
        'load_result("run.nc") gives it, or values by name, such as {"crank.phi": 0.5}.',
    )

    def start(value: Any) -> Any:
        return _values(value) if isinstance(value, Mapping) else state(value)

    at = either(_instant, _state_of(
        mechanism,
        "it must be an instant in s, or a state: what assemble() returns, a result or its "
        "state(t).",
    ))  # fmt: skip
    kinds = {**KINDS, "start": optional(_values if start_has_values else start)}
    if not given.keys().isdisjoint(("at", "q", "v")):
        kinds |= {**_state_readers(mechanism), "at": at}
    known = {name: value for name, value in given.items() if name in kinds}
    values = readers.read_arguments(mechanism.title, kinds, known)
    problems = [*_conversion_problems(mechanism.description, values)]
    problems += _contradictions(values) if values.get("start") is not None else []
    if problems:
        raise InputError(problems)
    return values


def _conversion_problems(description: Description, given: dict[str, Any]) -> Iterator[str]:
    """Values with units become numbers in SI; a sentence for each whose unit does not fit."""
    for word in ("parameters", "guess", "start"):
        values: Any = given.get(word)
        if not isinstance(values, dict):
            continue
        for name, value in values.items():
            if isinstance(value, float):
                continue
            try:
                if word == "parameters" and name in description.parameters:
                    values[name] = _converted(value, description.parameters[name].unit)
                elif word != "parameters" and name in description.startable:
                    values[name] = _converted(value, description.series.find(name).unit)
            except UnitError as misfit:
                yield f"{description.title}: {word}, {name}: {misfit}"


def _converted(value: Any, unit: str) -> Any:
    """A value with a unit as a number in another one; what is none stays as it is."""
    number = finite_in_unit(value, unit)
    return value if number is None else number


def _contradictions(given: Mapping[str, Any]) -> list[str]:
    """Arguments that contradict a start."""
    problems = []
    if isinstance(given["start"], dict):
        return [
            f"{name} is given in start and in guess: start sets a value, guess only begins a "
            "search with it. Leave one of them out."
            for name in given["start"]
            if name in (given.get("guess") or {})
        ]
    if given.get("guess"):
        problems.append(
            "start and guess are both given, but an assembled start has all its values. Give one "
            "of them, or put the guess into assemble(guess)."
        )
    return problems + [
        f"start and {name} = {given[name]:g} s are both given, but start belongs "
        f"to t = {given['start'].t:g} s. Leave {name} out, or assemble at that time."
        for name in ("t_start", "t")
        if given.get(name, 0.0) not in (0.0, given["start"].t)
    ]


def _tolerances(value: Any) -> Any:
    """A positive number, or an array of them."""
    if isinstance(value, np.ndarray | list | tuple) and np.ndim(value):
        return np.array([_tolerance(entry) for entry in value])
    return _tolerance(value)


def _state_of(mechanism: Mechanism, demand: str) -> Reader:
    """A state of the machine: `demand` says what else the argument may be."""

    def read(value: Any) -> Assembly | State:
        state = value.state() if isinstance(value, Result) else value
        if not isinstance(state, Assembly | State):
            raise KindError(demand)
        names = state.coordinates.names
        if names and names != mechanism.description.coordinates.names:
            state = _by_names(mechanism.description, state)
        arrays = {"start.q": state.q, "start.v": state.v}
        readers.read_arguments(mechanism.title, _state_readers(mechanism, "start."), arrays)
        return state

    return read


def _by_names(description: Description, value: Assembly | State) -> State:
    """A state of another scene of the machine; states that it lacks have their start values."""
    known = {row.name: k for k, row in enumerate(value.coordinates)}
    own = {state.column for state in description.states}
    lacking = [
        row.name
        for k, row in enumerate(description.coordinates)
        if row.name not in known and k not in own
    ]
    if lacking:
        raise KindError(
            f"it was assembled for another machine, with the coordinates "
            f"{', '.join([*known][:6])}, and lacks {', '.join(lacking[:6])}. Assemble this one."
        )
    first = {row.name: row.value for row in description.start}
    rows = [(known.get(row.name), row.velocity) for row in description.coordinates]
    q = np.array([0.0 if k is None else value.q[k] for k, _ in rows])
    v = np.array([first.get(name, 0.0) if k is None else value.v[k] for k, name in rows])
    stands = (value.sampled, value.discrete, value.scene) if isinstance(value, State) else ()
    return State(value.t, q, v, description.coordinates, *stands)


def _state_readers(mechanism: Mechanism, prefix: str = "") -> dict[str, Reader]:
    count = len(mechanism.description.coordinates)

    def read(value: Any) -> npt.NDArray[np.float64]:
        is_array = isinstance(value, np.ndarray) and not isinstance(value, np.ma.MaskedArray)
        fits = is_array and value.dtype == np.float64 and value.shape == (count,)
        if fits and np.isfinite(value).all():
            return np.asarray(value)
        shape = f"of shape {value.shape}; " if is_array else ""
        raise KindError(
            f"{shape}it must be an array of {count} finite numbers of type float64, in the order "
            "of the coordinates."
        )

    return dict.fromkeys((f"{prefix}q", f"{prefix}v"), read)


_values = readers.values('{"crank.phi": 0.5}')
_tolerance = readers.number("a positive finite number", above=0.0)
_instant = readers.number("a finite number of seconds", unit="s")
_length = optional(readers.number("a positive number of seconds", above=0.0, unit="s"))
KINDS: dict[str, Reader] = {
    **dict.fromkeys(("t", "t_end", "t_start"), _instant),
    **dict.fromkeys(("rtol", "accuracy"), optional(_tolerance)),
    **dict.fromkeys(("first_step", "max_step", "time_scale"), _length),
    "analysis": read_analysis,
    "atol": optional(_tolerances),
    "t_eval": optional(read_instants),
    "parameters": optional(readers.values('{"mass": 2.0}')),
    "guess": optional(_values),
    "unknown": optional(readers.texts('("motor",)')),
    "weights": optional(readers.values('{"motor": 2.0}')),
    "quantities": optional(readers.texts('("crank.phi",)')),
    "correction": readers.text("the name of a correction"),
    **dict.fromkeys(("method", "formulation"), optional(readers.text("a name"))),
    **dict.fromkeys(("max_steps", "threads"), optional(readers.count(1))),
    "max_bytes": readers.count(1),
    "coordinate": readers.text("the name of a coordinate"),
    "out": optional(readers.path),
    **dict.fromkeys(("progress", "dimensions", "forces", "frames", "names"), readers.flag),
    "view": readers.word(*VIEWS),
    "controllers": optional(readers.functions('{"u": lambda sample: 2.0 * sample.t}')),
}
"""Argument of an analysis → its reader."""


def parameter_values(
    mechanism: Mechanism, overrides: Values | None = None
) -> npt.NDArray[np.float64]:
    """Parameters and the constants derived from them, (np,); see `Machine.parameter_values`."""
    overrides = check(mechanism, {"parameters": overrides})["parameters"]
    description = mechanism.description
    table = description.parameters
    values = np.zeros(description.parameter_slots)
    values[: len(table)] = [row.default for row in table]
    problems = []
    for name, value in (overrides or {}).items():
        if name in description.unused:
            problems.append(
                f"{description.title}: nothing that takes part depends on parameter "
                f"{name}. Leave it out of the parameters, or take what needs it into the scene "
                f"(left out: {', '.join(description.left_out.names) or 'nothing'})."
            )
            continue
        if name not in table.names:
            problems.append(f"{description.title}: {unknown('parameter', name, table.names)}")
            continue
        row = table[name]
        finite = finite_float(value)
        if finite is None:
            unit = row.unit and f" in {row.unit}"
            problems.append(
                f"Parameter {name} is {shown(value)}; it must be a finite number{unit}."
            )
            continue
        if row.sign == "positive" and finite <= 0.0:
            problems.append(
                f"Parameter {name} is {finite:g} {row.unit}; it must be greater than zero."
            )
        elif row.sign == "nonnegative" and finite < 0.0:
            problems.append(f"Parameter {name} is {finite:g} {row.unit}; it must not be negative.")
        values[table.index(name)] = finite
    mechanism.kernels.constants(values)
    if (values[: len(table)] != [row.default for row in table]).any():
        problems += _broken(mechanism, values)  # the build judged the defaults
    if problems:
        raise ParameterError(problems)
    return values


def _broken(mechanism: Mechanism, p: npt.NDArray[np.float64]) -> list[str]:
    """What the elements ask of the parameters p, and these do not meet."""
    description, kernels = mechanism.description, mechanism.kernels
    numbers = np.zeros(sum(row.shown for row in description.conditions))
    kernels.conditions(p, numbers)
    problems = [*violated_conditions(description.conditions, numbers)]
    problems += profile_problems(description.profiles, sampled_profiles(mechanism, p))
    return [f"{description.title}: {problem}" for problem in problems]


def require_masses(mechanism: Mechanism, p: FloatArray) -> None:
    """Refuse masses and inertias that are not positive finite numbers."""
    description = mechanism.description
    values = Equations(mechanism, p).masses(description.neutral)
    problems: dict[tuple[str, str], str] = {}
    for index in np.flatnonzero(~((values > 0.0) & (values < np.inf))).tolist():
        row = description.coordinates[index]
        body = row.name.rpartition(".")[0]
        quantity, unit = ("mass", "kg") if row.is_length else ("inertia", "kg m^2")
        if body in description.bodies:  # a coordinate of no body has no mass to refuse
            problems.setdefault(
                (body, quantity),
                f"{description.title}: the {quantity} of {body} is {values[index]:g} {unit}; "
                f"it must be a positive finite number. {_given(mechanism, p)}",
            )
    if problems:
        raise ParameterError(problems.values())


def _given(mechanism: Mechanism, p: FloatArray) -> str:
    """The parameters that are not those of the build, with which all masses are positive."""
    rows = zip(mechanism.description.parameters, p, strict=False)
    given = [f"{row.name} = {value:g} {row.unit}" for row, value in rows if value != row.default]
    return f"Given are {', '.join(map(str.rstrip, given))}: give other values."
