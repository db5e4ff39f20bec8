"""Checks of the arguments of analyses before anything is computed.

Here only kinds are distinguished (a number, a mapping, an assembled state); whether a value makes
sense is decided where it is used.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, InputError
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.results.assembled_state import Assembly

_MOST = 2**62


def number(value: object) -> float | None:
    """The value as a float; None for anything that is no number, such as a text or a boolean."""
    if isinstance(value, bool | np.bool_ | str | bytes):
        return None
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return None


def check(mechanism: Mechanism, **given: Any) -> dict[str, Any]:
    """The arguments; an `InputError`, one sentence a problem, if some are of the wrong kind."""
    found = (_KINDS[name](name, mechanism, value) for name, value in given.items())
    problems = [f"{mechanism.title}: {text}" for text in found if text]
    if not problems and given.get("start") is not None:
        problems = _contradictions(given)
    if problems:
        raise InputError(problems)
    return given


def instants(t_eval: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The output instants as an array, checked."""
    try:
        given = np.asarray(t_eval)
    except (TypeError, ValueError):
        given = np.asarray(None)
    if given.dtype.kind not in "iuf":
        raise AnalysisError(f"t_eval is {shortened(t_eval)}; it must be instants in s.")
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


def _contradictions(given: Mapping[str, Any]) -> list[str]:
    """Arguments that contradict an assembled start."""
    problems = []
    if given.get("guess"):
        problems.append(
            "start and guess are both given, but an assembled start has all its values. Give one "
            "of them, or put the guess into assemble(guess)."
        )
    if given.get("t_start", 0.0) != 0.0:
        problems.append(
            f"start and t_start = {float(given['t_start']):g} s are both given, but start belongs "
            f"to t = {given['start'].t:g} s. Leave t_start out, or assemble at that time."
        )
    return problems


def _instant(name: str, _: Mechanism, value: Any) -> str:
    parsed = number(value)
    if parsed is not None and math.isfinite(parsed):
        return ""
    return f"{name} is {shortened(value)}; it must be a finite number of seconds."


def _length(name: str, _: Mechanism, value: Any) -> str:
    if value is None or (number(value) or 0.0) > 0.0:
        return ""
    return f"{name} is {shortened(value)}; it must be a positive number of seconds."


def _tolerance(name: str, _: Mechanism, value: Any) -> str:
    several = name == "atol" and isinstance(value, np.ndarray | list | tuple)
    entries = map(number, value if several else [] if value is None else [value])
    if all(entry is not None and 0.0 < entry < math.inf for entry in entries):
        return ""
    return f"{name} is {shortened(value)}; it must be a positive finite number."


def _count(name: str, _: Mechanism, value: Any) -> str:
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if whole and 0 <= value <= _MOST:
        return ""
    return f"{name} is {shortened(value)}; it must be a whole number, at most {_MOST:g}."


def _values(name: str, _: Mechanism, value: Any) -> str:
    if value is None:
        return ""
    if not isinstance(value, Mapping):
        return (
            f"{name} is {shortened(value)}; it must be a mapping from names to numbers, "
            f"such as {name}={_EXAMPLES[name]}."
        )
    odd = [key for key in value if not isinstance(key, str)]
    return f"{name} has the name {shortened(odd[0])}, which is no text." if odd else ""


def _start(name: str, mechanism: Mechanism, value: Any) -> str:
    if value is None:
        return ""
    if not isinstance(value, Assembly):
        return f"{name} is {shortened(value)}; it must be what assemble() returns."
    names = value.coordinates.names
    if names and names != mechanism.description.coordinates.names:
        return (
            f"{name} was assembled for another machine, with the coordinates "
            f"{', '.join(names[:6])}. Assemble this one."
        )
    return _state(f"{name}.q", mechanism, value.q) or _state(f"{name}.v", mechanism, value.v)


def _state(name: str, mechanism: Mechanism, value: Any) -> str:
    count = len(mechanism.description.coordinates)
    is_array = isinstance(value, np.ndarray)
    fits = is_array and value.dtype == np.float64 and value.shape == (count,)
    if fits and np.isfinite(value).all():
        return ""
    fault = f"has shape {value.shape}" if is_array else f"is {shortened(value)}"
    return (
        f"{name} {fault}; it must be an array of {count} finite numbers of type float64, in "
        f"the order of the coordinates."
    )


def shortened(value: Any) -> str:
    """The value as written in Python, cut short."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


_EXAMPLES = {"parameters": '{"mass": 2.0}', "guess": '{"crank.phi": 0.5}'}
_KINDS: dict[str, Callable[[str, Mechanism, Any], str]] = {
    **dict.fromkeys(("t", "t_end", "t_start"), _instant),
    **dict.fromkeys(("rtol", "atol", "accuracy"), _tolerance),
    **dict.fromkeys(("first_step", "max_step"), _length),
    **dict.fromkeys(("parameters", "guess"), _values),
    **dict.fromkeys(("q", "v"), _state),
    "max_steps": _count,
    "start": _start,
}
"""Argument of an analysis → the sentence on what is wrong with its value; empty if nothing is."""
