"""Rows of a result that are not finite: the result ends before them, and names the quantity."""

from contextlib import suppress

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from codegen.object_display import listed
from runtime.core.outcomes import Outcome
from runtime.mechanism.dense_equations import Equations, FloatArray, IntArray
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.results.samples import Samples, undefined_outputs
from runtime.validation.finite_equations import infinite_terms, left_tables

_TURNS, _PARTS = 7, 32  # accuracy: rounds, and parts in each: to 3e-11 between two rows


def end_before_infinite(result: Result, equations: Equations) -> None:
    """End a result that is OK before the first row without a number, or beyond a table's ends.

    The outcome is NOT_FINITE or OUT_OF_RANGE; the message names the element and the instant.
    Kinematics asks for no forces. Singular positions keep their rows, which `kinematics` names, and
    expressions theirs.
    """
    samples = result.samples
    result.message += undefined_outputs(result.description, samples)
    if result.outcome is not Outcome.OK:
        return
    row = _first_infinite(result, equations, samples)
    if row == len(samples.t):
        return
    after, at, motion = samples.at([row]), float(samples.t[row]), result._motion
    where = f"There are no results from the first instant on, t = {at:.9g} s."
    if row > 0 and motion is not None:
        low = float(samples.t[row - 1])
        last = f"the last row is that of t = {low:.9g} s"
        with suppress(AnalysisError):  # the motion does not come so far
            for _ in range(_TURNS):
                found, _ = motion.at(result, np.linspace(low, at, _PARTS + 1))
                k = _first_infinite(result, equations, found)
                if not 0 < k <= _PARTS:
                    break
                (low, at), after = found.t[k - 1 : k + 1].tolist(), found.at([k])
        where = f"There are no results beyond t = {at:.9g} s; {last}."
    kept = slice(max(row, 1))
    result.samples = samples.at(kept)
    result.works = {name: work[kept] for name, work in result.works.items()}
    result.events = tuple(event for event in result.events if event.time <= at)
    state, of_motion = _state(after, 0), result.analysis == "kinematics"
    text, result.outcome = left_tables(equations, *state[:3], of_motion), Outcome.OUT_OF_RANGE
    if text:
        text += f" {result.outcome.advice}"
    else:
        text, result.outcome = infinite_terms(equations, *state), Outcome.NOT_FINITE
    if not text:
        finite = finite_series(result.description, after, of_motion)
        names = [name for name, sound in finite.items() if not sound[0]]
        text = f"Not a finite number: {listed(names)}. {result.outcome.advice}"
    result.message = f"{where} {text}"


def _first_infinite(result: Result, equations: Equations, samples: Samples) -> int:
    """The first row that is no number or beyond a table; so many as there are, where none is."""
    of_motion = result.analysis == "kinematics"
    tables = equations.description.table_ranges if result.analysis != "simulation" else ()
    series = samples.q, samples.v, samples.a, samples.reaction, samples.power, samples.energy
    if not tables and all(np.isfinite(values).all() for values in series):
        return len(samples.t)  # as nearly always, and series by series takes a third of a call
    sound = np.all([*finite_series(result.description, samples, of_motion).values()], axis=0)
    for k in range(len(samples.t)) if tables else np.flatnonzero(~sound).tolist():
        state = _state(samples, k)
        if tables and left_tables(equations, *state[:3], of_motion):
            return k
        if not sound[k]:
            singular = np.isnan(samples.a[k]).all() and equations.motion(*state)[2] > 0
            singular |= bool(equations.description.unknown) and np.isfinite(samples.a[k]).all()
            if not singular or infinite_terms(equations, *state):
                return k
    return len(samples.t)


def _state(samples: Samples, k: int) -> tuple[float, FloatArray, FloatArray, IntArray]:
    return float(samples.t[k]), samples.q[k], samples.v[k], samples.modes[k] % 2


def finite_series(
    description: Description, samples: Samples, of_motion: bool = False
) -> dict[str, npt.NDArray[np.bool_]]:
    """Where each series, perhaps those `of_motion` alone, is a number, (k,), by its name."""
    found = dict[str, npt.NDArray[np.bool_]]()
    others = ("kinetic", "total")  # energies, which follow, or which equilibria leave out
    for row in description.series:
        of_run = row.name not in others and row.kind != "expression"  # which ends no run
        if of_run and row.array in ("qva" if of_motion else samples._fields):
            values = getattr(samples, row.array)
            values = values.sum(axis=1) if row.column < 0 else values[:, row.column]
            found[row.name] = np.isfinite(values)
    return found
