"""What follows from states: accelerations, reactions, powers, energies, residuals; and works.

A power is smooth within a step and may jump at an event, where a step ends. So a run with works
samples each step at Gauss' nodes of the intervals between its ends and the output instants in it
(`runtime.integrate.sampling`), which integrates each interval to the order of ten. An impact
changes velocities at an instant; the energy that it takes away is no power, and in no work.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.core import arrays
from runtime.core import kernel_abi as abi
from runtime.core.arrays import IntegerMatrix, Matrix, Vector, integers, matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled, unlocked
from runtime.core.kinds import MIXED, OPEN, SLIDING
from runtime.integrate.sampling import INTERVAL, WEIGHTS
from runtime.linalg.vectors import largest_magnitude
from runtime.mechanism.dense_equations import KEPT, Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.results.samples import Samples

ENERGIES = ("kinetic_energy", "potential")
# numba's type of `Samples`
SAMPLES = arrays.named_tuple_type(
    [vector, *[arrays.matrix] * 8, arrays.integer_matrix, arrays.matrix], Samples
)


@unlocked(
    none(ADDRESSES, SAMPLES, vector, arrays.integer_matrix, integers, integers, vector, vector)
)
def evaluate_samples(
    kernels: Any, s: Any, p: Any, modes: Any, rows: Any, columns: Any, slopes: Any, phi: Any
) -> None:
    """Write what follows from the states of samples; `modes`, (k, s), are 0 and 1."""
    for k in range(len(s.t)):
        t, q, v, a, lam, mode = s.t[k], s.q[k], s.v[k], s.a[k], s.lam[k], modes[k]
        if abi.accelerations_of(kernels)(t, q, v, p, mode, a, lam) != 0:
            a[:] = np.nan
            lam[:] = np.nan
        abi.constraints_of(kernels)(t, q, p, phi)
        s.residual[k, 0] = largest_magnitude(phi)
        abi.velocity_rhs_of(kernels)(t, q, p, phi)
        abi.jacobian_of(kernels)(t, q, p, slopes)
        for j in range(len(rows)):
            phi[rows[j]] -= slopes[j] * v[columns[j]]
        s.residual[k, 1] = largest_magnitude(phi)
        abi.reactions_of(kernels)(t, q, v, p, lam, s.reaction[k])
        abi.switched_reactions_of(kernels)(t, q, v, p, mode, lam, s.reaction[k])
        abi.powers_of(kernels)(t, q, v, p, mode, lam, s.power[k])
        s.energy[k, 0] = abi.kinetic_energy_of(kernels)(q, v, p)
        s.energy[k, 1] = abi.potential_of(kernels)(t, q, p, mode)


@compiled(none(ADDRESSES, SAMPLES, vector, matrix, matrix, integers))
def _find_modes(kernels: Any, s: Any, p: Any, bands: Any, work: Any, at_zero: Any) -> None:
    g, rate = work[0], work[1]
    for k in range(len(s.t)):
        t, q, v, modes = s.t[k], s.q[k], s.v[k], s.modes[k]
        abi.switching_of(kernels)(t, q, v, p, g)
        boundary = False
        for i in range(len(g)):
            modes[i] = 1 if g[i] > 0.0 else 0
            boundary = boundary or abs(g[i]) <= bands[0, i]
        if boundary:
            abi.accelerations_of(kernels)(t, q, v, p, modes, s.a[k], s.lam[k])
            abi.switching_rates_of(kernels)(t, q, v, s.a[k], p, rate)
            for i in range(len(g)):
                if g[i] == 0.0 and at_zero[i] == MIXED:
                    modes[i] = SLIDING
                elif g[i] == 0.0 and rate[i] > bands[1, i] and at_zero[i] != OPEN:
                    modes[i] = 1  # g > 0 does not hold yet
                elif abs(g[i]) <= bands[0, i] and abs(rate[i]) <= bands[1, i]:
                    modes[i] = min(at_zero[i], SLIDING)  # 2: the mean of both sides, or mixed


def _find_bands(mechanism: Mechanism, p: Vector, samples: Samples) -> Matrix:
    """Of g and dg/dt, (2, s): joints and drivers keep both at zero so closely where they do.

    A machine that stands has a trace of a speed, and accelerations as rounded as its forces.
    """
    rates, n, s = mechanism.kernels.switching_rates, samples.q.shape[1], samples.modes.shape[1]
    size, speed = np.abs(samples.q).max(axis=0), np.abs(samples.v).max(axis=0)
    speed = np.maximum(speed, KEPT * max(1.0, float(size.max(initial=0.0))))

    def rates_at(v: Vector, a: Vector) -> Vector:
        out = np.zeros(s)
        rates(samples.t[0], samples.q[0], v, a, p, out)
        return out

    still = np.zeros(n)
    rest, spread = rates_at(still, still), np.zeros(s)
    for by_position, by_velocity in zip(np.diag(size), np.diag(speed), strict=True):
        spread += np.abs(rates_at(by_position, still) - rest)
        spread += np.abs(rates_at(still, by_velocity) - rest)
    per_second = float((speed[size > 0.0] / size[size > 0.0]).max(initial=0.0))
    bands: Matrix = KEPT * np.nan_to_num(np.outer([1.0, per_second], spread))
    if mechanism.description.has_masses:
        for by_acceleration in np.diag(_free_accelerations(mechanism, p, samples)):
            change = np.abs(rates_at(still, by_acceleration) - rest)
            bands[1] += KEPT * np.nan_to_num(change, posinf=0.0)
    return bands


def _free_accelerations(mechanism: Mechanism, p: Vector, samples: Samples) -> Vector:
    """Sizes of what the forces alone would give, (n,), at the ends of the samples."""
    equations, most = Equations(mechanism, p), np.zeros(samples.q.shape[1])
    for row in (0, -1):
        t, q, v = float(samples.t[row]), samples.q[row], samples.v[row]
        masses = np.abs(equations.masses(q))
        for modes in (np.zeros_like(samples.modes[0]), np.ones_like(samples.modes[0])):
            forces = np.abs(np.nan_to_num(equations.forces(t, q, v, modes), posinf=0.0, neginf=0.0))
            most = np.maximum(
                most, np.divide(forces, masses, np.zeros_like(most), where=masses > 0.0)
            )
    return most


def evaluate(
    mechanism: Mechanism, p: Vector, t: Vector, q: Matrix, v: Matrix,
    modes: IntegerMatrix | None = None,
) -> Samples:  # fmt: skip
    """Accelerations, reactions, powers, energies and residuals at the instants `t`, (k,).

    States are (k, n), modes (k, s); these are determined from the states by default.
    """
    description, kernels = mechanism.description, mechanism.kernel_table
    count, n, m = len(t), len(description.coordinates), len(description.constraints)
    s = len(description.switches)
    given = np.zeros((count, s)) if modes is None else modes
    widths = n, m, len(description.reactions), len(description.powers), 2, 2
    t, q, v = (np.ascontiguousarray(array, dtype=np.float64) for array in (t, q, v))
    a, lam, reaction, power, energy, residual = (np.zeros((count, width)) for width in widths)
    states, share = np.ascontiguousarray(given, dtype=np.int64), np.full((count, s), np.nan)
    samples = Samples(t, q, v, a, lam, reaction, power, energy, residual, states, share)
    if modes is None and s:
        bands = _find_bands(mechanism, p, samples)
        _find_modes(kernels, samples, p, bands, np.zeros((2, s)), description.boundaries)
    plain = np.where(samples.modes == SLIDING, 0, samples.modes)
    plain[:, [contact.switch for contact in description.rigid]] = 1
    plain[:, [k for k, row in enumerate(description.switches) if row.one_way]] = 1
    rows, columns = description.jacobian_rows, description.jacobian_columns
    evaluate_samples(
        kernels, samples, p, plain, rows.astype(np.int64), columns.astype(np.int64),
        np.zeros(len(rows)), np.zeros(m),
    )  # fmt: skip
    if (samples.modes == SLIDING).any():
        from runtime.dynamics.sliding_outputs import overwrite_sliding

        overwrite_sliding(mechanism, p, samples)
    leave_out_unknown(description, samples)
    return samples


def leave_out_unknown(description: Description, samples: Samples) -> None:
    """Make no numbers of multipliers and energies that the kernels do not compute, and 0 of -0."""
    if description.recovered is not None:
        every = np.arange(len(description.constraints))
        samples.lam[..., np.setdiff1d(every, description.recovered)] = np.nan
    if description.has_masses:
        unknown = [k for k, name in enumerate(ENERGIES) if name not in description.kernels]
        samples.energy[..., unknown] = np.nan
    for values in (samples.reaction, samples.power):
        np.add(values, 0.0, out=values)


def along_intervals(t: FloatArray, power: FloatArray) -> FloatArray:
    """Integrals of a power, W, over the intervals of a quadrature: (k,) each, k samples of it."""
    nodes = power[1:].reshape(-1, INTERVAL)[:, :-1]
    pieces: FloatArray = 0.5 * np.diff(t[::INTERVAL]) * (nodes @ WEIGHTS)
    return pieces


def integrate_works(result: Result, count: int, times: npt.ArrayLike | None) -> None:
    """Add the works that its scene asks for to a result, and drop the samples at nodes.

    The result's run has the start as its first sample, then for each interval its nodes and its
    end: `count` samples; possibly then the state in which it stopped. `times` are the output
    instants in s; None: the end of every step.
    """
    samples = result.samples
    ends = samples.t[:count:INTERVAL]
    kept = np.zeros(len(samples.t), dtype=np.bool_)
    kept[:count:INTERVAL] = True if times is None else np.isin(ends, times)
    if result.failed or result.ended_by:
        kept[-1:] = True
    for name, column in result.description.work_rows.items():
        pieces = along_intervals(samples.t[:count], samples.power[:count, column])
        work = np.full(len(samples.t), np.nan)
        work[:count:INTERVAL] = np.concatenate([[0.0], np.cumsum(pieces)])[: len(ends)]
        result.works[name] = work[kept]
        result.work_at_end[name] = float(pieces.sum())
    result.samples = Samples._make(array[kept] for array in samples)
