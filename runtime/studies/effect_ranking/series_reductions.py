"""Reductions of a series to a number: extremes, means, rates, periods."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError

FloatArray = npt.NDArray[np.float64]


class Series(NamedTuple):
    """A function of time at instants: (k,), (k,), and the instants at which it may jump, (e,)."""

    t: FloatArray
    x: FloatArray
    jumps: FloatArray


def _end(series: Series) -> float:
    return float(series.x[-1])


def _largest(series: Series) -> float:
    """The maximum: of the parabola through the three largest samples where they are smooth."""
    t, x, jumps = series
    k = int(np.argmax(x))
    if not 0 < k < len(x) - 1 or ((jumps >= t[k - 1]) & (jumps <= t[k + 1])).any():
        return float(x[k])
    before, after = t[k] - t[k - 1], t[k + 1] - t[k]
    left, right = (x[k] - x[k - 1]) / before, (x[k + 1] - x[k]) / after
    curvature = (right - left) / (before + after)  # half the second derivative
    if curvature >= 0.0:
        return float(x[k])
    slope = (left * after + right * before) / (before + after)
    return float(x[k] - slope * slope / (4.0 * curvature))


def _least(series: Series) -> float:
    return -_largest(series._replace(x=-series.x))


def _range(series: Series) -> float:
    return _largest(series) - _least(series)


def _peak(series: Series) -> float:
    return max(_largest(series), -_least(series))


def _mean(series: Series) -> float:
    return float(np.trapezoid(series.x, series.t) / (series.t[-1] - series.t[0]))


def _rate(series: Series) -> float:
    return float((series.x[-1] - series.x[0]) / (series.t[-1] - series.t[0]))


def _period(series: Series) -> float:
    """Mean time between upward crossings of the mean, each on the curve through four samples."""
    t, level = series.t, series.x - _mean(series)
    (rises,) = np.nonzero((level[:-1] < 0.0) & (level[1:] >= 0.0))
    if len(rises) < 2:
        raise InputError(
            f"it crosses its mean upwards {len(rises)} time{'' if len(rises) == 1 else 's'} "
            "between the ends, which is not enough for a period; take a later end."
        )
    first, last = (_crossing(t, level, int(k)) for k in (rises[0], rises[-1]))
    return (last - first) / (len(rises) - 1)


def _crossing(t: FloatArray, x: FloatArray, k: int) -> float:
    """The instant between samples k and k + 1 at which x passes zero, by bisection."""
    near = slice(max(k - 1, 0), min(k + 3, len(t)))
    low, high = float(t[k]), float(t[k + 1])
    if np.diff(t[near]).min() < 1e-3 * np.diff(t[near]).max():  # samples on both sides of a jump
        near = slice(k, k + 2)
    at = (t[near] - low) / (high - low)
    curve = np.polynomial.Polynomial.fit(at, x[near], len(at) - 1)
    a, b = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (a + b)
        a, b = (middle, b) if curve(middle) < 0.0 else (a, middle)
    return low + a * (high - low)


class Reduction(NamedTuple):
    """A reduction: its meaning in words, its function, its unit, whether one instant suffices."""

    meaning: str
    reduce: Callable[[Series], float]
    unit: str = "{}"
    still: bool = True


REDUCTIONS = {
    "end": Reduction("value at the end", _end),
    "max": Reduction("largest value", _largest),
    "min": Reduction("least value", _least),
    "peak": Reduction("largest magnitude", _peak),
    "range": Reduction("largest less least value", _range, still=False),
    "mean": Reduction("mean over time", _mean, still=False),
    "rate": Reduction("change over the run, a second", _rate, "{}/s", still=False),
    "period": Reduction("time between crossings of its mean", _period, "s", still=False),
}
