"""Arguments of the analyses as plain values, read before anything is computed.

Here only kinds are distinguished (a number, a mapping, instants, an assembled state); whether a
value makes sense is decided where it is used.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, InputError
from codegen.readers import arguments as readers
from codegen.readers.arguments import Reader, count, optional
from codegen.readers.values import KindError, finite_float, is_flag, shown
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import Assembly, State
from runtime.results.result import Result

STEPS = "steps"
POINTS = 501  # layout: output instants, where nothing else is said

Instants = npt.NDArray[np.float64]
_number_of_them = count(2, 10**9)


def instants(t_eval: npt.ArrayLike) -> Instants:
    """The output instants as an array, checked."""
    try:
        given = np.asarray(None if np.ma.is_masked(t_eval) else t_eval)
    except Exception:
        given = np.asarray(None)
    if given.dtype.kind not in "iuf":
        raise AnalysisError(f"t_eval is {shown(t_eval)}; it must be instants in s.")
    times = np.atleast_1d(given.astype(np.float64))
    if times.ndim != 1 or len(times) == 0 or not np.isfinite(times).all():
        raise AnalysisError("t_eval must be at least one finite instant in s, in one dimension.")
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


def check(
    mechanism: Mechanism, *, start_has_values: bool = False, **given: Any
) -> dict[str, Any]:  # fmt: skip
    """The arguments as plain values; an `InputError`, one sentence a problem, if some misfit.

    With `start_has_values` the argument `start` has values by name, and is no state.
    """
    start = _values if start_has_values else _start_of(mechanism)
    kinds = {**KINDS, "start": optional(start), **_state_readers(mechanism)}
    kinds["at"] = _instant_or_state(mechanism)
    values = readers.read_arguments(mechanism.title, kinds, given)
    problems = _contradictions(values) if values.get("start") is not None else []
    if problems:
        raise InputError(problems)
    return values


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
    if given.get("t_start", 0.0) not in (0.0, given["start"].t):
        problems.append(
            f"start and t_start = {given['t_start']:g} s are both given, but start belongs "
            f"to t = {given['start'].t:g} s. Leave t_start out, or assemble at that time."
        )
    return problems


def _tolerances(value: Any) -> Any:
    """A positive number, or an array of them."""
    if isinstance(value, np.ndarray | list | tuple) and np.ndim(value):
        return np.array([_tolerance(entry) for entry in value])
    return _tolerance(value)


def _instant_or_state(mechanism: Mechanism) -> Reader:
    def read(value: Any) -> float | Assembly | State:
        instant = finite_float(value)
        if instant is not None:
            return instant
        state = value.state() if isinstance(value, Result) else value
        if not isinstance(state, Assembly | State):
            raise KindError(
                "it must be an instant in s, or a state: what assemble() returns, a result or its "
                "state(t)."
            )
        found: Assembly | State = _start_of(mechanism)(state)
        return found

    return read


def _start_of(mechanism: Mechanism) -> Reader:
    def read(value: Any) -> Assembly | State | dict[str, float]:
        if isinstance(value, Mapping):
            values: dict[str, float] = _values(value)
            return values
        state = value.state() if isinstance(value, Result) else value
        if not isinstance(state, Assembly | State):
            raise KindError(
                "it must be what assemble() returns, a result or its state(t), a saved one as "
                'load_result("run.nc") gives it, or values by name, such as {"crank.phi": 0.5}.'
            )
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
_instant = readers.number("a finite number of seconds")
_length = optional(readers.number("a positive number of seconds", above=0.0))
KINDS: dict[str, Reader] = {
    **dict.fromkeys(("t", "t_end", "t_start"), _instant),
    **dict.fromkeys(("rtol", "accuracy"), optional(_tolerance)),
    **dict.fromkeys(("first_step", "max_step", "time_scale"), _length),
    "atol": optional(_tolerances),
    "t_eval": optional(read_instants),
    "parameters": optional(readers.values('{"mass": 2.0}')),
    "guess": optional(_values),
    "quantities": optional(readers.texts('("crank.phi",)')),
    "correction": readers.text("the name of a correction"),
    **dict.fromkeys(("method", "formulation"), optional(readers.text("a name"))),
    **dict.fromkeys(("max_steps", "threads"), optional(readers.count(1))),
    "max_bytes": readers.count(1),
    "out": optional(readers.path),
    **dict.fromkeys(("progress", "dimensions", "forces", "frames", "names"), readers.flag),
    "controllers": optional(readers.functions('{"u": lambda sample: 2.0 * sample.t}')),
}
"""Argument of an analysis → its reader."""
