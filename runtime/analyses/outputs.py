"""Accelerations, reactions, powers, energies and residuals at given states: one compiled loop."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from numba import types

from runtime.integrate.signatures import compiled
from runtime.kernels import MATRIX, MODE_ROWS, MODES, TYPES, VECTOR
from runtime.results.samples import Samples

if TYPE_CHECKING:
    from runtime.machine import Machine

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@compiled(
    types.none(
        TYPES["accelerations"],
        TYPES["constraints"],
        TYPES["jacobian"],
        TYPES["velocity_rhs"],
        TYPES["reactions"],
        TYPES["powers"],
        TYPES["kinetic_energy"],
        TYPES["potential"],
        VECTOR,
        VECTOR,
        MATRIX,
        MATRIX,
        MODE_ROWS,
        MODES,
        MODES,
        MATRIX,
        MATRIX,
        MATRIX,
        MATRIX,
        MATRIX,
        MATRIX,
        MODES,
        VECTOR,
    ),
)
def _evaluate(
    accelerations: Any,
    constraints: Any,
    jacobian: Any,
    velocity_rhs: Any,
    reactions: Any,
    powers: Any,
    kinetic_energy: Any,
    potential: Any,
    times: Any,
    p: Any,
    q: Any,
    v: Any,
    modes: Any,
    rows: Any,
    columns: Any,
    a: Any,
    lam: Any,
    reaction: Any,
    power: Any,
    energy: Any,
    residual: Any,
    weak: Any,
    slopes: Any,
) -> None:
    m = lam.shape[1]
    phi = np.zeros(m)
    for k in range(len(times)):
        t = times[k]
        weak[k] = accelerations(t, q[k], v[k], p, modes[k], a[k], lam[k])
        if weak[k] != 0:
            a[k, :] = np.nan
            lam[k, :] = np.nan
        constraints(t, q[k], p, phi)
        largest = 0.0
        for i in range(m):
            largest = max(largest, abs(phi[i]))
        residual[k, 0] = largest
        velocity_rhs(t, q[k], p, phi)
        jacobian(t, q[k], p, slopes)
        for j in range(len(rows)):
            phi[rows[j]] -= slopes[j] * v[k, columns[j]]
        largest = 0.0
        for i in range(m):
            largest = max(largest, abs(phi[i]))
        residual[k, 1] = largest
        reactions(t, q[k], v[k], p, lam[k], reaction[k])
        powers(t, q[k], v[k], p, modes[k], lam[k], power[k])
        energy[k, 0] = kinetic_energy(q[k], v[k], p)
        energy[k, 1] = potential(t, q[k], p, modes[k])


@compiled(
    types.none(
        TYPES["switching"],
        TYPES["switching_rates"],
        TYPES["accelerations"],
        VECTOR,
        VECTOR,
        MATRIX,
        MATRIX,
        MODE_ROWS,
        VECTOR,
        VECTOR,
        VECTOR,
        VECTOR,
    ),
)
def _find_modes(
    switching: Any,
    switching_rates: Any,
    accelerations: Any,
    times: Any,
    p: Any,
    q: Any,
    v: Any,
    modes: Any,
    a: Any,
    lam: Any,
    g: Any,
    rate: Any,
) -> None:
    for k in range(len(times)):
        switching(times[k], q[k], v[k], p, g)
        boundary = False
        for i in range(len(g)):
            modes[k, i] = 1 if g[i] > 0.0 else 0
            boundary = boundary or g[i] == 0.0
        if boundary:
            accelerations(times[k], q[k], v[k], p, modes[k], a, lam)
            switching_rates(times[k], q[k], v[k], a, p, rate)
            for i in range(len(g)):
                if g[i] == 0.0 and rate[i] > 0.0:
                    modes[k, i] = 1


def evaluate(
    machine: "Machine",
    p: FloatArray,
    t: FloatArray,
    q: FloatArray,
    v: FloatArray,
    modes: IntArray | None = None,
) -> Samples:
    """Everything that follows from the states at the instants `t`.

    Parameters
    ----------
    q, v
        Shape (instants, n).
    modes
        Shape (instants, s); found from the states where not given.
    """
    told, kernels = machine.description, machine.kernels
    count, n, m = len(t), len(told.coordinates), len(told.constraints)
    t, q, v = (np.ascontiguousarray(array, dtype=np.float64) for array in (t, q, v))
    if modes is None:
        modes = np.zeros((count, len(told.switches)), dtype=np.int64)
        if told.switches:
            s = len(told.switches)
            _find_modes(
                kernels.switching, kernels.switching_rates, kernels.accelerations,
                t, p, q, v, modes, np.zeros(n), np.zeros(m), np.zeros(s), np.zeros(s),
            )  # fmt: skip
    modes = np.ascontiguousarray(modes, dtype=np.int64)
    a, lam = np.zeros((count, n)), np.zeros((count, m))
    reaction = np.zeros((count, len(told.reactions)))
    power = np.zeros((count, len(told.powers)))
    energy, residual = np.zeros((count, 2)), np.zeros((count, 2))
    weak = np.zeros(count, dtype=np.int64)
    _evaluate(
        kernels.accelerations, kernels.constraints, kernels.jacobian, kernels.velocity_rhs,
        kernels.reactions, kernels.powers, kernels.kinetic_energy, kernels.potential,
        t, p, q, v, modes,
        told.jacobian_rows.astype(np.int64), told.jacobian_columns.astype(np.int64),
        a, lam, reaction, power, energy, residual, weak, np.zeros(len(told.jacobian_rows)),
    )  # fmt: skip
    return Samples(t, q, v, a, lam, reaction, power, energy, residual, modes)
