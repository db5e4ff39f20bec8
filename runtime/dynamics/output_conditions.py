"""Runs that end where a condition on an output begins to hold, as where a force grows too large.

The run is made to its end, the condition looked for in it and located by `Result.at`, and the run
made again up to there. A scene's own ``until=`` has conditions on positions and velocities, which
are switching functions and need no second run.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.readers.quantities import UnitError, finite_in_unit, number_in, read_condition
from codegen.readers.values import shown
from runtime.core.outcomes import Outcome
from runtime.dynamics.controllers import Sample
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result

_A_STEP = 4  # measured: instants of a step that are looked at
_LEAST, _MOST = 1000, 20_000  # safety: such instants of a run
_ONE_INSTANT = 4e-15  # accuracy: of the time; distance in which a series jumps at an event
_SIGNS = {"<": -1.0, "<=": -1.0, ">": 1.0, ">=": 1.0}

Conditions = Mapping[str, str | tuple[str, str, float | str]]
"""Name → (series, "<" or ">", value), or "series < value"."""


class OutputCondition(NamedTuple):
    """A condition on a series of a result."""

    name: str
    series: str
    sign: float
    value: float

    def of(self, result: Result) -> FloatArray:
        """How far the condition holds at the samples, (k,): above 0 where it does."""
        values, _ = result.series(self.series)
        return self.sign * (values - self.value)


def read_conditions(description: Description, until: Any) -> tuple[OutputCondition, ...]:
    """The conditions that a user gives; InputError with all that are none."""
    found, problems, title = list[OutputCondition](), list[str](), description.title
    taken = {name for row in description.watched for name in (row.name, row.target)}
    if not isinstance(until, Mapping) or not until:
        raise InputError(
            f"{title}: until={shown(until)} names no condition; write "
            'until={"overload": ("hinge.fx", ">", 500.0)}, or leave it out.'
        )
    reconnects = any(row.reconnects for row in description.watched)  # joints have other series
    find = description.series.get if reconnects else description.series.find
    nothing: Any = None
    for name, one in until.items():
        series, sign, value = one, nothing, nothing
        read: Any = number_in if isinstance(one, str) else finite_in_unit
        try:
            parts = read_condition(one) if isinstance(one, str) else one
            if isinstance(parts, tuple | list) and len(parts) == 3:
                series, sign, value = parts
            row = find(series) if isinstance(series, str) else None
            number = read(value, row.unit if row else "")
        except UnitError as misfit:
            problems.append(f"{title}: until={name}, {series}: {misfit}")
            continue
        except InputError as error:
            problems += error.problems
            continue
        signed = isinstance(sign, str) and sign in _SIGNS
        fits = isinstance(name, str) and name and isinstance(series, str) and signed
        if not fits or number is None:
            problems.append(
                f"{title}: until={{{shown(name)}: {shown(one)}}} is no condition; write "
                'until={"overload": ("hinge.fx", ">", 500.0)}: a name, a series of the result, '
                '"<" or ">", and a number.'
            )
        elif name in taken:
            problems.append(
                f"{title}: until= names {shown(name)}, which is the name of a condition, latch, "
                "value or joint of the scene; a result tells by its name what ended it. Choose "
                "another name."
            )
        else:
            found.append(OutputCondition(name, series, _SIGNS[sign], number))
    if problems:
        raise InputError(problems)
    return tuple(found)


def simulate_until(
    analyse: Callable[..., Result], conditions: tuple[OutputCondition, ...], given: dict[str, Any]
) -> Result:
    """The run that ends where the first of the conditions begins to hold.

    In the second run controllers answer as in the first one: they may have a memory.
    """
    answers: dict[tuple[str, float], float] = {}
    second = False

    def kept(name: str, function: Callable[[Sample], float]) -> Callable[[Sample], float]:
        def answer(sample: Sample) -> float:
            if not second or (name, sample.t) not in answers:
                answers[name, sample.t] = function(sample)
            return answers[name, sample.t]

        return answer

    def run(t_end: float, t_eval: Any) -> Result:
        nonlocal second
        result = analyse(**{**given, "t_end": t_end, "t_eval": t_eval})
        second = True
        return result

    if given.get("controllers"):
        rows = given["controllers"].items()
        given = given | {"controllers": {name: kept(name, function) for name, function in rows}}
    return run_until(run, conditions, given["t_end"], given.get("t_eval"))


def run_until(
    run: Callable[[float, Any], Result], conditions: Sequence[tuple[str, str, float, float]],
    t_end: float, t_eval: Any, since: float | None = None, ended: str = "",
) -> Result:  # fmt: skip
    """`run` up to an instant, s, with samples at others: where a condition begins to hold, twice.

    Behind the instant `since`, s, what holds there, as `ended` does, begins anew later.
    """
    whole = run(t_end, t_eval)
    whole._until = tuple(conditions)
    found = _first_to_begin(whole, since, ended)
    if found is None:
        return whole
    name, end = found
    times = t_eval if isinstance(t_eval, str) else np.append(whole.t[whole.t < end], end)
    result = run(end, times)
    result._until = whole._until
    if result.outcome is Outcome.OK:
        result.ended_by = name
        result.message = f"Ended at t = {end:.9g} s, where '{name}' began to hold. {result.message}"
    return result


def _first_to_begin(result: Result, since: float | None, ended: str) -> tuple[str, float] | None:
    """The condition of a run that begins to hold first, and where, s; None: none does."""
    if not len(result.t):
        return None
    first = float(result.t[0]) if since is None else since
    if result.t[-1] <= first:
        return None
    # at so many instants that nothing it does is missed
    count = int(np.clip(_A_STEP * result.stats.get("steps", 0), _LEAST, _MOST))
    times = np.linspace(first, float(result.t[-1]), count + 1)
    seen, found = result.at(np.union1d(times, result.t[result.t >= first])), []
    for one in (OutputCondition(*row) for row in result._until):
        holds = one.of(seen) > 0.0
        holds[0] |= one.name == ended
        begins = np.flatnonzero(holds & ~np.append(since is not None, holds[:-1]))
        if len(begins):
            found.append((_located(result, one, seen.t, int(begins[0])), one.name))
    return min(found)[::-1] if found else None


def _located(result: Result, condition: OutputCondition, t: FloatArray, row: int) -> float:
    """Where a condition begins to hold that holds at one of the instants, and not before, s."""
    if row == 0:
        return float(t[0])

    def excess(at: float) -> float:
        return float(np.nan_to_num(condition.of(result.at(at))[0], nan=-1.0))  # no number: not

    low, high = float(t[row - 1]), float(t[row])
    if excess(low) > 0.0 or excess(high) <= 0.0:  # it jumps there
        return high
    from scipy.optimize import brentq  # a run without such conditions loads none of it

    at = float(brentq(excess, low, high, xtol=4e-16 * max(1.0, abs(high)), rtol=1e-15))
    behind = min(high, at + _ONE_INSTANT * max(1.0, abs(at)))
    return behind if excess(behind) - excess(at) > 0.5 * excess(high) else at
