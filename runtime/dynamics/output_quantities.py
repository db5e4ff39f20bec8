"""Accelerations, reactions, powers, energies and residuals at given states: one compiled loop."""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import types

from runtime.core.array_types import integer_matrix, integers, matrix, vector
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import (
    accelerations_of,
    constraints_of,
    jacobian_of,
    kinetic_energy_of,
    potential_of,
    powers_of,
    reactions_of,
    switched_reactions_of,
    switching_of,
    switching_rates_of,
    velocity_rhs_of,
)
from runtime.mechanism.mechanism import Mechanism
from runtime.results.samples import Samples

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
ENERGIES = ("kinetic_energy", "potential")


@compiled(types.none(
    ADDRESSES, vector, vector, matrix, matrix, integer_matrix, integers, integers, matrix, matrix,
    matrix, matrix, matrix, matrix, integers, vector, vector,
))  # fmt: skip
def _evaluate(
    kernels: Any, times: Any, p: Any, q: Any, v: Any, modes: Any, rows: Any, columns: Any, a: Any,
    lam: Any, reaction: Any, power: Any, energy: Any, residual: Any, weak: Any, slopes: Any,
    phi: Any,
) -> None:  # fmt: skip
    accelerations = accelerations_of(kernels)
    constraints = constraints_of(kernels)
    jacobian = jacobian_of(kernels)
    velocity_rhs = velocity_rhs_of(kernels)
    reactions = reactions_of(kernels)
    switched_reactions = switched_reactions_of(kernels)
    powers = powers_of(kernels)
    kinetic_energy = kinetic_energy_of(kernels)
    potential = potential_of(kernels)
    m = lam.shape[1]
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
        switched_reactions(t, q[k], v[k], p, modes[k], lam[k], reaction[k])
        powers(t, q[k], v[k], p, modes[k], lam[k], power[k])
        energy[k, 0] = kinetic_energy(q[k], v[k], p)
        energy[k, 1] = potential(t, q[k], p, modes[k])


@compiled(types.none(
    ADDRESSES, vector, vector, matrix, matrix, integer_matrix, vector, vector, vector, vector,
))  # fmt: skip
def _find_modes(
    kernels: Any, times: Any, p: Any, q: Any, v: Any, modes: Any, a: Any, lam: Any, g: Any,
    rate: Any,
) -> None:  # fmt: skip
    switching = switching_of(kernels)
    switching_rates = switching_rates_of(kernels)
    accelerations = accelerations_of(kernels)
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
    mechanism: Mechanism,
    p: FloatArray,
    t: FloatArray,
    q: FloatArray,
    v: FloatArray,
    modes: IntArray | None = None,
) -> Samples:
    """Accelerations, reactions, powers, energies and residuals at the instants `t`.

    Parameters
    ----------
    q, v
        Shape (instants, n).
    modes
        Shape (instants, s); determined from the states by default.
    """
    description = mechanism.description
    count, n, m = len(t), len(description.coordinates), len(description.constraints)
    t, q, v = (np.ascontiguousarray(array, dtype=np.float64) for array in (t, q, v))
    if modes is None:
        modes = np.zeros((count, len(description.switches)), dtype=np.int64)
        if description.switches:
            s = len(description.switches)
            _find_modes(
                mechanism.kernel_table, t, p, q, v, modes,
                np.zeros(n), np.zeros(m), np.zeros(s), np.zeros(s),
            )  # fmt: skip
    modes = np.ascontiguousarray(modes, dtype=np.int64)
    a, lam = np.zeros((count, n)), np.zeros((count, m))
    reaction = np.zeros((count, len(description.reactions)))
    power = np.zeros((count, len(description.powers)))
    energy, residual = np.zeros((count, 2)), np.zeros((count, 2))
    weak = np.zeros(count, dtype=np.int64)
    plain = np.where(modes == 2, 0, modes)
    for contact in description.rigid:
        plain[:, contact.switch] = 1
    _evaluate(
        mechanism.kernel_table, t, p, q, v, plain,
        description.jacobian_rows.astype(np.int64), description.jacobian_columns.astype(np.int64),
        a, lam, reaction, power, energy, residual, weak, np.zeros(len(description.jacobian_rows)),
        np.zeros(m),
    )  # fmt: skip
    if description.recovered is not None:
        lam[:, np.setdiff1d(np.arange(m), description.recovered)] = np.nan
    if description.has_masses:
        energy[:, [k for k, name in enumerate(ENERGIES) if name not in description.kernels]] = (
            np.nan
        )
    if (modes == 2).any():
        from runtime.dynamics.sliding_outputs import overwrite_sliding

        share = overwrite_sliding(mechanism, p, t, q, v, modes, a, lam, reaction, power)
    else:
        share = np.full(modes.shape, np.nan)
    return Samples(t, q, v, a, lam, reaction, power, energy, residual, modes, share)
