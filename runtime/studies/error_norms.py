"""Errors of a motion against a reference, scaled so that metres, radians and newtons compare.

Of each quantity j the error is

    e_j(t) = |y_j(t) - r_j(t)| / (s_j + |r_j(t)|)

with a physical scale s_j of its own: the mixed error of the IVP Test Set (F. Mazzia, C. Magherini,
Test Set for Initial Value Problem Solvers, 2008), with s_j in place of atol/rtol. It is taken at
instants that are fixed beforehand, not at those that a method chose.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.results.time_series import ENERGIES

if TYPE_CHECKING:
    from runtime.mechanism.description import Description
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

MOTION = ("positions", "velocities")
_RESTING = 1e-9
"""Share of a typical size a second below which a velocity is that of rest."""


class Scale(NamedTuple):
    """What an error of a quantity is measured by.

    Attributes
    ----------
    group
        "positions", "velocities", or "others": accelerations, reactions, energies, powers.
    value
        s_j, in the unit.
    """

    name: str
    unit: str
    group: str
    value: float


@dataclass(frozen=True)
class Errors:
    """Scaled errors of a run.

    Attributes
    ----------
    worst
        Largest over instants and quantities: -log10 of it are the digits that a run has.
    rms
        Root of the mean square over instants and quantities.
    end
        Largest at the last instant.
    relative
        Root of the mean square, with max(|r|, s) in place of s + |r|: the measure of the IFToMM
        benchmarks (M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, Multibody System Dynamics 16,
        2006).
    groups
        Group of quantities → its `worst`. The four numbers above are over positions and velocities
        where there are any, and over all quantities else.
    each
        Quantity → its largest error.
    """

    worst: float
    rms: float
    end: float
    relative: float
    groups: dict[str, float]
    each: dict[str, float]


def require_numbers(told: "Description", names: Sequence[str], values: FloatArray) -> None:
    """Refuse quantities that have no value at all, and so no error: 0 would be told of them.

    Parameters
    ----------
    values : (k, j)
        Of a run, or of a part of it.

    Raises
    ------
    InputError
        With each that is finite at none of the instants.
    """
    finite = np.isfinite(values)
    lost = [name for j, name in enumerate(names) if not finite[:, j].any()]
    if lost and len(values):
        raise InputError(
            f"{told.title}: {name} is no number at any of the {len(values)} output instants, so "
            "there is no error of it. Leave it out, or correct what it is made of."
            for name in lost
        )


def kindred(result: "Result", name: str) -> float:
    """Largest magnitude in a run of what a series is a part of; 0 of one that stands alone.

    The total energy of a machine without losses is zero or nearly so where the potential is counted
    from a convenient height, and a bearing may bear nothing in one direction: what is left there is
    rounding, and no measure of itself.
    """
    told = result.description
    if name in ENERGIES:
        return _largest(result.samples.energy)
    for row in told.reactions:
        if name == f"{row.element}.{row.component}":
            return max(
                _largest(result.reaction(other.element, other.component))
                for other in told.reactions
                if (other.element, other.unit) == (row.element, row.unit)
            )
    return 0.0


def _largest(values: FloatArray) -> float:
    """Largest magnitude of the finite ones."""
    return float(np.abs(np.where(np.isfinite(values), values, 0.0)).max(initial=0.0))


def scales(
    names: Sequence[str], units: Sequence[str], told: "Description", sizes: FloatArray,
    reference: FloatArray, whole: Sequence[float] | None = None,
) -> tuple[Scale, ...]:  # fmt: skip
    """The scale of each quantity.

    Positions have the machine's typical sizes: 1 rad, and a length. Velocities and all else have
    the largest magnitude in the reference, velocities at rest the typical size a second, parts of
    a joint's force that of the force, energies that of all.

    Parameters
    ----------
    names, units : (j,)
        Quantities as `Result.series` knows them.
    sizes : (n,)
        Typical sizes of the coordinates: `runtime.mechanism.dense_equations`.
    reference : (k, j)
    whole : (j,)
        What each is a part of: see `kindred`.
    """
    largest = np.array([_largest(column) for column in reference.T])
    if whole is not None:
        largest = np.maximum(largest, whole)
    size_of = {row.name: float(size) for row, size in zip(told.coordinates, sizes, strict=True)}
    rate_of = {row.velocity: size_of[row.name] for row in told.coordinates}
    found = []
    for name, unit, most in zip(names, units, largest.tolist(), strict=True):
        if name in size_of:
            found.append(Scale(name, unit, "positions", size_of[name]))
        elif name in rate_of:
            still = most <= _RESTING * rate_of[name]
            found.append(Scale(name, unit, "velocities", rate_of[name] if still else most))
        else:
            found.append(Scale(name, unit, "others", most or 1.0))
    return tuple(found)


def scaled(found: FloatArray, reference: FloatArray, by: Sequence[Scale]) -> FloatArray:
    """e_j(t), (k, j); infinite where the run has no finite number, 0 where the reference has none.

    At a singular position there are no accelerations and no reactions.
    """
    size = np.array([scale.value for scale in by])
    error = np.abs(found - reference) / (size + np.abs(reference))
    error = np.where(np.isfinite(error), error, np.inf)
    return np.where(np.isfinite(reference), error, 0.0)


def errors(found: FloatArray, reference: FloatArray, by: Sequence[Scale]) -> Errors:
    """The errors of a run.

    Parameters
    ----------
    found, reference : (k, j)
        Quantities at the same instants.
    """
    e = scaled(found, reference, by)
    size = np.array([scale.value for scale in by])
    r = np.where(np.isfinite(reference), np.abs(reference), 0.0)
    relative = e * (size + r) / np.maximum(size, r)
    moving = np.array([scale.group in MOTION for scale in by])
    counts = moving if moving.any() else ~moving
    groups: dict[str, float] = {}
    for scale, worst in zip(by, e.max(axis=0).tolist(), strict=True):
        groups[scale.group] = max(groups.get(scale.group, 0.0), worst)
    return Errors(
        float(e[:, counts].max()),
        float(np.sqrt(np.mean(e[:, counts] ** 2))),
        float(e[-1, counts].max()),
        float(np.sqrt(np.mean(relative[:, counts] ** 2))),
        groups,
        {scale.name: worst for scale, worst in zip(by, e.max(axis=0).tolist(), strict=True)},
    )
