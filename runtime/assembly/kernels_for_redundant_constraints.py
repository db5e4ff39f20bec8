"""Redundant constraints: kernels with pivoting by size and multipliers of least norm."""

from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numba import njit

from codegen.errors import AnalysisError
from runtime.assembly.accelerations_by_solver import UNCACHED, accelerations_by
from runtime.core.kernel_abi import SIGNATURES, Kernels
from runtime.integrate.method import EXPLICIT, IMPLICIT, alternatives
from runtime.integrate.problem import Correction
from runtime.linalg.dense_elimination import Sparse
from runtime.linalg.redundant_constraints_solve import solve_least_norm, solve_motion
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import Assembly

_VARIANTS: WeakKeyDictionary[Mechanism, dict[tuple[int, ...], Mechanism]] = WeakKeyDictionary()
"""Compiled once for each mechanism and choice of independent constraints."""


def with_redundancy(mechanism: Mechanism, start: Assembly) -> Mechanism:
    """The mechanism, or, if constraints are redundant at its start, one with kernels for that.

    These choose pivots by size, for as many independent constraints as there are at the start, and
    give the multipliers of least norm.
    """
    if not start.redundant:
        return mechanism
    # A dry friction with a given normal force needs no reaction.
    friction = [row.name for row in mechanism.description.effects if row.kind == "friction"]
    if friction:
        raise AnalysisError(
            f"{mechanism.title}: friction in joints ({', '.join(friction)}) follows from "
            f"their reactions, which redundant constraints leave undetermined "
            f"({', '.join(row.name for row in start.redundant)}). Remove one or the other."
        )
    variants = _VARIANTS.setdefault(mechanism, {})
    if start.independent not in variants:
        kernels = _minimum_norm_kernels(
            mechanism.kernels, mechanism.description, len(start.independent)
        )
        variant = replace(mechanism, kernels=kernels, sufficient=start.independent)
        variants[start.independent] = variant
    return variants[start.independent]


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


def _minimum_norm_kernels(kernels: Kernels, description: Description, count: int) -> Kernels:
    """Kernels for which `count` independent constraints suffice."""
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
        accelerations = accelerations_by(solve_motion, kernels, description, m - count)
    else:
        accelerations = njit(SIGNATURES["accelerations"], **UNCACHED)(kinematic)
    corrected = njit(SIGNATURES["correction"], **UNCACHED)(correction)
    return replace(kernels, accelerations=accelerations, correction=corrected)
