"""Errors of a motion against a reference, scaled so that metres, radians and newtons compare.

The error of quantity j is

    e_j(t) = |y_j(t) - r_j(t)| / (s_j + |r_j(t)|)

with a physical scale s_j of its own: the mixed error of the IVP Test Set (F. Mazzia, C. Magherini,
Test Set for Initial Value Problem Solvers, 2008), with s_j in place of atol/rtol. It is evaluated
at instants that are fixed beforehand, not at the steps of a method.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from codegen.errors import InputError
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result

_RESTING = 1e-9  # accuracy: share of a typical size per second, below which a velocity is rest


@dataclass(frozen=True)
class Scale:
    """The physical scale of a quantity."""

    name: str
    unit: str
    group: str  # "positions", "velocities", or "others": accelerations, reactions, energies, powers
    value: float  # s_j, in the unit


@dataclass(frozen=True)
class Errors:
    """Scaled errors of a run.

    The first four are over positions and velocities where there are any, and over all quantities
    otherwise. `relative` has max(|r|, s) in place of s + |r|: the measure of the IFToMM benchmarks
    (M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, Multibody System Dynamics 16, 2006).
    """

    worst: float  # over instants and quantities; -log10 of it is the number of correct digits
    rms: float  # root of the mean square over instants and quantities
    end: float  # largest at the last instant
    relative: float  # root of the mean square
    groups: dict[str, float]  # group of quantities → its largest error
    each: dict[str, float]  # quantity → its largest error


def series_values(result: Result, names: Sequence[str]) -> FloatArray:
    """The series as columns, (k, j)."""
    columns = [result.series(name)[0] for name in names]
    return np.stack(columns, axis=1) if columns else np.zeros((len(result.t), 0))


def require_numbers(description: Description, names: Sequence[str], values: FloatArray) -> None:
    """Refuse series without a finite value in (k, j), whose error would otherwise count as 0."""
    finite = np.isfinite(values)
    without = [name for j, name in enumerate(names) if not finite[:, j].any()]
    if without and len(values):
        raise InputError(
            f"{description.title}: {name} is no number at any of the {len(values)} output "
            "instants, so it has no error. Leave it out, or correct its definition."
            for name in without
        )


def magnitude(values: FloatArray) -> float:
    """Largest magnitude of the finite values."""
    return float(np.abs(np.where(np.isfinite(values), values, 0.0)).max(initial=0.0))


def group_magnitude(result: Result, name: str) -> float:
    """Largest magnitude in a run of the whole that a series is a part of; 0 of other series.

    The total energy of a machine without losses is zero or nearly so where the potential is counted
    from a convenient height, and a bearing may carry nothing in one direction: such a series is
    rounding, which cannot be measured by itself. Energies are measured by all energies, the
    components of a joint's or an effect's force by the whole force.
    """
    row = result.description.series.get(name)
    if row is None or row.array not in {"energy", "reaction"}:
        return 0.0
    if row.array == "energy":
        return magnitude(result.samples.energy)
    part = attrgetter("array", "element", "unit", "quantity")
    parts = [one for one in result.description.series if part(one) == part(row)]
    return max(magnitude(result.column(one)) for one in parts)


def scales(
    names: Sequence[str], units: Sequence[str], description: Description, sizes: FloatArray,
    reference: FloatArray, whole: Sequence[float] | float = 0.0,
) -> tuple[Scale, ...]:  # fmt: skip
    """The scale of each series (j,), by its values `reference` (k, j) and the typical `sizes` (n,).

    Positions have the machine's typical sizes: 1 rad, and a length. Velocities and all others have
    the largest magnitude in the reference; velocities at rest have the typical size per second,
    components of a joint's force that of the whole force, energies that of all energies: `whole`
    (j,), by `group_magnitude`.
    """
    largest = np.maximum([magnitude(column) for column in reference.T], whole)
    rows = description.coordinates
    size_of = {row.name: float(size) for row, size in zip(rows, sizes, strict=True)}
    rate_of = {row.velocity: size_of[row.name] for row in rows}

    def scale(name: str, unit: str, most: float) -> Scale:
        if name in size_of:
            return Scale(name, unit, "positions", size_of[name])
        if name in rate_of:
            rests = most <= _RESTING * rate_of[name]
            return Scale(name, unit, "velocities", rate_of[name] if rests else most)
        return Scale(name, unit, "others", most or 1.0)

    return tuple(map(scale, names, units, largest.tolist()))


def with_signs_of(reference: FloatArray, values: FloatArray, names: Sequence[str]) -> FloatArray:
    """Values, (k, j), with Euler parameters and their rates in the reference's sign: p is -p."""
    values = values.copy()
    for body in {name[:-3] for name in names if re.fullmatch(r"\w+\.e[0-3]", name)}:
        own = [j for j, name in enumerate(names) if re.match(rf"(a\()?{body}\.e[0-3]", name)]
        p = [j for j in own if names[j][:-1] == f"{body}.e"]
        opposite = np.sum(values[:, p] * reference[:, p], axis=1) < 0.0
        values[np.ix_(opposite, own)] *= -1.0
    return values


def scaled_errors(values: FloatArray, reference: FloatArray, scale: FloatArray) -> FloatArray:
    """e_j(t), (k, j); infinite where the run has no finite number, 0 where the reference has none.

    In a singular configuration there are no accelerations and no reactions. A series that is zero
    throughout has the scale 0 and the error 0.
    """
    gap = np.abs(values - reference)
    error = np.divide(gap, scale + np.abs(reference), out=np.zeros_like(gap), where=gap > 0.0)
    error[~np.isfinite(values) | ~np.isfinite(error)] = np.inf
    return np.where(np.isfinite(reference), error, 0.0)


def errors(values: FloatArray, reference: FloatArray, by: Sequence[Scale]) -> Errors:
    """The errors of a run, whose values and reference, (k, j), are at the same instants."""
    size = np.array([scale.value for scale in by])
    values = with_signs_of(reference, values, [scale.name for scale in by])
    e = scaled_errors(values, reference, size)
    r = np.where(np.isfinite(reference), np.abs(reference), 0.0)
    relative = e * (size + r) / np.maximum(size, r)
    moving = np.array([scale.group != "others" for scale in by])
    counts, most = moving if moving.any() else ~moving, e.max(axis=0).tolist()
    groups = dict[str, float]()
    for scale, worst in zip(by, most, strict=True):
        groups[scale.group] = max(groups.get(scale.group, 0.0), worst)

    def rms(x: FloatArray) -> float:
        return float(np.sqrt(np.mean(x[:, counts] ** 2)))

    return Errors(
        worst=float(e[:, counts].max()), rms=rms(e), end=float(e[-1, counts].max()),
        relative=rms(relative), groups=groups,
        each=dict(zip((scale.name for scale in by), most, strict=True)),
    )  # fmt: skip
