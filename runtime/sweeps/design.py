"""Designs: the points of a sweep, by a grid or a sample of factors, or from a given dataset.

A factor is a name with values, an interval or a distribution, read from text as well:

J1=200:1000:81            81 values at equal distances, ends included
J1=225,450,900            these values
J1=200:1000               an interval, from which a sample draws uniformly
J1=uniform:200:1000       the same
J1=normal:450:20          mean and standard deviation
J1=log:1:1000:4           4 values at equal ratios, ends included
l=100 mm:20 cm:4          in units of their own, which all numbers have
"""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import signature
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import BaseModel, PositiveInt

from codegen.errors import InputError, module_of_extra
from codegen.object_display import counted
from codegen.readers.quantities import QUANTITY, UnitError, converted, number_in
from codegen.readers.values import finite_float, one_line, shown
from runtime.core.arrays import Matrix, Vector
from runtime.results.motion_at_instants import finite_numbers

if TYPE_CHECKING:
    import xarray as xr

GRID, GIVEN, SALTELLI = "grid", "given", "saltelli"
SAMPLES = ("lhs", "sobol", "halton", "random", SALTELLI)
DISTRIBUTIONS = {"uniform": "LOW and HIGH", "normal": "a MEAN and a standard deviation SD"}
MOST_RUNS = 50_000_000  # safety: runs of a sweep
_MOST_VALUES = 10_000_000  # safety: values of one factor
_FORM = (
    "write NAME=FIRST:LAST:COUNT, NAME=A,B,C, NAME=log:FIRST:LAST:COUNT, NAME=uniform:LOW:HIGH or "
    "NAME=normal:MEAN:SD"
)


class Design(BaseModel, frozen=True):
    """What a store says of its points."""

    kind: str  # GRID, GIVEN or one of SAMPLES
    factors: dict[str, str]  # in words, by name
    axes: dict[str, PositiveInt] = {}  # of a grid: its values, counted by name
    seed: int | None = None  # of a sample


@dataclass(frozen=True, eq=False)
class Factor:
    """A quantity that varies over a sweep: a parameter or a start value."""

    name: str
    values: Vector = field(default_factory=lambda: np.zeros(0))  # none of a sample
    distribution: str = ""  # of a sample: one of DISTRIBUTIONS
    bounds: tuple[float, float] = (math.nan, math.nan)  # low and high, or mean and deviation
    unit: str = ""  # that of the text, where it is not the declared one
    is_column: bool = False  # whether the values are those of all runs, one after the other

    @property
    def text(self) -> str:
        """The factor in words, as files and messages have it."""
        if self.distribution:
            return f"{self.distribution} {self.bounds[0]:g} {self.bounds[1]:g} {self.unit}".rstrip()
        first, last = self.values[0], self.values[-1]
        return f"{len(self.values)} values from {first:g} to {last:g} {self.unit}".rstrip()

    def quantile(self, share: Vector) -> Vector:
        """Values below which a share, (k,) from 0 to 1, of the distribution lies."""
        first, second = self.bounds
        if self.distribution == "uniform":
            return first + share * (second - first)
        from scipy.special import ndtri

        within = np.clip(share, np.finfo(float).tiny, 1.0 - 2.0**-53)  # 0 and 1 lie at infinity
        return np.asarray(first + second * ndtri(within))


def read_design(
    over: "Mapping[str, Any] | Sequence[str] | xr.Dataset", sample: str | None, count: int | None,
    seed: int, unit_of: Callable[[str], str],
) -> tuple[Design, Matrix]:  # fmt: skip
    """A design and its points, (runs, factors), in the units that the machine declares.

    `unit_of` returns the unit of a factor by its name, and raises InputError where there is none.

    Raises InputError if factors, sample and units do not fit, all misfits at once.
    """
    if not hasattr(over, "data_vars"):
        factors = read_factors(over)
    elif sample is None and count is None:
        factors = _factors_of(over)
    else:
        raise InputError("A dataset of points is the design: leave out sample and count.")
    is_list = any(factor.is_column for factor in factors)
    kind = GIVEN if is_list else sample or GRID
    problems = [] if is_list else _misfits(factors, kind, count)
    for factor in factors:
        try:
            declared = unit_of(factor.name)
            if factor.unit:
                converted(np.ones(1), factor.unit, declared)
        except InputError as error:
            problems += error.problems
        except UnitError as error:
            problems.append(f"{factor.name}: {error}")
    if problems:
        raise InputError(problems)
    axes = dict[str, int]()
    if is_list:
        columns = [factor.values for factor in factors]
    elif kind == GRID:
        axes = {factor.name: len(factor.values) for factor in factors}
        mesh = np.meshgrid(*(factor.values for factor in factors), indexing="ij")
        columns = [np.ravel(axis) for axis in mesh]
    else:
        shares = unit_sample(kind, len(factors), count or 0, seed)
        columns = [factor.quantile(shares[:, k]) for k, factor in enumerate(factors)]
    columns = [
        converted(column, factor.unit, unit_of(factor.name)) if factor.unit else column
        for factor, column in zip(factors, columns, strict=True)
    ]
    words = {factor.name: factor.text for factor in factors}
    drawn = seed if kind in SAMPLES else None
    return Design(kind=kind, factors=words, axes=axes, seed=drawn), np.stack(columns, axis=1)


def _misfits(factors: Sequence[Factor], kind: str, count: int | None) -> list[str]:
    """Sentences about factors, sample and count that do not fit together."""
    if kind not in {GRID, *SAMPLES}:
        return [f"There is no sample {kind!r}; there are {GRID}, {', '.join(SAMPLES)}."]
    problems = [
        f"{factor.name} is {factor.text}, which the {kind} cannot take; give values, "
        "NAME=FIRST:LAST:COUNT, to a grid, and an interval, NAME=LOW:HIGH, or a distribution, "
        "NAME=normal:MEAN:SD, to a sample, by sample and count (lhs, 1000)."
        for factor in factors
        if bool(factor.distribution) == (kind == GRID)
    ]
    runs = (count or 0) * (len(factors) + 2 if kind == SALTELLI else 1)
    if kind == GRID:
        runs = math.prod(len(factor.values) for factor in factors)
        if count is not None:
            problems.append(f"count is {count}, but a grid has all combinations of its values.")
    elif count is None:
        problems.append(f"The sample {kind} needs the number of its points, count.")
    elif kind == SALTELLI and count & (count - 1):  # of which Sobol's sequence is balanced
        near = 2 ** max(round(np.log2(count)), 1)
        problems.append(
            f"count is {count}; of the sample saltelli it must be a power of 2, such as {near}."
        )
    if runs > MOST_RUNS:
        problems.append(f"The {kind} has {runs:g} runs; {MOST_RUNS:g} are permitted.")
    return problems


def unit_sample(kind: str, dimensions: int, count: int, seed: int) -> Vector:
    """Points in the unit cube, (count, dimensions); of "saltelli" (count (dimensions + 2), …)."""
    if kind == SALTELLI:
        problem = salib_problem([f"x{k}" for k in range(dimensions)])
        sampled = salib("sample.sobol").sample(problem, count, calc_second_order=False, seed=seed)
        return np.asarray(sampled)
    draw = np.random.default_rng(seed)
    if kind == "random":
        return draw.random((count, dimensions))
    from scipy.stats import qmc

    engine = {"lhs": qmc.LatinHypercube, "sobol": qmc.Sobol, "halton": qmc.Halton}[kind]
    word = "rng" if "rng" in signature(engine).parameters else "seed"  # of SciPy before 1.15
    with warnings.catch_warnings():
        # SciPy warns where Sobol's points are not a power of two: any number is a sample.
        warnings.filterwarnings("ignore", message="The balance properties", category=UserWarning)
        return np.asarray(engine(dimensions, **{word: draw}).random(count))


def salib(module: str) -> Any:
    """A module of SALib; InputError with the command that installs it."""
    return module_of_extra(f"SALib.{module}", "sensitivity", "Sensitivity indices need SALib")


def salib_problem(names: Sequence[str]) -> dict[str, Any]:
    """Factors from 0 to 1, as SALib has them."""
    bounds = [[0.0, 1.0]] * len(names)
    return {"num_vars": len(names), "names": np.array([*names]), "bounds": bounds}


def _factors_of(points: Any) -> tuple[Factor, ...]:
    """The factors of a dataset: a variable or coordinate each, in the unit that it names.

    Variables along one dimension are a list of points. A dataset without data variables, of
    coordinates along their own dimensions, is the grid of them.
    """
    import pandas as pd
    import xarray as xr

    names = [str(name) for name in (*points.data_vars, *points.coords)]
    names = [name for name in names if not _counts_points(points, name)]
    problems = [
        f"The points of {name} are no numbers." for name in names
        if points[name].dtype.kind not in "iuf"
    ]  # fmt: skip
    if not names:
        problems.append("The dataset of points has no variables and no coordinates.")
    if problems:
        raise InputError(problems)
    units = [str(points[name].attrs.get("units", "")) for name in names]
    if not points.data_vars and all(points[name].dims == (name,) for name in names):
        return tuple(
            _grid(name, points[name].values.astype(float), name, unit)
            for name, unit in zip(names, units, strict=True)
        )
    columns = xr.broadcast(*(points[name] for name in names))
    if not 0 < columns[0].size <= MOST_RUNS:
        raise InputError(
            f"The dataset has {columns[0].size:g} points; it must have 1 to {MOST_RUNS:g}."
        )
    table = np.stack([column.values.astype(float).ravel() for column in columns], axis=1)
    for name, column in zip(names, table.T, strict=True):
        wrong = np.flatnonzero(~np.isfinite(column))
        problems += [f"{name}: point {wrong[0]} is not a finite number."] if len(wrong) else []
    again = np.flatnonzero(pd.DataFrame(table).duplicated())
    if len(again) and not problems:
        problems.append(
            f"Point {again[0]} of {', '.join(names)} is that of an earlier one; the same run would "
            f"be made twice. Leave {counted(len(again), 'point')} out."
        )
    if problems:
        raise InputError(problems)
    triples = zip(names, table.T, units, strict=True)
    return tuple(Factor(name, column, unit=unit, is_column=True) for name, column, unit in triples)


def _counts_points(points: "xr.Dataset", name: str) -> bool:
    """Whether a coordinate only numbers the points of its dimension."""
    index = points[name]
    others = (x for other, x in points.variables.items() if other != name)
    return (
        name in points.dims
        and index.dtype.kind in "iu"
        and bool((index.values == np.arange(index.size)).all())
        and any(name in x.dims for x in others)
    )


def read_factors(over: Mapping[str, Any] | Sequence[str]) -> tuple[Factor, ...]:
    """The factors of a mapping from names, or of texts ``NAME=...``.

    Raises InputError: one sentence for each factor that cannot be read.
    """
    found, problems = dict[str, Factor](), list[str]()
    if isinstance(over, Mapping):
        pairs = [*over.items()]
    else:
        parts = (text.partition("=") for text in over)
        pairs = [(name.strip(), given.strip()) for name, _, given in parts]
    for name, given in pairs:
        try:
            if not name:
                raise InputError(f"over, ={given}: {_FORM}.")
            if name in found:
                problems.append(f"{name} is varied twice; give it once.")
            found[name] = read_factor(name, given)
        except InputError as error:
            problems += error.problems
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
        if QUANTITY.fullmatch(given[0]):
            return _read_text(name, ",".join(map(str, given)), where)
        return _distribution(name, given[0], [finite_float(x) for x in given[1:]], where)
    values = finite_numbers(given)
    if values is None:
        raise InputError(
            f"{where} is {shown(given)}; it must be numbers, all finite, a text such as "
            "'200:1000:81', or a distribution such as (\"normal\", 1.0, 0.01)."
        )
    return _grid(name, values, where)


def _read_text(name: str, text: str, where: str) -> Factor:
    word, *rest = parts = [part.strip() for part in text.split(":")]
    if rest and word[:1].isalpha() and word != "log":
        values, unit = _numbers(rest, where) if word in DISTRIBUTIONS else ([], "")
        return _distribution(name, word, values, where, unit)
    if not rest:
        values, unit = _numbers(text.split(","), where)
        return _grid(name, np.array(values), where, unit)
    if len(parts) == 2 and word != "log":
        values, unit = _numbers(parts, where)
        return _distribution(name, "uniform", values, where, unit)
    if len(parts) != (4 if word == "log" else 3):
        raise InputError(f"{where}: {_FORM}.")
    (first, last), unit = _numbers(parts[-3:-1], where)
    (count,), strange = _numbers(parts[-1:], where)
    if strange or not (count.is_integer() and 1 <= count <= _MOST_VALUES):
        raise InputError(
            f"{where}: the count is {count:g}; it must be a whole number from 1 to "
            f"{_MOST_VALUES:g}."
        )
    if count == 1 and first != last:
        raise InputError(f"{where}: one value cannot be both {first:g} and {last:g}; give one.")
    if word != "log":
        return _grid(name, np.linspace(first, last, int(count)), where, unit)
    if first * last <= 0.0:
        raise InputError(f"{where}: equal ratios lead from {first:g} to {last:g} by no way.")
    return _grid(name, np.geomspace(first, last, int(count)), where, unit)


def _numbers(texts: Sequence[str], where: str) -> tuple[list[float], str]:
    """Numbers in the unit of the first one, and that unit; empty where they have none."""
    parts = [QUANTITY.fullmatch(text) for text in texts]
    units = [(part[2] or "").strip() for part in parts if part]
    if len(units) < len(parts):
        raise InputError(f"{where}: {_FORM}.")
    if "" in units and any(units):
        raise InputError(f"{where}: give all numbers a unit, or none.")
    try:
        return [number_in(text, units[0]) for text in texts], units[0]
    except UnitError as error:
        raise InputError(f"{where}: {error}") from None


def _grid(name: str, values: Vector, where: str, unit: str = "") -> Factor:
    if not len(values) or not np.isfinite(values).all():
        raise InputError(f"{where}: all values must be finite numbers, and at least one.")
    if len(np.unique(values)) < len(values):
        raise InputError(f"{where}: a value is repeated; the same run would be made twice.")
    return Factor(name, values, unit=unit)


def _distribution(
    name: str, word: str, numbers: Sequence[float | None], where: str, unit: str = ""
) -> Factor:
    if word not in DISTRIBUTIONS:
        raise InputError(
            f"{where}: there is no distribution {word!r}; there are {' and '.join(DISTRIBUTIONS)}."
        )
    if len(numbers) != 2 or None in numbers:
        raise InputError(f"{where}: {word} needs {DISTRIBUTIONS[word]}, two finite numbers.")
    first, second = (float(number) for number in numbers if number is not None)
    if word == "uniform" and not first < second:
        raise InputError(f"{where}: LOW {first:g} must be less than HIGH {second:g}.")
    if word == "normal" and not second > 0.0:
        raise InputError(f"{where}: the standard deviation {second:g} must be greater than zero.")
    return Factor(name, distribution=word, bounds=(first, second), unit=unit)
