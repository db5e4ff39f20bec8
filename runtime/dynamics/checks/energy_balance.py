"""Balance of energy between samples, for runs in reduced coordinates, which compute no energy.

Where nothing but potentials acts, the energy stays. Where powers act, they are integrated between
the samples if these are the ends of steps: by Gauss' rule, on the quintic through positions,
velocities and accelerations. Scenes with switches or kinks of functions of time are not judged.
"""

from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from runtime.core import kernel_abi as abi
from runtime.core.arrays import f8, i8, integers, matrix, vector
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.dynamics.output_quantities import SAMPLES
from runtime.integrate.energy_balance import CERTAIN, ERRORS, PART, ROUNDING
from runtime.integrate.problem import Options
from runtime.integrate.sampling import NODES, WEIGHTS
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.samples import Samples

_WAYS = (1e-9, 1e-6)  # measured: of coordinates' sizes; displacements in which rounding is measured
_PARTS = (-3.0, -2.0, -1.0, 1.0, 2.0, 3.0)  # measured: multiples of these displacements
WORST = 3  # safety: changes that are judged, the largest of a run

_X = tuple(0.5 * (1.0 + node) for node in NODES)
_SHARES = tuple(float(weight) for weight in WEIGHTS)
_COUNT = len(_X)


def weigh_ends() -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """What ends weigh at Gauss' nodes, (4 nodes, 6).

    Columns are positions, velocities and accelerations at the first and the second end of an
    interval of length 1; rows give positions, then velocities, of the cubic and then the quintic.
    """
    blocks = []
    for known in (2, 3):
        unit = np.eye(2 * known)
        fits = [
            polynomial.polyval(x, polynomial.polyder(unit, d)) for x in (0, 1) for d in range(known)
        ]
        path, full = np.linalg.inv(np.array(fits)), np.zeros((2, _COUNT, 2, 3))
        for d in range(2):
            values = polynomial.polyval(np.array(_X), polynomial.polyder(path, d)).T
            full[d, :, :, :known] = values.reshape(_COUNT, 2, known)
        blocks.append(full.reshape(2 * _COUNT, 6))
    return np.concatenate(blocks)


WEIGHTS_OF_ENDS = weigh_ends()


@inner
def permit_error(
    kernels: Any, t: Any, q: Any, v: Any, energy: Any, modes: Any, p: Any, mass_rows: Any,
    mass_columns: Any, absolute: Any, rtol: Any, scratch: Any,
) -> float:  # fmt: skip
    """By how much the tolerances permit the energy of a sample to err in a step, J."""
    n, entries, least = q.size, mass_rows.size, 0.0
    errors, mass = scratch[0, :n], scratch[1, :entries]
    for j in range(n):
        errors[j] = absolute[n + j] + rtol * abs(v[j])
    abi.mass_of(kernels)(q, p, mass)
    for i in range(entries):
        least += 0.5 * mass[i] * errors[mass_rows[i]] * errors[mass_columns[i]]
    error = 2.0 * np.sqrt(least * energy[0]) + least
    abi.potential_gradient_of(kernels)(t, q, p, modes, errors)
    for j in range(n):
        error += abs(errors[j]) * (absolute[j] + rtol * abs(q[j]))
    return float(ERRORS * error + ROUNDING * (abs(energy[0]) + abs(energy[1])))


@inner
def measure_missed(
    kernels: Any, t: Any, q: Any, modes: Any, p: Any, sizes: Any, scratch: Any
) -> float:
    """By how much the potential misses its slope along short ways from a sample, J."""
    n, missed = q.size, 0.0
    slope, there, slope_there = scratch[0, :n], scratch[1, :n], scratch[2, :n]
    here = abi.potential_of(kernels)(t, q, p, modes)
    abi.potential_gradient_of(kernels)(t, q, p, modes, slope)
    for way in _WAYS:
        for part in _PARTS:
            expected = 0.0
            for j in range(n):
                there[j] = q[j] + part * way * sizes[j]
            abi.potential_gradient_of(kernels)(t, there, p, modes, slope_there)
            for j in range(n):
                expected += 0.5 * (slope[j] + slope_there[j]) * (there[j] - q[j])
            rise = abi.potential_of(kernels)(t, there, p, modes) - here
            if abs(rise - expected) > missed:  # noqa: PLR1730 (what is no number shows nothing)
                missed = abs(rise - expected)
    return missed


@inner
def integrate_power(
    kernels: Any, t: Any, q: Any, v: Any, a: Any, modes: Any, p: Any, m: Any, rows: Any,
    effects: Any, weights: Any, first: Any, scratch: Any,
) -> tuple[float, float]:  # fmt: skip
    """Work of the powers between two samples, and what they exchange, J.

    The path at the nodes follows from the ends by `weights` from the row `first` on.
    """
    n, h, work, size = q.shape[1], t[1] - t[0], 0.0, 0.0
    there, speed, bend = scratch[0, :n], scratch[1, :n], scratch[2, :n]
    lam, power = scratch[3, :m], scratch[4, :effects]
    for i in range(_COUNT):
        for j in range(n):
            there[j] = speed[j] = 0.0
            for end in range(2):
                for d in range(3):
                    value = q[end, j] if d == 0 else h * v[end, j] if d == 1 else h * h * a[end, j]
                    there[j] += weights[first + i, 3 * end + d] * value
                    speed[j] += weights[first + _COUNT + i, 3 * end + d] * value / h
        instant, total = t[0] + _X[i] * h, 0.0
        if abi.accelerations_of(kernels)(instant, there, speed, p, modes, bend, lam) != 0:
            lam[:] = np.nan
        power[:] = 0.0
        abi.powers_of(kernels)(instant, there, speed, p, modes, lam, power)
        for j in range(rows):
            total += power[j]
        work += 0.5 * h * _SHARES[i] * total
        size += 0.5 * h * _SHARES[i] * abs(total)
    return work, size


@compiled(
    i8(
        ADDRESSES, SAMPLES, integers, vector, i8, i8, integers, integers, vector, vector, f8, f8,
        matrix, matrix, integers, vector,
    )
)  # fmt: skip
def find_unexplained(
    kernels: Any, s: Any, modes: Any, p: Any, m: Any, rows: Any, mass_rows: Any, mass_columns: Any,
    sizes: Any, absolute: Any, rtol: Any, within: Any, weights: Any, scratch: Any, places: Any,
    found: Any,
) -> int:  # fmt: skip
    """The first sample behind which the energy changes by more than work and tolerances explain.

    That is -1 for none. The first of `found` is the change, the second the work, J. Of the largest
    changes, `places` has room for the samples, and `found` behind two numbers for what is left of
    them without the trapezoidal work of the first `rows` of the powers. Between two samples lie
    `within` steps.
    """
    t, q, energy, power = s.t, s.q, s.energy, s.power
    left, wrong = found[2:], t.size
    left[:] = -1.0
    for k in range(t.size - 1):
        work = 0.0
        for j in range(rows):
            work += power[k, j] + power[k + 1, j]
        change = energy[k + 1, 0] + energy[k + 1, 1] - (energy[k, 0] + energy[k, 1])
        rest = abs(change - 0.5 * (t[k + 1] - t[k]) * work)
        i, rest = 0, np.inf if np.isnan(rest) else rest
        while i < left.size and rest > left[i]:  # the least of them is the first
            if i > 0:
                left[i - 1], places[i - 1] = left[i], places[i]
            left[i], places[i] = rest, k
            i += 1
    for i in range(left.size):
        if left[i] < 0.0:
            continue
        k, permitted, work = places[i], 0.0, 0.0
        for j in range(k, k + 2):
            permitted = max(permitted, within * permit_error(
                kernels, t[j], q[j], s.v[j], energy[j], modes, p, mass_rows, mass_columns, absolute,
                rtol, scratch,
            ))  # fmt: skip
            if left[i] <= permitted:
                break
        if left[i] <= permitted:
            continue
        change = energy[k + 1, 0] + energy[k + 1, 1] - (energy[k, 0] + energy[k, 1])
        if rows > 0:
            of, effects = slice(k, k + 2), power.shape[1]
            ends = t[of], q[of], s.v[of], s.a[of]
            work, size = integrate_power(
                kernels, *ends, modes, p, m, rows, effects, weights, 2 * _COUNT, scratch
            )
            rougher, _ = integrate_power(
                kernels, *ends, modes, p, m, rows, effects, weights, 0, scratch
            )
            permitted += abs(work - rougher) + PART * (size + abs(change))
        if not abs(change - work) > permitted:  # what is no number is not judged
            continue
        rounding = 0.0
        for j in range(k, k + 2):
            rounding = max(rounding, measure_missed(kernels, t[j], q[j], modes, p, sizes, scratch))
        if abs(change - work) > permitted + CERTAIN * rounding and k < wrong:
            wrong, found[0], found[1] = k, change, work
    return wrong if wrong < t.size else -1


def describe_unexplained_energy(
    equations: Equations, samples: Samples, sizes: FloatArray, options: Options, steps: int
) -> str:
    """A sentence on a change of energy that the tolerances do not permit; empty for none.

    Between two samples lie `steps` steps at most, or one where the samples are the ends of steps.
    """
    description, t = equations.description, samples.t
    rows = description.balanced_rows
    if len(t) < 2 or rows < 0 or description.switches:
        return ""
    if rows and (options.t_eval is not None or description.time_functions):
        return ""
    if not rows and any(equations.velocity_rhs(float(t[0]), samples.q[0]).tolist()):
        return ""
    widths = equations.n, equations.m, len(description.powers), len(description.mass_rows)
    within, found = 2.0 if options.t_eval is None else 1.0 + steps, np.zeros(2 + WORST)
    k = find_unexplained(
        equations.table, samples, np.zeros(0, np.int64), equations.p, equations.m, rows,
        description.mass_rows, description.mass_columns, sizes,
        options.absolute(sizes, options.rtol), options.rtol, within, WEIGHTS_OF_ENDS,
        np.zeros((5, max(widths))), np.zeros(WORST, np.int64), found,
    )  # fmt: skip
    if k < 0:
        return ""
    what = f"powers do {found[1]:.6g} J of work" if rows else "nothing does work"
    return (
        f"From t = {t[k]:.9g} to {t[k + 1]:.9g} s the energy changes by {found[0]:.6g} J, "
        f"and {what}."
    )
