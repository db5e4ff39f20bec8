"""Settling: let the machine move and take its kinetic energy away at every peak, until it rests.

A dynamic run with kinetic damping: no damping coefficient has to be guessed. Unlike in a
simulation, time is frozen and switching functions are evaluated at rest. The integrator is the
embedded Runge-Kutta pair of Bogacki and Shampine (Applied Mathematics Letters 2, 1989), loosely
controlled: only the position at which the motion ends matters.
"""

from collections import namedtuple
from typing import Any, cast

import numpy as np
from numba import from_dtype

from runtime.core.arrays import i8, integers, matrix, named_tuple_type, vector
from runtime.core.jit import ADDRESSES, compiled, inlined, inner
from runtime.core.kernel_abi import accelerations_of, correction_of, kinetic_energy_of, switching_of
from runtime.core.kinds import CLOSED, MIXED, SLIDING
from runtime.linalg.vectors import axpy, largest_ratio
from runtime.mechanism.dense_equations import FloatArray
from runtime.progress_bar import Progress
from runtime.statics.energy_minimisation import AWAY, StaticEquations

# measured: relative error of a step; only the position at which the motion ends matters
_TOLERANCE = 1e-4
_SHARE = 0.3  # measured: longest step, in parts of the time from rest to the last peak
_QUIET = 1e-10  # accuracy: part of the largest peak of kinetic energy at which the machine rests
_CROSSING = 0.02  # measured: longest step over a change of modes, in parts of the time since rest
_SHORTEST = 1e-12  # safety: s; a step that is short enough for any change of modes
_CORRECTED = 1e-9  # accuracy: scaled change at which a return onto the constraints has converged
_LEAST = 1e-14  # safety: s; a shorter step ends the search
_CHUNK = 2000  # measured: steps between two returns to Python, for progress and interrupts
_CHUNKS = 300  # safety: such chunks before the search is given up

# t: the instant at which time is frozen; step: length of the next step; limit: longest step;
# since: time since rest; energy: kinetic energy; highest: its largest peak so far.
_FLOATS = ["t", "step", "limit", "since", "energy", "highest"]
RECORD = np.dtype([(name, float) for name in _FLOATS] + [("peaks", np.int64), ("steps", np.int64)])

# Rows of `work`, (13, n): four accelerations; q and v at the stages in turn; dq, dv; zeros.
_WORKSPACE = {
    **dict.fromkeys(("p", "scale", "weights", "q", "v", "lam", "g", "bands"), vector),
    **dict.fromkeys(("modes", "at_zero"), integers),
    "work": matrix,
}
Workspace: Any = cast(Any, namedtuple)("Workspace", _WORKSPACE)
WORKSPACE = named_tuple_type(list(_WORKSPACE.values()), Workspace)


@inner
def take_step(kernels: Any, s: Any, t: float, h: float) -> tuple[int, float]:
    """A step from (q, v), with its acceleration in work[0], to rows 8 and 9 of `work`.

    Returns the code of the last accelerations, and the scaled error estimate over its tolerance.
    """
    accelerations, work = accelerations_of(kernels), s.work
    q, v, p, modes, lam, n = s.q, s.v, s.p, s.modes, s.lam, s.q.size
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
        error = max(error, abs(of_q) / s.scale[i], abs(of_v) / s.scale[i])
    return int(weak), error / _TOLERANCE


@inlined
def mode_at_rest(g: float, at_zero: int) -> int:
    """The mode of a condition at rest, by its function and what holds where that is zero."""
    if g == 0.0 and at_zero == MIXED:
        return SLIDING
    return 1 if g > 0.0 or (g == 0.0 and at_zero == CLOSED) else 0


@inner
def count_changed_modes(kernels: Any, s: Any, t: float, q: Any) -> int:
    """Evaluate the switching functions at rest in q; the number of modes that differ from them."""
    still = s.work[12]
    switching_of(kernels)(t, q, still, s.p, s.g)
    changed = 0
    for i in range(s.g.size):
        s.g[i] = 0.0 if abs(s.g[i]) <= s.bands[i] else s.g[i]
        changed += 1 if mode_at_rest(s.g[i], s.at_zero[i]) != s.modes[i] else 0
    return changed


@inner
def try_step(kernels: Any, s: Any, r: Any, h: float) -> tuple[float, float]:
    """The error of a step of length `h`, and the part of `h` to be tried instead, 1 for none."""
    weak, error = take_step(kernels, s, r.t, h)
    if weak != 0 or not error < 1e9:
        return error, 0.25
    if error > 1.0:
        return error, max(0.2, 0.8 * error**-0.5)
    q, v, dq, dv = s.work[8], s.work[9], s.work[10], s.work[11]
    change = np.inf
    for _newton in range(6):
        if correction_of(kernels)(r.t, q, v, s.p, s.weights, dq, dv) != 0:
            return error, 0.25
        axpy(1.0, dq, q)
        axpy(1.0, dv, v)
        change = largest_ratio(dq, s.scale)
        if change <= 1e-3 * _CORRECTED:
            break
    if not change <= _CORRECTED:
        return error, 0.25
    watched = h > max(_CROSSING * (r.since + h), _SHORTEST)
    long = watched and count_changed_modes(kernels, s, r.t, q) > 0
    return error, 0.25 if long else 1.0


@compiled(i8(ADDRESSES, WORKSPACE, from_dtype(RECORD), i8))
def relax(kernels: Any, s: Any, r: Any, count: Any) -> int:
    """Take `count` steps at frozen time; 1 at rest, 0 if not yet, negative where none goes on."""
    q_new, v_new = s.work[8], s.work[9]
    for _ in range(count):
        count_changed_modes(kernels, s, r.t, s.q)
        for i in range(s.g.size):
            s.modes[i] = mode_at_rest(s.g[i], s.at_zero[i])
        if accelerations_of(kernels)(r.t, s.q, s.v, s.p, s.modes, s.work[0], s.lam) != 0:
            return -1
        h = min(r.step, r.limit)
        error, part = try_step(kernels, s, r, h)
        if part < 1.0:
            r.step = part * h
            if r.step < _LEAST:
                return -1
            continue
        r.step = h * min(3.0, 0.8 * max(error, 1e-9) ** (-1.0 / 3.0))
        r.steps += 1
        r.since += h
        energy = kinetic_energy_of(kernels)(q_new, v_new, s.p)
        falls = energy < r.energy
        for i in range(s.q.size):
            s.q[i] = q_new[i]
            s.v[i] = 0.0 if falls else v_new[i]
        if falls:
            r.highest = max(r.highest, r.energy)
            r.peaks += 1
            # From rest to a peak is a quarter of a period: resolve it.
            r.limit = _SHARE * r.since
            r.since = 0.0
            if r.energy <= _QUIET * r.highest:
                return 1
            energy = 0.0
        r.energy = energy
    return 0


def settle_down(
    statics: StaticEquations, q: FloatArray, progress: Progress
) -> tuple[FloatArray, dict[str, int]]:
    """Let the machine fall from q, with a slight push to leave an unstable position, and settle.

    Returns the end of the motion, (n,), and counts.
    """
    equations, scale, n = statics.equations, statics.scale, len(q)
    part, modes = statics.partition(q), equations.rest_modes(statics.t, q)
    modes[(modes == SLIDING) & (equations.boundaries != MIXED)] = 0  # the push leaves its surface
    push = np.random.default_rng(4).normal(size=len(part.independent))
    state = Workspace(
        p=equations.p, scale=scale, weights=scale * scale, q=q.copy(),
        v=np.ascontiguousarray(1e-3 * statics.motions(q, part) @ push), lam=np.zeros(equations.m),
        g=np.zeros(len(modes)), bands=equations.bands, modes=modes,
        at_zero=equations.boundaries, work=np.zeros((13, n)),
    )  # fmt: skip
    record = np.rec.array(np.zeros(1, RECORD))[0]
    record.t, record.step, record.limit = statics.t, 1e-3, np.inf
    for chunk in range(_CHUNKS):
        status = relax(equations.table, state, record, _CHUNK)
        progress(chunk / _CHUNKS)
        if status != 0 or not float(np.abs((state.q - q) / scale).max()) < AWAY:
            break
    return state.q, {"steps": int(record.steps), "kinetic_energy_peaks": int(record.peaks)}
