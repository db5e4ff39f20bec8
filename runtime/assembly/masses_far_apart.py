"""Masses that parameter values put far apart: accelerations by the null space of Φ_q.

A generated module orders its elimination for the masses that it was built with. Where those of a
run lie much further apart, the elimination loses digits, and takes constraints for dependent that
are not: pivots of Φ_q M⁻¹ Φ_qᵀ are then as small as a light body's share in M⁻¹ is large.
"""

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from codegen.errors import AnalysisError
from runtime.assembly.accelerations_by_solver import accelerations_by
from runtime.mechanism.dense_equations import Equations, FloatArray, turned
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism

# accuracy: part of a pivot's reference that the masses alone may cost, in weak pivots: beyond it
# accelerations have nine digits at most
_MOST = 1e-2
_DOUBTFUL = 1e-3  # safety: of that; a larger spread in one pose asks for others
_NEGLIGIBLE = 1e-6  # accuracy: a slope of a length, or an arm beside the longest, that is none
_VARIANTS: WeakKeyDictionary[Mechanism, Mechanism] = WeakKeyDictionary()
"""Compiled once for each mechanism."""


def suited_to_masses(mechanism: Mechanism, t: float, q: FloatArray, p: FloatArray) -> Mechanism:
    """The mechanism, or, where masses lie too far apart for its kernels, one that bears them."""
    description = mechanism.description
    if not (description.has_masses and description.weak_pivot and mechanism.sufficient is None):
        return mechanism
    equations = Equations(mechanism, p)
    inertia, most = equations.masses(q), _MOST / description.weak_pivot
    slopes = np.abs(equations.slopes(t, q))
    if mobility_ratio(equations, inertia, slopes) < _DOUBTFUL * most:
        return mechanism
    for pose in turned(description, q):
        slopes = np.maximum(slopes, np.abs(equations.slopes(t, pose)))
    spread = mobility_ratio(equations, inertia, slopes)
    if not spread > most:
        return mechanism
    rubbing = [row.name for row in description.effects if row.kind == "friction"]
    if rubbing:
        raise AnalysisError(
            f"{mechanism.title}: the masses and moments of inertia of this run make constraints "
            f"{spread:.1g} times as mobile as others, far more than those that the module was "
            f"built with, and friction in joints ({', '.join(rubbing)}) needs their reactions. "
            "Declare the parameters with values of this size, so that the build allows for them."
        )
    if mechanism not in _VARIANTS:
        from runtime.linalg.motion_by_null_space import solve_motion_by_null_space

        kernel = accelerations_by(solve_motion_by_null_space, mechanism.kernels, description, 0)
        kernels = replace(mechanism.kernels, accelerations=kernel)
        _VARIANTS[mechanism] = replace(mechanism, kernels=kernels)
    return _VARIANTS[mechanism]


def mobility_ratio(equations: Equations, inertia: FloatArray, slopes: FloatArray) -> float:
    """Largest ratio of two mobilities Φ_ik² / M_kk in a row, from M_kk, (n,), and |Φ_ik|, (nnz,).

    Slopes of lengths and arms that rounding explains feel nothing.
    """
    rows, columns = equations.description.jacobian_rows, equations.description.jacobian_columns
    lengths = equations.description.is_length[columns]
    slopes = np.where(np.isfinite(slopes), slopes, 0.0)
    unit = equations.largest_in_rows(np.where(lengths, slopes, 0.0))
    unit = np.where(unit > 0.0, unit, equations.largest_in_rows(slopes))
    slopes = slopes / np.where(unit > 0.0, unit, 1.0)[rows]
    arms = slopes[~lengths].max(initial=0.0)
    felt = (inertia[columns] > 0.0) & (slopes > _NEGLIGIBLE * np.where(lengths, 1.0, arms))
    mobility = slopes**2 / np.where(inertia > 0.0, inertia, 1.0)[columns]
    most, least = np.zeros(equations.m), np.full(equations.m, np.inf)
    np.maximum.at(most, rows[felt], mobility[felt])
    np.minimum.at(least, rows[felt], mobility[felt])
    return float((most / least).max(initial=1.0))
