"""Factors of a design: a name with values, an interval or a distribution; read from text as well.

J1=200:1000:81            81 values at equal distances, ends included
J1=225,450,900            these values
J1=200:1000               an interval, from which a sample draws uniformly
J1=uniform:200:1000       the same
J1=normal:450:20          mean and standard deviation
J1=log:1:1000:4           4 values at equal ratios, ends included
l=100 mm:20 cm:4          in units of their own, which all numbers have
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.readers.quantities import QUANTITY, QuantityError, number_in
from codegen.readers.values import finite_float, one_line, shown

FloatArray = npt.NDArray[np.float64]
DISTRIBUTIONS = ("uniform", "normal")
MOST_VALUES = 10_000_000  # safety: values of one factor
_FORM = (
    "write NAME=FIRST:LAST:COUNT, NAME=A,B,C, NAME=log:FIRST:LAST:COUNT, NAME=uniform:LOW:HIGH or "
    "NAME=normal:MEAN:SD"
)


@dataclass(frozen=True)
class Factor:
    """A quantity that varies over a sweep: a parameter or a start value."""

    name: str
    values: tuple[float, ...] = ()  # of a grid
    distribution: str = ""  # of a sample: one of DISTRIBUTIONS
    bounds: tuple[float, float] = (math.nan, math.nan)  # low and high, or mean and deviation
    unit: str = ""  # that of the text, where it is not the declared one

    @property
    def text(self) -> str:
        """The factor in words, as files and messages have it."""
        if self.distribution:
            return f"{self.distribution} {self.bounds[0]:g} {self.bounds[1]:g} {self.unit}".rstrip()
        first, last = self.values[0], self.values[-1]
        return f"{len(self.values)} values from {first:g} to {last:g} {self.unit}".rstrip()

    def quantile(self, share: FloatArray) -> FloatArray:
        """Values below which a share, (k,) from 0 to 1, of the distribution lies."""
        first, second = self.bounds
        if self.distribution == "uniform":
            return first + share * (second - first)
        from scipy.special import ndtri

        within = np.clip(share, np.finfo(float).tiny, 1.0 - 2.0**-53)  # 0 and 1 lie at infinity
        return np.asarray(first + second * ndtri(within))


def read_factors(over: Mapping[str, Any] | Sequence[str]) -> tuple[Factor, ...]:
    """The factors of a mapping from names, or of texts ``NAME=...``.

    Raises
    ------
    InputError
        One sentence for each factor that cannot be read.
    """
    found, problems = dict[str, Factor](), list[str]()
    texts = () if isinstance(over, Mapping) else over
    pairs = [*over.items()] if isinstance(over, Mapping) else []
    for text in texts:
        name, sign, given = (part.strip() for part in text.partition("="))
        if sign and name:
            pairs.append((name, given))
        else:
            problems.append(f"over, {one_line(text)}: {_FORM}.")
    for name, given in pairs:
        try:
            factor = read_factor(name, given)
        except InputError as error:
            problems += error.problems
            continue
        if name in found:
            problems.append(f"{name} is varied twice; give it once.")
        found[name] = factor
    if not found and not problems:
        problems.append(f"Nothing varies; {_FORM}.")
    if problems:
        raise InputError(problems)
    return tuple(found.values())


def read_factor(name: str, given: Any) -> Factor:
    """One factor: a text, numbers, or a distribution such as ("normal", 1.0, 0.01)."""
    where = f"{one_line(name)}={given}" if isinstance(given, str) else f"{one_line(name)}"
    if isinstance(given, str):
        return _read_text(name, given, where)
    if isinstance(given, tuple | list) and given and isinstance(given[0], str):
        return _distribution(name, given[0], [finite_float(x) for x in given[1:]], where)
    try:
        array = np.atleast_1d(np.asarray(given))
    except (TypeError, ValueError):
        array = np.zeros(0, dtype=object)
    if array.ndim != 1 or array.dtype.kind not in "iuf" or not len(array):
        raise InputError(
            f"{where} is {shown(given)}; it must be numbers, a text such as '200:1000:81', or a "
            'distribution such as ("normal", 1.0, 0.01).'
        )
    return _grid(name, array.astype(np.float64), where)


def _read_text(name: str, text: str, where: str) -> Factor:
    word, *rest = (part.strip() for part in text.split(":"))
    if word == "log":
        if len(rest) != 3:
            raise InputError(f"{where}: log needs FIRST, LAST and COUNT.")
        (first, last), unit = _numbers(rest[:2], where)
        if first * last <= 0.0:
            raise InputError(f"{where}: equal ratios lead from {first:g} to {last:g} by no way.")
        return _grid(
            name, np.geomspace(first, last, _count(rest[2], first, last, where)), where, unit
        )
    if word in DISTRIBUTIONS or (rest and word[:1].isalpha() and _number(word) is None):
        numbers, unit = _numbers(rest, where) if word in DISTRIBUTIONS else ([], "")
        return _distribution(name, word, [*numbers], where, unit)
    if not rest:
        numbers, unit = _numbers(text.split(","), where)
        return _grid(name, np.array(numbers, dtype=np.float64), where, unit)
    if len(rest) > 2:
        raise InputError(f"{where}: {_FORM}.")
    (first, last), unit = _numbers([word, rest[0]], where)
    if len(rest) == 1:
        return _distribution(name, "uniform", [first, last], where, unit)
    return _grid(name, np.linspace(first, last, _count(rest[1], first, last, where)), where, unit)


def _count(text: str, first: float, last: float, where: str) -> int:
    """The number of values between two ends."""
    count = _number(text)
    if count is None:
        raise InputError(f"{where}: {_FORM}.")
    if not (count.is_integer() and 1 <= count <= MOST_VALUES):
        raise InputError(
            f"{where}: the count is {count:g}; it must be a whole number from 1 to {MOST_VALUES:g}."
        )
    if count == 1 and first != last:
        raise InputError(f"{where}: one value cannot be both {first:g} and {last:g}; give one.")
    return int(count)


def _numbers(texts: Sequence[str], where: str) -> tuple[list[float], str]:
    """Numbers in the unit of the first one, and that unit; empty where they have none."""
    values, units = list[float](), list[str]()
    for text in texts:
        parts = QUANTITY.fullmatch(text)
        value = _number(parts[1] if parts else text)
        if value is None:
            raise InputError(f"{where}: {_FORM}.")
        values.append(value)
        units.append((parts[2] or "").strip() if parts else "")
    if len({*units}) < 2:
        return values, units[0] if units else ""
    if "" in units:
        raise InputError(f"{where}: give all numbers a unit, or none.")
    try:
        pairs = zip(values, units, strict=True)
        return [number_in(f"{x!r} {unit}", units[0]) for x, unit in pairs], units[0]
    except QuantityError as error:
        raise InputError(f"{where}: {error}") from None


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _grid(name: str, values: FloatArray, where: str, unit: str = "") -> Factor:
    if not np.isfinite(values).all():
        raise InputError(f"{where}: all values must be finite numbers.")
    if len(np.unique(values)) < len(values):
        raise InputError(f"{where}: a value is repeated; the same run would be made twice.")
    return Factor(name, values=tuple(values.tolist()), unit=unit)


def _distribution(
    name: str, word: str, numbers: list[float | None], where: str, unit: str = ""
) -> Factor:
    if word not in DISTRIBUTIONS:
        raise InputError(
            f"{where}: there is no distribution {word!r}; there are {' and '.join(DISTRIBUTIONS)}."
        )
    needs = "LOW and HIGH" if word == "uniform" else "a MEAN and a standard deviation SD"
    if len(numbers) != 2 or None in numbers:
        raise InputError(f"{where}: {word} needs {needs}, two finite numbers.")
    first, second = (float(number) for number in numbers if number is not None)
    if word == "uniform" and not first < second:
        raise InputError(f"{where}: LOW {first:g} must be less than HIGH {second:g}.")
    if word == "normal" and not second > 0.0:
        raise InputError(f"{where}: the standard deviation {second:g} must be greater than zero.")
    return Factor(name, distribution=word, bounds=(first, second), unit=unit)
