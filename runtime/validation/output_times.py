"""The output instants that a user asks for."""

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from runtime.assembly.dense_equations import FloatArray
from runtime.validation.arguments import shown


def instants(t_eval: npt.ArrayLike) -> FloatArray:
    """The output instants as an array, checked."""
    try:
        given = np.asarray(t_eval)
    except (TypeError, ValueError):
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
