"""Freedoms of a mechanism in its pose: rank, velocities, independent coordinates, by dense algebra.

Columns are in typical lengths and rows have unit length, so that nothing depends on the units.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg

from tests.random_mechanisms import parts
from tests.random_mechanisms.constraint_equations import Placement, equations
from tests.random_mechanisms.jets import Derivatives, derivatives, variables
from tests.random_mechanisms.virtual_work import switching_scalar

# Parts of the largest: below it a constraint depends on others, or nearly so.
LEAST_SINGULAR_VALUE = 0.03


def constraint_rows(
    mechanism: parts.Mechanism, q: Any, v: Any, t: float
) -> dict[str, list[Derivatives]]:
    """Joint → the derivatives of its equations at a state."""
    jets, time = variables(q, v, t)
    at = Placement(mechanism, jets, time)
    return {j.name: [derivatives(e, len(q)) for e in equations(j, at)] for j in mechanism.joints}


@dataclass(frozen=True)
class Freedoms:
    """What the constraints leave in the pose."""

    least: float
    """The least singular value of the scaled Jacobian; 0 where there are too many rows."""
    allowed: Any
    """Columns: velocities that all constraints allow, by coordinate, in typical lengths."""
    names: tuple[str, ...]

    @property
    def count(self) -> int:
        """Degrees of freedom."""
        return int(self.allowed.shape[1])

    def independent(self) -> tuple[str, ...]:
        """Coordinates of bodies that determine all others, the most telling one first."""
        if not self.count:
            return ()
        rows = [k for k, name in enumerate(self.names) if name.endswith((".x", ".y", ".phi"))]
        order = scipy.linalg.qr(self.allowed[rows].T, pivoting=True, mode="r")[1]
        return tuple(self.names[rows[k]] for k in order[: self.count])


def freedoms(mechanism: parts.Mechanism, length: float) -> Freedoms:
    """The freedoms in the pose at t = 0; `length` is a typical one, m."""
    names, q = mechanism.coordinates, np.array(mechanism.pose)
    rows = constraint_rows(mechanism, q, np.zeros(len(q)), 0.0)
    jacobian = np.array([row.by_q for group in rows.values() for row in group])
    jacobian = jacobian.reshape(-1, len(q)) * column_sizes(names, length)
    if len(jacobian) == 0:
        return Freedoms(1.0, np.eye(len(q)), names)
    sizes = np.linalg.norm(jacobian, axis=1, keepdims=True)
    if len(jacobian) > len(q) or not np.all(sizes > 0):
        return Freedoms(0.0, np.zeros((len(q), 0)), names)
    _, singular, right = np.linalg.svd(jacobian / sizes)
    return Freedoms(float(singular[-1] / singular[0]), right[len(jacobian) :].T, names)


def slips_are_independent(mechanism: parts.Mechanism, length: float) -> bool:
    """Whether frictions that stick in the pose take a freedom each."""
    names, q = mechanism.coordinates, np.array(mechanism.pose)
    jets, time = variables(q, np.zeros(len(q)), 0.0)
    at = Placement(mechanism, jets, time)
    slips = (
        switching_scalar(f, mechanism, at)
        for f in mechanism.effects
        if isinstance(f, parts.JointFriction | parts.DryFriction)
    )
    rows = [derivatives(s, len(q)).by_q for s in slips if s is not None]
    steps = np.array(rows) * column_sizes(names, length) @ freedoms(mechanism, length).allowed
    if len(steps) > steps.shape[1]:
        return False
    sizes = np.abs(np.array(rows) * column_sizes(names, length)).max(axis=1, keepdims=True)
    return float(np.linalg.svd(steps / sizes, compute_uv=False)[-1]) > 0.1


def column_sizes(names: tuple[str, ...], length: float) -> Any:
    """A typical change of each coordinate: `length` for x and y, 1 rad for angles."""
    return np.array([length if name.endswith((".x", ".y")) else 1.0 for name in names])
