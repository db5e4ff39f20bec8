"""Settling: let the machine move and take its kinetic energy away at every peak, until it rests.

A dynamic run with kinetic damping: no damping coefficient has to be guessed. Unlike in a
simulation, time is frozen and switching functions are evaluated at rest. The integrator is the
embedded Runge-Kutta pair of Bogacki and Shampine (Applied Mathematics Letters 2, 1989), loosely
controlled: only the position at which the motion ends matters.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import types

from runtime.core.array_types import f8, integers, matrix, vector
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import accelerations_of, correction_of, kinetic_energy_of, switching_of
from runtime.mechanism.dense_equations import FloatArray
from runtime.progress_bar import Progress
from runtime.statics.energy_minimisation import AWAY
from runtime.statics.reduced_gradient import StaticEquations

# measured: relative error of a step; only the position at which the motion ends matters
_TOLERANCE = 1e-4
_SHARE = 0.3  # measured: longest step, in parts of the time from rest to the last peak
_QUIET = 1e-10  # accuracy: part of the largest peak of kinetic energy at which the machine rests
_CROSSING = 0.02  # measured: longest step over a change of modes, in parts of the time since rest
_SHORTEST = 1e-12  # safety: s; a step that is never too long for a change of modes
_CORRECTED = 1e-9  # accuracy: scaled change at which a return onto the constraints has converged
_CHUNK = 2000  # measured: steps between two returns to Python, for progress and interrupts
_CHUNKS = 300  # safety: such chunks before the search is given up

# Places in the record.
STEP, LIMIT, SINCE, ENERGY, HIGHEST, PEAKS, STEPS, RECORD = 0, 1, 2, 3, 4, 5, 6, 7


@inner
def bogacki_shampine(
    accelerations: Any, t: Any, h: Any, q: Any, v: Any, p: Any, modes: Any, lam: Any,
    scale: Any, work: Any,
) -> tuple[int, float]:  # fmt: skip
    """A step from (q, v), with its acceleration in work[0], to rows 8 and 9 of `work`.

    Returns the code of the last accelerations, and the scaled error estimate over its tolerance.
    """
    n = len(q)
    a1, a2, a3, a4 = work[0], work[1], work[2], work[3]
    q2, v2, q3, v3, q4, v4 = work[4], work[5], work[6], work[7], work[8], work[9]
    for i in range(n):
        q2[i] = q[i] + 0.5 * h * v[i]
        v2[i] = v[i] + 0.5 * h * a1[i]
    accelerations(t, q2, v2, p, modes, a2, lam)
    for i in range(n):
        q3[i] = q[i] + 0.75 * h * v2[i]
        v3[i] = v[i] + 0.75 * h * a2[i]
    accelerations(t, q3, v3, p, modes, a3, lam)
    for i in range(n):
        q4[i] = q[i] + h / 9.0 * (2.0 * v[i] + 3.0 * v2[i] + 4.0 * v3[i])
        v4[i] = v[i] + h / 9.0 * (2.0 * a1[i] + 3.0 * a2[i] + 4.0 * a3[i])
    weak = accelerations(t, q4, v4, p, modes, a4, lam)
    error = 0.0
    for i in range(n):
        of_q = h * (-5.0 * v[i] + 6.0 * v2[i] + 8.0 * v3[i] - 9.0 * v4[i]) / 72.0
        of_v = h * h * (-5.0 * a1[i] + 6.0 * a2[i] + 8.0 * a3[i] - 9.0 * a4[i]) / 72.0
        if not np.isfinite(of_q + of_v):  # which a maximum would pass over
            error = np.inf
        error = max(error, abs(of_q) / scale[i], abs(of_v) / scale[i])
    return int(weak), error / _TOLERANCE


@inner
def return_to_constraints(
    correction: Any, t: Any, q: Any, v: Any, p: Any, w: Any, scale: Any, dq: Any, dv: Any
) -> tuple[int, float]:
    """Newton's method for q and v; the code of the last correction, and its scaled change of q."""
    change = np.inf
    weak = 0
    for _newton in range(6):
        weak = correction(t, q, v, p, w, dq, dv)
        if weak != 0:
            break
        change = 0.0
        for i in range(len(q)):
            q[i] += dq[i]
            v[i] += dv[i]
            change = max(change, abs(dq[i]) / scale[i])
            if not np.isfinite(dq[i]):
                change = np.inf
        if not change > 1e-3 * _CORRECTED:
            break
    return int(weak), change


@compiled(types.int64(
    ADDRESSES, f8, vector, vector, vector, vector, vector, integers, vector, vector, vector,
    matrix, types.int64,
))  # fmt: skip
def relax(
    kernels: Any, t: Any, p: Any, w: Any, scale: Any, q: Any, v: Any, modes: Any, g: Any, lam: Any,
    record: Any, work: Any, count: Any,
) -> int:  # fmt: skip
    """Take `count` steps at frozen time; 1 at rest, 0 if not yet, negative on a weak row."""
    accelerations = accelerations_of(kernels)
    correction = correction_of(kernels)
    switching = switching_of(kernels)
    kinetic_energy = kinetic_energy_of(kernels)
    n = len(q)
    a1, q4, v4 = work[0], work[8], work[9]
    dq, dv, still = work[10], work[11], work[12]
    for _ in range(count):
        still[:] = 0.0
        switching(t, q, still, p, g)
        for i in range(len(g)):
            modes[i] = 1 if g[i] > 0.0 else 0
        weak = accelerations(t, q, v, p, modes, a1, lam)
        if weak != 0:
            return -int(weak)
        h = min(record[STEP], record[LIMIT])
        weak, error = bogacki_shampine(accelerations, t, h, q, v, p, modes, lam, scale, work)
        if weak != 0 or not error <= 1.0:
            record[STEP] = h
            record[STEP] *= 0.25 if weak != 0 or not error < 1e9 else max(0.2, 0.8 * error**-0.5)
            if record[STEP] < 1e-14:
                return -1 if weak == 0 else -int(weak)
            continue
        weak, change = return_to_constraints(correction, t, q4, v4, p, w, scale, dq, dv)
        long = False
        if weak == 0 and h > max(_CROSSING * (record[SINCE] + h), _SHORTEST):
            switching(t, q4, still, p, g)
            for i in range(len(g)):
                long = long or (g[i] > 0.0) != (modes[i] == 1)
        if weak != 0 or not change <= _CORRECTED or long:
            record[STEP] = 0.25 * h
            if record[STEP] < 1e-14:
                return -1 if weak == 0 else -int(weak)
            continue
        record[STEP] = h * min(3.0, 0.8 * max(error, 1e-9) ** (-1.0 / 3.0))
        record[STEPS] += 1.0
        record[SINCE] += h
        energy = kinetic_energy(q4, v4, p)
        for i in range(n):
            q[i] = q4[i]
            v[i] = v4[i]
        if energy < record[ENERGY]:
            highest = max(record[HIGHEST], record[ENERGY])
            quiet = record[ENERGY] <= _QUIET * highest
            record[HIGHEST] = highest
            record[PEAKS] += 1.0
            # From rest to a peak is a quarter of a period: resolve it.
            record[LIMIT] = _SHARE * record[SINCE]
            record[SINCE] = 0.0
            v[:] = 0.0
            energy = 0.0
            if quiet:
                return 1
        record[ENERGY] = energy
    return 0


class Settled(NamedTuple):
    """The end of a settling: q, whether the machine rests, peaks of kinetic energy, steps."""

    q: FloatArray
    rests: bool
    peaks: int
    steps: int


def settle_down(statics: StaticEquations, q: FloatArray, progress: Progress) -> Settled:
    """Let the machine fall from q, with a slight push to leave an unstable position, and settle."""
    equations, scale = statics.equations, statics.scale
    n, t = equations.n, statics.t
    part = statics.partition(q)
    push = np.random.default_rng(4).normal(size=len(part.independent))
    v = np.ascontiguousarray(1e-3 * statics.motions(q, part) @ push)
    start, q = q, q.copy()
    modes = equations.rest_modes(t, q)
    w = scale * scale
    record = np.zeros(RECORD)
    record[STEP], record[LIMIT] = 1e-3, np.inf
    lam, g, work = np.zeros(equations.m), np.zeros(len(modes)), np.zeros((13, n))
    status = 0
    for chunk in range(_CHUNKS):
        status = relax(
            equations.table, t, equations.p, w, scale, q, v, modes, g, lam, record, work, _CHUNK,
        )  # fmt: skip
        progress(chunk / _CHUNKS)
        if status != 0 or not float(np.abs((q - start) / scale).max()) < AWAY:
            break
    return Settled(q, status == 1, int(record[PEAKS]), int(record[STEPS]))
