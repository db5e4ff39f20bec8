"""Instants of the samples of an analysis, from the last instant and what is said of the others."""

from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from codegen.readers.arguments import count
from codegen.readers.values import KindError, finite_float, is_flag, shown

STEPS = "steps"
POINTS = 501  # layout: output instants, where nothing else is said

Instants = npt.NDArray[np.float64]
_number_of_them = count(2, 10**9)


def instants(t_eval: npt.ArrayLike) -> Instants:
    """The output instants as an array, checked."""
    try:
        given = np.asarray(None if np.ma.is_masked(t_eval) else t_eval)
    except KeyboardInterrupt:
        raise
    except BaseException:
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
