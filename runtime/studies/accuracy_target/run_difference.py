"""The difference of two runs: how large it is, when, and how it grows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.studies.series import group_magnitude, series_values

if TYPE_CHECKING:
    from runtime.mechanism.description import Description
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

DIVERGED = 0.1  # accuracy: scaled difference of runs that have nothing in common any more

_LEAST = 1e-13  # accuracy: difference below which there is nothing but rounding
_MOST = 1e-2  # accuracy: difference from which on it no longer grows as a small one does
_EACH, _ALL = 3.0, 30.0  # measured: growth over a quarter of an exponential divergence, over two
_ENOUGH = 16  # safety: instants from which growth is estimated


@dataclass(frozen=True)
class Quantities:
    """Series of a run whose errors count.

    Attributes
    ----------
    names
        Of the series.
    scales : (c,)
        Their typical sizes; NaN: the largest value in the run of it, or of its whole.
    state_columns : (c,)
        Their columns in [q, v]; -1: a series of a result, such as a reaction.
    """

    names: tuple[str, ...]
    scales: FloatArray
    state_columns: npt.NDArray[np.int64]

    @property
    def are_states(self) -> bool:
        """Whether all are coordinates and velocities."""
        return bool(np.all(self.state_columns >= 0))

    def of_run(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """The values, (k, c), where all are coordinates and velocities."""
        values: FloatArray = np.hstack([q, v])[:, self.state_columns]
        return values

    def of_result(self, result: "Result") -> FloatArray:
        """The values, (k, c)."""
        return series_values(result, self.names)

    def wholes(self, result: "Result") -> FloatArray:
        """Magnitudes of the wholes that the series are parts of, (c,); 0 of those with a size."""
        found = [
            group_magnitude(result, name) if np.isnan(scale) else 0.0
            for name, scale in zip(self.names, self.scales.tolist(), strict=True)
        ]
        return np.array(found)


def quantities_of(
    description: "Description", names: Sequence[str] | None, sizes: FloatArray
) -> Quantities:
    """The quantities of these names: all coordinates and velocities without `names`.

    Parameters
    ----------
    sizes : (n,)
        Typical sizes of the coordinates, and of their velocities per second.

    Raises
    ------
    InputError
        If the names are empty or a text; the result refuses names that it does not have.
    """
    if names is not None and (isinstance(names, str) or not len(names)):
        raise InputError(
            f"{description.title}: quantities is {names!r}; it must be names of series, such as "
            f'("{description.coordinates.names[0]}",).'
        )
    n = len(description.coordinates)
    column = {row.name: k for k, row in enumerate(description.coordinates)}
    column |= {row.velocity: n + k for k, row in enumerate(description.coordinates)}
    chosen = tuple(column) if names is None else tuple(dict.fromkeys(names))
    state_columns = np.array([column.get(name, -1) for name in chosen], dtype=np.int64)
    both = np.concatenate([sizes, sizes, [np.nan]])
    return Quantities(chosen, both[state_columns], state_columns)


@dataclass(frozen=True)
class Difference:
    """The difference of two runs.

    Attributes
    ----------
    t : (k,)
        Instants that both reached, s.
    scaled : (k, c)
        |y - r| / (s + |r|) of each quantity, r that of the second run.
    scales : (c,)
        s.
    """

    t: FloatArray
    scaled: FloatArray
    scales: FloatArray

    @property
    def largest(self) -> float:
        """Of all quantities and instants."""
        return float(self.scaled.max(initial=0.0))

    @property
    def over_time(self) -> FloatArray:
        """The largest up to each instant, (k,)."""
        found: FloatArray = np.maximum.accumulate(self.scaled.max(axis=1, initial=0.0))
        return found

    def within(self, limit: float) -> int:
        """Number of instants before the first with a difference above `limit`."""
        return int(np.searchsorted(self.over_time, limit, side="right"))


def difference(
    t: FloatArray,
    first: FloatArray,
    second: FloatArray,
    quantities: Quantities,
    wholes: FloatArray | None = None,
) -> Difference:
    """Compare two runs at their common instants.

    Parameters
    ----------
    t : (k,)
        Instants of the shorter run, with which both begin.
    first, second : (≥ k, c)
        Their values.
    wholes : (c,)
        Magnitudes of the wholes that series are parts of: see `Quantities.wholes`.
    """
    count = len(t)
    old, new = first[:count], second[:count]
    # Reactions are not numbers in a singular configuration, and have a size all the same.
    largest = np.abs(np.where(np.isnan(new), 0.0, new)).max(axis=0, initial=0.0)
    largest = largest if wholes is None else np.maximum(largest, wholes)
    scales = np.where(np.isnan(quantities.scales), largest, quantities.scales)
    gap, base = np.abs(old - new), scales + np.abs(new)
    # A series that is zero all the time in both runs has no size, and no error.
    scaled = np.divide(gap, base, out=np.zeros_like(gap), where=gap > 0.0)
    scaled[np.isnan(gap) & ~(np.isnan(old) & np.isnan(new))] = np.inf
    return Difference(t, np.where(np.isnan(scaled), 0.0, scaled), scales)


def is_resolved(found: Difference, values: FloatArray, target: float) -> bool:
    """Whether no difference that counts is as large as the motion itself.

    Parameters
    ----------
    values : (k, c)
        Those of the second run.
    target
        Differences below this do not count.
    """
    if not len(values):
        return True
    spans = np.ptp(np.nan_to_num(values), axis=0)
    gaps = found.scaled.max(axis=0)
    return not bool(np.any((gaps > target) & (gaps * found.scales > DIVERGED * spans)))


def tenfold_time(found: Difference) -> float | None:
    """Time in which a small difference grows tenfold, s; None unless it grows exponentially.

    The difference is examined while it is neither rounding nor as large as the motion. From one to
    the next of the last three quarters of that time its median must grow by a factor, and by a
    larger one from the second quarter to the fourth. A power t^p, p ≤ 3, grows at most by 2.7 from
    the third quarter to the fourth; a difference that an event leaves does not go on growing.
    """
    over = found.scaled.max(axis=1, initial=0.0)
    small = int(np.searchsorted(found.over_time, _MOST, side="right"))
    begun = int(np.searchsorted(found.over_time, _LEAST, side="right"))
    if small - begun < _ENOUGH:
        return None
    t, over = found.t[begun:small], over[begun:small]
    edges = found.t[0] + (t[-1] - found.t[0]) * np.array([0.25, 0.5, 0.75])
    parts = np.split(over, np.searchsorted(t, edges))[1:]
    if min(len(part) for part in parts) < _ENOUGH // 8:
        return None
    second, third, fourth = (float(np.median(part)) for part in parts)
    steady = third > _EACH * second and fourth > _EACH * third and fourth > _ALL * second
    if not (second > 0.0 and steady):
        return None
    later = t >= edges[0]
    logs = np.log10(np.maximum(over[later], _LEAST))
    return 1.0 / float(np.polyfit(t[later], logs, 1)[0])
