"""Newton's method for equations and unknowns of like size, in as many of each as there are."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

ROUNDING = 4e-16
_ITERATIONS = 60


def newton(
    gaps: Callable[[FloatArray], FloatArray],
    slopes: Callable[[FloatArray], FloatArray],
    x: FloatArray,
) -> tuple[FloatArray, float]:
    """Bring `gaps` to rounding by minimum-norm steps, or go on for as long as they help.

    Parameters
    ----------
    gaps, slopes
        The scaled equations, shape (m,), and their derivatives by x, shape (m, n).

    Returns
    -------
    x, gap
        The best point, and the largest gap there; what counts as solved is for the caller.
    """
    best = float(np.abs(gaps(x)).max(initial=0.0))
    for _ in range(_ITERATIONS):
        if best <= ROUNDING:
            break
        trial = x + np.linalg.lstsq(slopes(x), -gaps(x), rcond=1e-10)[0]
        gap = float(np.abs(gaps(trial)).max(initial=0.0))
        if not gap < best:
            break
        slow = gap > 0.9 * best
        x, best = trial, gap
        if slow:
            break
    return x, best
