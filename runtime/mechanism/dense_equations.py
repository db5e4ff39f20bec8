"""The equations of a machine at one instant, as dense arrays, for analyses of few positions."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.mechanism.mechanism import Mechanism
from runtime.singularity.scaled_constraints import ScaledConstraints

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

# measured: part of the largest distance from the origin; a machine counts as no smaller
_PLACES = 0.01
_NOTHING = 1e-9  # accuracy: m; a length below this is rounding


class Motion(NamedTuple):
    """Accelerations and multipliers at a state; `weak` is 1 + the constraint that failed, or 0."""

    a: FloatArray
    lam: FloatArray
    weak: int


class Equations:
    """Kernels of a machine with its parameter values bound."""

    def __init__(self, mechanism: Mechanism, p: FloatArray) -> None:
        self.description = mechanism.description
        self.kernels = mechanism.kernels
        self.table = mechanism.kernel_table
        self.p = p
        self.independent = np.array(mechanism.independent, dtype=np.int64)
        self.n = len(mechanism.description.coordinates)
        self.m = len(mechanism.description.constraints)

    def scaled(self, scale: FloatArray, independent: IntArray) -> ScaledConstraints:
        """The constraints in units of `scale`, of which `independent` follow from no others."""
        description, kernels = self.description, self.kernels
        return ScaledConstraints(
            kernels.constraints,
            kernels.jacobian,
            kernels.velocity_rhs,
            np.asarray(description.jacobian_rows, dtype=np.int64),
            np.asarray(description.jacobian_columns, dtype=np.int64),
            self.p,
            scale,
            independent,
            self.m,
        )

    def constraints(self, t: float, q: FloatArray) -> FloatArray:
        """Phi(q, t), shape (m,)."""
        phi = np.zeros(self.m)
        self.kernels.constraints(t, q, self.p, phi)
        return phi

    def jacobian(self, t: float, q: FloatArray) -> FloatArray:
        """Phi_q, shape (m, n)."""
        description = self.description
        values = np.zeros(len(description.jacobian_rows))
        self.kernels.jacobian(t, q, self.p, values)
        matrix = np.zeros((self.m, self.n))
        matrix[description.jacobian_rows, description.jacobian_columns] = values
        return matrix

    def velocity_rhs(self, t: float, q: FloatArray) -> FloatArray:
        """nu = -Phi_t, shape (m,)."""
        nu = np.zeros(self.m)
        self.kernels.velocity_rhs(t, q, self.p, nu)
        return nu

    def acceleration_rhs(self, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
        """gamma, shape (m,)."""
        gamma = np.zeros(self.m)
        self.kernels.acceleration_rhs(t, q, v, self.p, gamma)
        return gamma

    def mass(self, q: FloatArray) -> FloatArray:
        """M, shape (n, n)."""
        description = self.description
        values = np.zeros(len(description.mass_rows))
        self.kernels.mass(q, self.p, values)
        matrix = np.zeros((self.n, self.n))
        matrix[description.mass_rows, description.mass_columns] = values
        return matrix

    def forces(self, t: float, q: FloatArray, v: FloatArray, modes: IntArray) -> FloatArray:
        """Q, shape (n,)."""
        force = np.zeros(self.n)
        self.kernels.applied_forces(t, q, v, self.p, modes, force)
        return force

    def potential(self, t: float, q: FloatArray, modes: IntArray) -> float:
        """V in J."""
        return float(self.kernels.potential(t, q, self.p, modes))

    def potential_gradient(self, t: float, q: FloatArray, modes: IntArray) -> FloatArray:
        """dV/dq, shape (n,)."""
        g = np.zeros(self.n)
        self.kernels.potential_gradient(t, q, self.p, modes, g)
        return g

    def motion(self, t: float, q: FloatArray, v: FloatArray, modes: IntArray) -> Motion:
        """Accelerations and multipliers of the free motion."""
        a, lam = np.zeros(self.n), np.zeros(self.m)
        weak = int(self.kernels.accelerations(t, q, v, self.p, modes, a, lam))
        return Motion(a, lam, weak)

    def rest_modes(self, t: float, q: FloatArray) -> IntArray:
        """Modes at rest, shape (s,); a condition at its boundary does not hold."""
        g = np.zeros(len(self.description.switches))
        if len(g) == 0:
            return np.zeros(0, dtype=np.int64)
        self.kernels.switching(t, q, np.zeros(self.n), self.p, g)
        modes: IntArray = (g > 0.0).astype(np.int64)
        return modes

    def size(self, t: float, q: FloatArray) -> float:
        """A length typical of the mechanism, in m, from how angles enter lengths; 1 if none do."""
        matrix = self.jacobian(t, q)
        length = self.description.is_length
        mixed = np.any(matrix[:, length] != 0.0, axis=1)
        arms = np.abs(matrix[np.ix_(mixed, ~length)])
        reach = float(arms.max(initial=0.0))
        places = float(np.abs(q[length]).max(initial=0.0))
        return max(reach, 1e-3 * places) if reach > 0.0 else places or 1.0

    def scale(self, size: float) -> FloatArray:
        """Typical change of each coordinate: `size` for lengths, else 1, shape (n,)."""
        return np.where(self.description.is_length, size, 1.0)

    def row_units(self, matrix: FloatArray) -> list[str]:
        """Unit of each constraint: m where a length enters, else that of its coordinates."""
        units = np.array([row.unit for row in self.description.coordinates])
        found = (set(units[row != 0.0].tolist()) for row in matrix)
        return [of.pop() if len(of) == 1 else "m" if "m" in of or not of else "1" for of in found]

    def misses(self, values: FloatArray, units: list[str]) -> dict[tuple[str, str], float]:
        """Largest |value| of the rows of each joint and unit, by (element, unit)."""
        found: dict[tuple[str, str], float] = {}
        for row, unit, value in zip(self.description.constraints, units, values, strict=True):
            key = (row.element, unit)
            found[key] = max(found.get(key, 0.0), abs(float(value)))
        return found


def magnitudes(equations: Equations, t: float, q: FloatArray) -> FloatArray:
    """Typical size of each coordinate at a position, in its unit.

    Angles and numbers have size 1. Lengths have that of the mechanism: its longest arm; where no
    angle enters a length, the largest distance from the origin at the start; where that is zero
    too, the largest length in the constraints, then among the parameters, and 1 m where there is
    none.

    Parameters
    ----------
    q : (n,)
        An assembled position.

    Returns
    -------
    (n,)
    """
    length = equations.description.is_length
    places = float(np.abs(q[length]).max(initial=0.0))
    matrix = equations.jacobian(t, q)
    mixed = np.any(matrix[:, length] != 0.0, axis=1)
    reach = float(np.abs(matrix[np.ix_(mixed, ~length)]).max(initial=0.0))
    if reach > _NOTHING:
        return equations.scale(max(reach, _PLACES * places))
    if places > _NOTHING:
        return equations.scale(places)
    units = equations.row_units(matrix)
    gaps = equations.constraints(t, equations.description.neutral)
    fixed = max((abs(gap) for gap, unit in zip(gaps, units, strict=True) if unit == "m"), default=0)
    if not fixed > _NOTHING:
        declared = zip(equations.description.parameters, equations.p, strict=False)
        fixed = max((abs(value) for row, value in declared if row.unit == "m"), default=0.0)
    return equations.scale(float(fixed) if fixed > _NOTHING else 1.0)
