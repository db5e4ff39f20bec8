"""A kernel of accelerations and multipliers that hands its matrices to a solver."""

from typing import Any

import numpy as np
from numba import njit

from runtime.core.arrays import Kernel
from runtime.core.kernel_abi import SIGNATURES, Kernels
from runtime.linalg.dense_elimination import Sparse
from runtime.mechanism.module_tables import Description

UNCACHED: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}}
"""For kernels that close over those of a machine."""


def accelerations_by(solve: Any, kernels: Kernels, description: Description, spare: int) -> Kernel:
    """The kernel `accelerations` by `solve`, of Φ_q, M, Q and γ, for q̈ and λ.

    `solve` answers with the number of dependent constraints, of which `spare` are right.
    """
    jacobian, gamma_of = kernels.jacobian, kernels.acceleration_rhs
    mass_of, forces = kernels.mass, kernels.applied_forces
    resting = description.analysis == "equilibrium"  # such a scene has no γ, which is zero at rest
    rows, columns = description.jacobian_rows, description.jacobian_columns
    mass_rows, mass_columns = description.mass_rows, description.mass_columns
    n, m = len(description.coordinates), len(description.constraints)

    def accelerations(t: Any, q: Any, v: Any, p: Any, modes: Any, a: Any, lam: Any) -> int:
        values, masses = np.empty(rows.size), np.empty(mass_rows.size)
        gamma, force = np.zeros(m), np.empty(n)
        jacobian(t, q, p, values)
        if not resting:
            gamma_of(t, q, v, p, gamma)
        mass_of(q, p, masses)
        forces(t, q, v, p, modes, force)
        slopes, inertia = Sparse(rows, columns, values), Sparse(mass_rows, mass_columns, masses)
        return 0 if solve(slopes, inertia, force, gamma, a, lam) <= spare else m

    made: Kernel = njit(SIGNATURES["accelerations"], **UNCACHED)(accelerations)
    return made
