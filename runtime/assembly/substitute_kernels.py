"""Kernels in place of a module's own, which solve with pivots chosen by size.

Redundant constraints, of which as many are independent as at the start, take multipliers of least
norm. Masses that parameter values put far apart take the null space of Φ_q: a module orders its
elimination for the masses that it was built with, and takes constraints for dependent that are not
where pivots of Φ_q M⁻¹ Φ_qᵀ are as small as a light body's share in M⁻¹ is large.
"""

from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numba import njit

from codegen.errors import AnalysisError
from runtime.core.arrays import Kernel
from runtime.core.kernel_abi import SIGNATURES, Kernels
from runtime.integrate.method import EXPLICIT, IMPLICIT, alternatives
from runtime.integrate.problem import Correction
from runtime.linalg.dense_elimination import Sparse
from runtime.linalg.redundant_constraints_solve import solve_least_norm, solve_motion
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.mechanism.typical_sizes import measure_spread
from runtime.results.assembled_state import Assembly

# accuracy: part of a pivot's reference that the masses alone may cost, in weak pivots: beyond it
# accelerations have nine digits at most
MOST_SPREAD = 1e-2
DOUBTFUL = 1e-3  # safety: of that; a larger spread in one pose asks for others
_UNCACHED: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}}
_VARIANTS: WeakKeyDictionary[Mechanism, dict[tuple[int, ...], Mechanism]] = WeakKeyDictionary()
"""Compiled once for each mechanism and choice of independent constraints, () of far masses."""


def suited_equations(equations: Equations, start: Assembly) -> Equations:
    """The equations, or those whose kernels bear redundant constraints or masses far apart.

    Raises AnalysisError where friction needs the reactions that these leave open.
    """
    mechanism = equations.mechanism
    if start.redundant:
        names = ", ".join(row.name for row in start.redundant)
        why = f"which redundant constraints leave undetermined ({names}). Remove one or the other."
    elif spread := _spread_of_masses(equations, start.t, start.q):
        why = (
            "and the masses and moments of inertia of this run make constraints "
            f"{spread:.1g} times as mobile as others, far more than those that the module was "
            "built with. Declare the parameters with values of this size, so that the build "
            "allows for them."
        )
    else:
        return equations
    # A dry friction with a given normal force needs no reaction.
    friction = [row.name for row in equations.description.effects if row.kind == "friction"]
    if friction:
        raise AnalysisError(
            f"{mechanism.title}: friction in joints ({', '.join(friction)}) follows from "
            f"their reactions, {why}"
        )
    variants = _VARIANTS.setdefault(mechanism, {})
    key = start.independent if start.redundant else ()
    if key not in variants:
        make = _least_norm_variant if start.redundant else _null_space_variant
        variants[key] = make(mechanism, start.independent)
    return Equations(variants[key], equations.p)


def _spread_of_masses(equations: Equations, t: float, q: FloatArray) -> float:
    """How much more mobile some constraints are than others, where kernels do not bear it; or 0."""
    description = equations.description
    if not (description.has_masses and description.weak_pivot):
        return 0.0
    table, inertia = equations.start.table, equations.masses(q)
    slopes, most = np.abs(equations.slopes(t, q)), MOST_SPREAD / description.weak_pivot
    if measure_spread(table, inertia, slopes) < DOUBTFUL * most:
        return 0.0
    for pose in equations.turned(q):
        slopes = np.maximum(slopes, np.abs(equations.slopes(t, pose)))
    spread = float(measure_spread(table, inertia, slopes))
    return spread if spread > most else 0.0


def projection_only(
    mechanism: Mechanism, begin: Assembly, method: str, correction: Correction
) -> Correction:
    """The return onto redundant constraints; refuses methods that need independent ones.

    Off the constraints a redundant row appears independent, which would mislead a partition of the
    coordinates.
    """
    names = ", ".join(row.name for row in begin.redundant)
    if method in IMPLICIT:
        raise AnalysisError(
            f"{mechanism.title}: method {method!r} needs independent constraints, and "
            f"{names} follow from others. Take {alternatives(EXPLICIT)}, or remove them."
        )
    if correction not in {"step", "projection"}:
        raise AnalysisError(
            f"{mechanism.title}: with redundant constraints ({names}) states return by "
            f'projection; correction={correction!r} needs independent ones. Leave it at "step".'
        )
    return "projection"


def redundancy_note(start: Assembly) -> str:
    """Sentence of a result about redundant constraints; empty without any."""
    if not start.redundant:
        return ""
    return (
        f" Redundant: {', '.join(row.name for row in start.redundant)}; the reactions of "
        f"{', '.join(start.not_unique)} are not unique, those of least norm are given."
    )


def _null_space_variant(mechanism: Mechanism, independent: tuple[int, ...]) -> Mechanism:
    from runtime.linalg.motion_by_null_space import solve_motion_by_null_space

    kernels, description = mechanism.kernels, mechanism.description
    kernel = _accelerations_by(solve_motion_by_null_space, kernels, description, 0)
    return replace(mechanism, kernels=replace(kernels, accelerations=kernel))


def _least_norm_variant(mechanism: Mechanism, independent: tuple[int, ...]) -> Mechanism:
    """The mechanism with kernels for which as many independent constraints suffice."""
    kernels, description, count = mechanism.kernels, mechanism.description, len(independent)
    jacobian, constraints, rates = kernels.jacobian, kernels.constraints, kernels.velocity_rhs
    gamma_of = kernels.acceleration_rhs
    rows, columns = description.jacobian_rows, description.jacobian_columns
    n, m = len(description.coordinates), len(description.constraints)

    def kinematic(t: Any, q: Any, v: Any, p: Any, modes: Any, a: Any, lam: Any) -> int:
        values, right, d = np.empty(rows.size), np.empty((1, m)), np.empty((1, n))
        jacobian(t, q, p, values)
        gamma_of(t, q, v, p, right[0])
        rank = solve_least_norm(Sparse(rows, columns, values), np.ones(n), right, d)
        a[:] = d[0]
        lam[:] = 0.0
        return 0 if rank >= count else m

    def correction(t: Any, q: Any, v: Any, p: Any, w: Any, dq: Any, dv: Any) -> int:
        values, right, d = np.empty(rows.size), np.empty((2, m)), np.empty((2, n))
        jacobian(t, q, p, values)
        constraints(t, q, p, right[0])
        rates(t, q, p, right[1])
        for i in range(m):
            right[0, i] = -right[0, i]
        for k in range(rows.size):
            right[1, rows[k]] -= values[k] * v[columns[k]]
        rank = solve_least_norm(Sparse(rows, columns, values), w, right, d)
        dq[:] = d[0]
        dv[:] = d[1]
        return 0 if rank >= count else m

    if description.has_masses:
        accelerations = _accelerations_by(solve_motion, kernels, description, m - count)
    else:
        accelerations = njit(SIGNATURES["accelerations"], **_UNCACHED)(kinematic)
    corrected = njit(SIGNATURES["correction"], **_UNCACHED)(correction)
    kernels = replace(kernels, accelerations=accelerations, correction=corrected)
    return replace(mechanism, kernels=kernels, sufficient=independent)


def _accelerations_by(solve: Any, kernels: Kernels, description: Description, spare: int) -> Kernel:
    """The kernel `accelerations` by `solve`, of Φ_q, M, Q and γ, for q̈ and λ.

    `solve` returns the number of dependent constraints, of which `spare` are right.
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

    made: Kernel = njit(SIGNATURES["accelerations"], **_UNCACHED)(accelerations)
    return made
