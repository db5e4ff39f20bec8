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
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.typical_sizes import measure_spread

# accuracy: part of a pivot's reference that the masses alone may cost, in weak pivots: beyond it
# accelerations have nine digits at most
MOST_SPREAD = 1e-2
DOUBTFUL = 1e-3  # safety: of that; a larger spread in one pose asks for others
_VARIANTS: WeakKeyDictionary[Mechanism, Mechanism] = WeakKeyDictionary()
"""Compiled once for each mechanism."""


def suited_to_masses(mechanism: Mechanism, t: float, q: FloatArray, p: FloatArray) -> Mechanism:
    """The mechanism, or, where masses lie too far apart for its kernels, one that bears them."""
    description = mechanism.description
    if not (description.has_masses and description.weak_pivot and mechanism.sufficient is None):
        return mechanism
    equations = Equations(mechanism, p)
    inertia, most = equations.masses(q), MOST_SPREAD / description.weak_pivot
    slopes = np.abs(equations.slopes(t, q))
    if measure_spread(equations.start.table, inertia, slopes) < DOUBTFUL * most:
        return mechanism
    for pose in equations.turned(q):
        slopes = np.maximum(slopes, np.abs(equations.slopes(t, pose)))
    spread = measure_spread(equations.start.table, inertia, slopes)
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
