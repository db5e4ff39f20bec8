"""Two runs beside each other: by how much they differ, when, and how that grows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.studies.error_norms import kindred

if TYPE_CHECKING:
    from runtime.mechanism.description import Description
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

PARTED = 0.1
"""Difference of runs that have nothing in common any more."""

_LEAST = 1e-13  # difference below which there is nothing but rounding
_MOST = 1e-2  # difference from which on it no longer grows as a small one does
_EACH, _ALL = 3.0, 30.0  # by which a quarter of a motion differs more, and two of them
_ENOUGH = 16  # instants


@dataclass(frozen=True)
class Columns:
    """Series of a run, side by side.

    Attributes
    ----------
    names
        Of the series.
    scales : (c,)
        Their typical sizes; NaN: the largest value of the run, of a part that of the whole.
    places : (c,)
        Columns of [q, v] in which they stand; -1: a series of a result, such as a reaction.
    """

    names: tuple[str, ...]
    scales: FloatArray
    places: npt.NDArray[np.int64]

    @property
    def of_state(self) -> bool:
        """Whether all are coordinates and velocities."""
        return bool(np.all(self.places >= 0))

    def of_run(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """The values, (k, c), where all are coordinates and velocities."""
        values: FloatArray = np.hstack([q, v])[:, self.places]
        return values

    def of_result(self, result: "Result") -> FloatArray:
        """The values, (k, c)."""
        columns = [result.series(name)[0] for name in self.names]
        return np.stack(columns, axis=1) if columns else np.zeros((len(result.t), 0))

    def wholes(self, result: "Result") -> FloatArray:
        """Largest magnitudes of what the series are parts of, (c,); 0 of those with a size."""
        found = [
            kindred(result, name) if np.isnan(scale) else 0.0
            for name, scale in zip(self.names, self.scales.tolist(), strict=True)
        ]
        return np.array(found)


def columns(told: "Description", names: Sequence[str] | None, sizes: FloatArray) -> Columns:
    """The quantities that are asked for: all coordinates and velocities without `names`.

    Parameters
    ----------
    sizes : (n,)
        Typical sizes of the coordinates, and of their velocities a second.

    Raises
    ------
    InputError
        If no name is given; names that no result has are refused by the result.
    """
    if names is not None and (isinstance(names, str) or not len(names)):
        raise InputError(
            f"{told.title}: quantities is {names!r}; it must be names of series, such as "
            f'("{told.coordinates.names[0]}",).'
        )
    n = len(told.coordinates)
    place = {row.name: k for k, row in enumerate(told.coordinates)}
    place |= {row.velocity: n + k for k, row in enumerate(told.coordinates)}
    chosen = tuple(place) if names is None else tuple(dict.fromkeys(names))
    places = np.array([place.get(name, -1) for name in chosen], dtype=np.int64)
    both = np.concatenate([sizes, sizes, [np.nan]])
    return Columns(chosen, both[places], places)


@dataclass(frozen=True)
class Difference:
    """By how much two runs differ.

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
        """How many instants lie before the first with a difference above `limit`."""
        return int(np.searchsorted(self.over_time, limit, side="right"))


def difference(
    t: FloatArray,
    first: FloatArray,
    second: FloatArray,
    of: Columns,
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
        What series without a size of their own are parts of: see `Columns.wholes`.
    """
    count = len(t)
    old, new = first[:count], second[:count]
    # Reactions are no numbers at a singular position, and have a size for all that.
    largest = np.abs(np.where(np.isnan(new), 0.0, new)).max(axis=0, initial=0.0)
    largest = largest if wholes is None else np.maximum(largest, wholes)
    scales = np.where(np.isnan(of.scales), largest, of.scales)
    gap, base = np.abs(old - new), scales + np.abs(new)
    # A series that is zero all the time in both runs has no size, and no error.
    scaled = np.divide(gap, base, out=np.zeros_like(gap), where=gap > 0.0)
    scaled[np.isnan(gap) & ~(np.isnan(old) & np.isnan(new))] = np.inf
    return Difference(t, np.where(np.isnan(scaled), 0.0, scaled), scales)


def resolved(found: Difference, values: FloatArray, asked: float) -> bool:
    """Whether no difference that counts is of the size of the motion itself.

    Parameters
    ----------
    values : (k, c)
        Those of the second run.
    asked
        Differences below this do not count.
    """
    if not len(values):
        return True
    spans = np.ptp(np.nan_to_num(values), axis=0)
    gaps = found.scaled.max(axis=0)
    return not bool(np.any((gaps > asked) & (gaps * found.scales > PARTED * spans)))


def tenfold(found: Difference) -> float | None:
    """Time in which a small difference grows tenfold, s; None unless it grows exponentially.

    The difference is looked at while it is neither rounding nor as large as the motion. Of the last
    three quarters of that time, each must have more of it than the one before by a factor, and all
    together by a larger one. A power t^p, p ≤ 3, has at most 2.7 times as much in the fourth as in
    the third; and what an event leaves behind does not go on growing.
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
