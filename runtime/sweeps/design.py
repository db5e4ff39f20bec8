"""Designs: the points of a sweep, from factors by a grid or a sample, or from a given dataset."""

import hashlib
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError
from codegen.object_display import counted
from codegen.readers.quantities import QuantityError, converted
from runtime.sweeps.factors import Factor, FloatArray

if TYPE_CHECKING:
    import xarray as xr

GRID, GIVEN = "grid", "given"
SAMPLES = ("lhs", "sobol", "halton", "random", "saltelli")
MOST_RUNS = 50_000_000  # safety: runs of a sweep


@dataclass(frozen=True, eq=False)
class Design:
    """The points of a sweep, one row a run."""

    kind: str  # GRID, GIVEN or one of SAMPLES
    names: tuple[str, ...]
    points: FloatArray  # (runs, factors), in the declared units
    factors: tuple[Factor, ...] = ()  # none of points that were given
    axes: Mapping[str, int] = field(default_factory=dict)  # of a grid: its values, counted by name
    seed: int | None = None  # of a sample
    units: tuple[tuple[str, str], ...] = ()  # by name, where they are not the declared ones

    @property
    def digest(self) -> str:
        """SHA-256 of names and points."""
        content = repr(self.names).encode() + np.ascontiguousarray(self.points).tobytes()
        return hashlib.sha256(content).hexdigest()

    @property
    def facts(self) -> dict[str, Any]:
        """The design as JSON, without its points."""
        return {
            "kind": self.kind,
            "names": [*self.names],
            "factors": {factor.name: factor.text for factor in self.factors},
            "axes": dict(self.axes),
            "seed": self.seed,
        }


NOTHING = Design(GIVEN, (), np.zeros((0, 0)))


def design_of(
    factors: Sequence[Factor], sample: str | None, count: int | None, seed: int
) -> Design:
    """The grid of all combinations, or a sample of so many points.

    Raises
    ------
    InputError
        If factors and sample do not fit, all misfits at once.
    """
    drawn = [factor for factor in factors if factor.distribution]
    kind = sample or (GRID if not drawn else "")
    problems = _misfits(factors, drawn, kind, count)
    if problems:
        raise InputError(problems)
    names = tuple(factor.name for factor in factors)
    units = tuple((factor.name, factor.unit) for factor in factors if factor.unit)
    if kind == GRID:
        mesh = np.meshgrid(*(np.array(factor.values) for factor in factors), indexing="ij")
        points = np.stack([axis.ravel() for axis in mesh], axis=1)
        axes = {factor.name: len(factor.values) for factor in factors}
        return Design(kind, names, points, tuple(factors), axes, units=units)
    assert count is not None
    shares = unit_sample(kind, len(factors), count, seed)
    points = np.stack([f.quantile(shares[:, k]) for k, f in enumerate(factors)], axis=1)
    return Design(kind, names, points, tuple(factors), seed=seed, units=units)


def _misfits(
    factors: Sequence[Factor], drawn: Sequence[Factor], kind: str, count: int | None
) -> list[str]:
    """Sentences about factors, sample and count that do not fit together."""
    if kind not in {"", GRID, *SAMPLES}:
        return [f"There is no sample {kind!r}; there are {GRID}, {', '.join(SAMPLES)}."]
    if not kind:
        names = ", ".join(factor.name for factor in drawn)
        text = (
            f"{names}: an interval or a distribution is "
            "sampled. Say how, by sample and count (lhs, 1000), or give values, "
            "NAME=FIRST:LAST:COUNT."
        )
        return [text]
    if kind == GRID:
        problems = [
            f"{factor.name} is {factor.text}, which a grid cannot take; give values, "
            "NAME=FIRST:LAST:COUNT, or the sample lhs."
            for factor in drawn
        ]
        if count is not None:
            problems.append(f"count is {count}, but a grid has all combinations of its values.")
        total = math.prod(max(len(factor.values), 1) for factor in factors)
        if total > MOST_RUNS:
            problems.append(f"The grid has {total:g} runs; {MOST_RUNS:g} are permitted.")
        return problems
    problems = [
        f"{factor.name} has {factor.text}, but {kind} draws from intervals; give NAME=LOW:HIGH, "
        "NAME=normal:MEAN:SD, or leave out the sample."
        for factor in factors
        if not factor.distribution
    ]
    if count is None:
        problems.append(f"The sample {kind} needs the number of its points, count.")
    else:
        most = MOST_RUNS // (len(factors) + 2 if kind == "saltelli" else 1)
        if not 1 <= count <= most:
            problems.append(f"count is {count}; it must lie from 1 to {most:g}.")
    return problems


def unit_sample(kind: str, dimensions: int, count: int, seed: int) -> FloatArray:
    """Points in the unit cube, (count, dimensions); of "saltelli" (count (dimensions + 2), …)."""
    if kind == "saltelli":
        from runtime.sweeps.sensitivity import saltelli_points

        return saltelli_points(dimensions, count, seed)
    draw = np.random.default_rng(seed)
    if kind == "random":
        return draw.random((count, dimensions))
    from inspect import signature

    from scipy.stats import qmc

    engine = {"lhs": qmc.LatinHypercube, "sobol": qmc.Sobol, "halton": qmc.Halton}[kind]
    word = "rng" if "rng" in signature(engine).parameters else "seed"  # of SciPy before 1.15
    with warnings.catch_warnings():
        # SciPy warns where Sobol's points are not a power of two: any number is a sample.
        warnings.filterwarnings("ignore", message="The balance properties", category=UserWarning)
        return np.asarray(engine(dimensions, **{word: draw}).random(count))


def given_design(points: "xr.Dataset") -> Design:
    """The points of a dataset: a variable or coordinate a factor, in the unit that it names.

    Variables along one dimension are a list of points. A dataset without data variables, of
    coordinates along their own dimensions, is the grid of them. The numbers 0, 1, 2, … along a
    dimension count its points, and are no factor.

    Raises
    ------
    InputError
        If there are no numbers, or a point is repeated; all problems at once.
    """
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
    columns = xr.broadcast(*(points[name] for name in names))
    if columns[0].size > MOST_RUNS:
        raise InputError(
            f"The dataset has {columns[0].size:g} points; {MOST_RUNS:g} are permitted."
        )
    is_grid = not points.data_vars and all(points[name].dims == (name,) for name in names)
    if is_grid:
        for name in names:
            _require_points([name], [points[name]])
    table = _require_points(names, columns)
    units = tuple(
        (name, str(points[name].attrs["units"])) for name in names if "units" in points[name].attrs
    )
    if not is_grid:
        return Design(GIVEN, tuple(names), table, units=units)
    factors = tuple(Factor(name, values=tuple(points[name].values.tolist())) for name in names)
    axes = {name: points[name].size for name in names}
    return Design(GRID, tuple(names), table, factors, axes, units=units)


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


def _require_points(names: Sequence[str], columns: Sequence[Any]) -> FloatArray:
    """The points as rows; InputError if there are none, or one is not finite or is repeated."""
    table = np.stack([np.asarray(column, dtype=float).ravel() for column in columns], axis=1)
    if not len(table):
        raise InputError("The dataset of points is empty.")
    problems = [
        f"{name}: point {int(np.flatnonzero(~np.isfinite(column))[0])} is not a finite number."
        for name, column in zip(names, table.T, strict=True)
        if not np.isfinite(column).all()
    ]
    if problems:
        raise InputError(problems)
    _, first, number = np.unique(table, axis=0, return_inverse=True, return_index=True)[:3]
    earlier = first[np.ravel(number)]
    (again,) = np.nonzero(earlier != np.arange(len(table)))
    if len(again):
        raise InputError(
            f"Point {again[0]} of {', '.join(names)} is that of {earlier[again[0]]}; the same "
            f"run would be made twice. Leave {counted(len(again), 'point')} out."
        )
    return table


def in_declared_units(design: Design, unit_of: Callable[[str], str | None]) -> Design:
    """The design with its points in the units of the machine, by the name of the factor.

    A factor that the machine does not have, of unit None, stays as it is.

    Raises
    ------
    InputError
        If a unit does not fit, all misfits at once.
    """
    points, problems = design.points.copy(), list[str]()
    for name, given in design.units:
        k, declared = design.names.index(name), unit_of(name)
        if declared is None:
            continue
        try:
            points[:, k] = converted(points[:, k], given, declared)
        except QuantityError as error:
            problems.append(f"{name}: {error}")
    if problems:
        raise InputError(problems)
    return replace(design, points=points, units=())
