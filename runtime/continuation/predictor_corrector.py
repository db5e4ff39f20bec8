"""Compiled predictor-corrector that follows a driven motion from instant to instant.

Each step predicts q from position, velocity and acceleration and corrects it by Newton's method.
A step is halved where the prediction is poor, so that the machine stays on its branch however far
apart the instants lie, and where Newton's method fails, so that a lock-up is approached to the
last position at which the machine still assembles.

A step can be so long that it lands on another assembly of the machine, close to a position in which
two of them meet or almost meet. So the pivots of Phi_q are compared now and then, in one order: on
one assembly the determinant keeps its sign. At a suspicion the code is SUSPECT, the state good.
"""

from collections import namedtuple
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numba import from_dtype

from runtime.continuation.arclength import Curve, Piece
from runtime.core import arrays
from runtime.core.arrays import f8, i8, vector
from runtime.core.jit import ADDRESSES, compiled, inner
from runtime.core.kernel_abi import TYPES, accelerations_of, correction_of, jacobian_of
from runtime.linalg.dense_elimination import Sparse, eliminate_rows, fill_unit_rows, smallest_pivot
from runtime.linalg.rank_policy import REDUNDANT
from runtime.linalg.vectors import axpy, copy_vector, largest_ratio
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.assembled_state import Assembly
from runtime.singularity.scaled_constraints import SHORTEST

if TYPE_CHECKING:
    from runtime.continuation.bifurcation_branches import Zone

DONE, STUCK, SUSPECT, ARRIVED = 0, 1, 2, 3

_PREDICTED = 0.05  # measured: largest scaled error of a prediction that names the branch
_TRAVEL = 0.5  # measured: scaled motion of the longest step
_TRIES = 4096  # safety: steps, rejected ones included, before an interrupt is heard
_ITERATIONS = 30  # safety: of Newton's method for a position
_MARGIN = 0.5  # measured: of the smallest pivot; scaled motion until pivots are compared again
_WARY = 0.01  # measured: the same where rows of drivers may vanish, whose pivots fall at once
_LOST = 1e-6  # measured: pivot of such a row next to which accelerations are rounding
_POOR = 0.5  # measured: of the smallest pivots at both ends; a smaller one between is suspicious
_GOOD = 0.05  # measured: smallest pivot of a state to which the continuation may return
_VANISHED = 1e-4  # measured: of `SHORTEST` of a driver's row; a start with less is singular
STEEP = 1e6  # safety: growth of a slope of Phi since the start that counts as unbounded

# The record that a continuation keeps. t: instant of the state; barrier: instant to stop at, or not
# a number; travel: scaled motion since pivots were compared; least: the smallest then, negative
# where they are to be computed first; best: the largest of these since the continuation began or
# was resumed; margin: of the smallest, the motion until they are compared again; lost: the largest
# pivot that has no sign. At a suspicion, end: instant until which pivots were followed; zero: part
# of the way there at which one of them vanishes. compared: when pivots were compared last; good:
# when they were last about as good as the best; mark: number of instants done.
_FLOATS = ["t", "step", "barrier", "travel", "least", "best", "margin", "lost", "end"]
_FLOATS += ["zero", "compared_t", "good_t"]
_COUNTS = ["mark", "compared_mark", "good_mark", "steps", "rejected", "newton"]
RECORD = np.dtype([(name, float) for name in _FLOATS] + [(name, np.int64) for name in _COUNTS])

# Its arrays: those of the equations; the state, q to modes; samples, (instants, n); Phi_q, (m, n),
# the pivots at the last comparison, now and in between, (3, m), and their columns at the last
# comparison and elsewhere, (2, m); q and v at the last comparison, where pivots were good, and of a
# trial step, with their changes.
_WORKSPACE = {
    **dict.fromkeys(("p", "scale", "weights", "shortest", "q", "v", "a", "lam", "values"), vector),
    **dict.fromkeys(("modes", "rows", "columns"), arrays.integers),
    **dict.fromkeys(
        ("q_out", "v_out", "dense", "pivots", "compared", "good", "trial"), arrays.matrix
    ),
    "orders": arrays.integer_matrix,
}
Workspace: Any = cast(Any, namedtuple)("Workspace", _WORKSPACE)
WORKSPACE = arrays.named_tuple_type(list(_WORKSPACE.values()), Workspace)


@compiled(arrays.tuple_type((i8, f8, f8, i8))(TYPES["correction"], f8, *[vector] * 7))
def return_to_motion(
    correction: Any, t: Any, q: Any, v: Any, p: Any, w: Any, scale: Any, dq: Any, dv: Any
) -> tuple[int, float, float, int]:
    """Newton's method for q(t), then v, from a prediction.

    Returns 0, 1 + the constraint whose pivot is weak, or -1 where it does not contract; the first
    scaled changes of q and of v; and the number of iterations.
    """
    previous, first, iterations = 0.0, np.inf, 0
    while True:
        weak = correction(t, q, v, p, w, dq, dv)
        iterations += 1
        if weak != 0:
            return int(weak), first, np.inf, iterations
        size = largest_ratio(dq, scale)
        if iterations == 1:
            first = size
        elif size > 0.5 * previous and size > 1e-9:
            return -1, first, np.inf, iterations
        if not size < 1e6:
            return -1, first, np.inf, iterations
        largest = max(1.0, largest_ratio(q, scale))
        axpy(1.0, dq, q)
        if size <= 4e-16 * largest or (iterations > 1 and size <= 1e-9 and size > 0.25 * previous):
            break
        if iterations == _ITERATIONS:
            return -1, first, np.inf, iterations
        previous = size
    first_v = 0.0
    for turn in range(2):
        weak = correction(t, q, v, p, w, dq, dv)
        if weak != 0:
            return int(weak), first, np.inf, iterations
        if turn == 0:
            first_v = largest_ratio(dv, scale)
        axpy(1.0, dv, v)
    return 0, first, first_v, iterations


@inner
def try_step(kernels: Any, new: Any, s: Any, r: Any) -> float:
    """Predict q and v at the instant `new` in two rows of `trial`, and correct them there.

    Returns the scaled error of the predicted q, and the accelerations become those at `new`; where
    the prediction is too poor to tell the branch, it is infinite, and they stay.
    """
    h = new - r.t
    q, v = s.trial[0], s.trial[1]
    for i in range(q.size):
        q[i] = s.q[i] + h * (s.v[i] + 0.5 * h * s.a[i])
        v[i] = s.v[i] + h * s.a[i]
    code, off, veered, iterations = return_to_motion(
        correction_of(kernels), new, q, v, s.p, s.weights, s.scale, s.trial[2], s.trial[3]
    )
    r.newton += iterations
    if code != 0 or off > _PREDICTED or abs(h) * veered > 4.0 * _PREDICTED:
        return np.inf
    accelerations = accelerations_of(kernels)
    if accelerations(new, q, v, s.p, s.modes, s.a, s.lam) == 0:
        return off
    accelerations(r.t, s.q, s.v, s.p, s.modes, s.a, s.lam)
    return np.inf


@inner
def eliminate_at(
    kernels: Any, s: Any, t: Any, q: Any, order: Any, pivots: Any, search: int
) -> float:
    """Fill the pivots of Phi_q at (t, q); the smallest of them."""
    jacobian_of(kernels)(t, q, s.p, s.values)
    slopes = Sparse(s.rows, s.columns, s.values)
    fill_unit_rows(slopes, s.scale, s.shortest, s.dense, pivots)
    for i in range(pivots.size):  # the inverse lengths of the rows
        s.shortest[i] = max(s.shortest[i], SHORTEST / pivots[i])
    eliminate_rows(s.dense, order, pivots, search)
    return float(smallest_pivot(pivots))


@inner
def record_pivots(kernels: Any, s: Any, r: Any) -> None:
    """Keep this state and its pivots for the next comparison."""
    r.least = eliminate_at(kernels, s, r.t, s.q, s.orders[0], s.pivots[0], 1)
    r.travel = 0.0
    r.compared_t, r.compared_mark = r.t, r.mark
    copy_vector(s.q, s.compared[0])
    copy_vector(s.v, s.compared[1])
    r.best = max(r.best, r.least)
    if r.least >= min(_GOOD, 0.5 * r.best):
        r.good_t, r.good_mark = r.t, r.mark
        copy_vector(s.q, s.good[0])
        copy_vector(s.v, s.good[1])


@inner
def is_suspicious(kernels: Any, s: Any, r: Any) -> bool:
    """Whether the constraints were, or may have been, dependent since the last comparison.

    A pivot that vanishes only in this order of pivots takes another through infinity: signs change
    in pairs, and the position in between is a good one with an order of its own. An odd number of
    changes is a change of the determinant's sign. A pivot lost where a step ends counts as one.
    """
    before, now, between, middle = s.pivots[0], s.pivots[1], s.pivots[2], s.trial[2]
    eliminate_at(kernels, s, r.t, s.q, s.orders[0], now, 0)
    changes, poorest = 0, np.inf
    for i in range(before.size):
        kept = before[i] * now[i] > 0.0 and abs(now[i]) > r.lost
        if kept or abs(before[i]) <= r.lost:
            continue
        changes += 1
        part = before[i] / (before[i] - now[i])
        for j in range(s.q.size):
            middle[j] = s.compared[0, j] + part * (s.q[j] - s.compared[0, j])
        t = r.compared_t + part * (r.t - r.compared_t)
        least = eliminate_at(kernels, s, t, middle, s.orders[1], between, 1)
        if least < poorest:
            poorest = least
            r.zero = part
    if changes == 0:
        return False
    if changes % 2 == 0:
        least = eliminate_at(kernels, s, r.t, s.q, s.orders[1], between, 1)
        if poorest >= _POOR * min(r.least, least):
            return False
    r.end = r.t
    return True


@compiled(i8(ADDRESSES, vector, WORKSPACE, from_dtype(RECORD)))
def advance(kernels: Any, times: Any, s: Any, r: Any) -> int:
    """Advance the state (q, v, a, at `r.t`) through `times` and store it at each.

    `r.mark` counts the instants done.

    Returns DONE, where it may go on if instants are left; STUCK with the state at the last position
    reached; SUSPECT, where the pivots at `r.end` are suspicious, with the state of the last good
    ones; ARRIVED at the barrier.
    """
    q, v, tries = s.trial[0], s.trial[1], 0
    if r.least < 0.0:
        record_pivots(kernels, s, r)
    while r.mark < len(times) and tries < _TRIES:
        tries += 1
        target, t = times[r.mark], r.t
        if t == target:
            copy_vector(s.q, s.q_out[r.mark])
            copy_vector(s.v, s.v_out[r.mark])
            r.mark += 1
            continue
        if t == r.barrier:
            return ARRIVED
        sign = 1.0 if target > t else -1.0
        barred = (target - r.barrier) * sign > 0.0 and (r.barrier - t) * sign > 0.0
        if barred:
            target = r.barrier
        step = min(r.step, _TRAVEL / max(largest_ratio(s.v, s.scale), 1e-300))
        last = step >= abs(target - t)
        new = target if last else t + sign * step
        h = abs(new - t)
        if h <= 8e-16 * max(abs(t), 1e-3 * abs(target)) and not last:
            return STUCK
        off = try_step(kernels, new, s, r)
        if off > _PREDICTED:
            r.rejected += 1
            r.step = 0.5 * h
            if h <= 1e-15 * max(abs(t), abs(target)):
                return STUCK
            continue
        travel = 0.0
        for i in range(q.size):
            travel = max(travel, abs(q[i] - s.q[i]) / s.scale[i])
            s.q[i], s.v[i] = q[i], v[i]
        r.t = new
        r.steps += 1
        r.travel += travel
        if off < 0.2 * _PREDICTED:
            r.step = max(r.step, 2.0 * h)
        ends = last and (barred or r.mark + 1 == len(times))
        if r.travel < r.margin * r.least and not ends:
            continue
        if is_suspicious(kernels, s, r):
            # Back to the last comparison; the next one is to come at once.
            copy_vector(s.compared[0], s.q)
            copy_vector(s.compared[1], s.v)
            r.t, r.mark, r.travel = r.compared_t, r.compared_mark, np.inf
            accelerations_of(kernels)(r.t, s.q, s.v, s.p, s.modes, s.a, s.lam)
            return SUSPECT
        record_pivots(kernels, s, r)
    return DONE


_CHUNK = 4096  # measured: instants between two returns to Python, for progress and interrupts
_KNOWN = 1e-9  # accuracy: uncertainty of a singular instant, in parts of its zone's reach
_SAME = 1e-8  # accuracy: scaled distance of positions that differ by rounding, near a singular one


class ContinuationState:
    """State, record and samples of one continuation through `times` from an assembled start."""

    def __init__(self, equations: Equations, times: FloatArray, start: Assembly) -> None:
        description, n, m = equations.description, equations.n, equations.m
        rows, columns = description.jacobian_rows, description.jacobian_columns
        self.equations, self.times = equations, times
        self.scale = equations.scale(equations.size(start.t, start.q))  # of changes, (n,)
        self.q, self.v = start.q.copy(), start.v.copy()
        lengths = np.linalg.norm(equations.jacobian(start.t, self.q) * self.scale, axis=1)
        self.constraints = equations.scaled(self.scale, equations.independent)
        drivers = description.driver_rows
        least = self.constraints.least_lengths(start.t, self.q, self.scale, drivers)
        self.constraints.shortest = self.shortest = np.maximum(SHORTEST * lengths, least)
        self.has_vanishing_row = bool((lengths < _VANISHED * least).any())
        self.modes = np.zeros(len(description.switches), dtype=np.int64)
        # weak: 1 + the constraint with a weak pivot at the start, or 0
        self.a, lam, self.weak = equations.motion(start.t, self.q, self.v, self.modes)
        self.q_out, self.v_out = np.zeros((2, len(times), n))
        self.began, self.span = start.t, max(abs(float(times[-1]) - start.t), 1e-300)
        self.record = np.rec.array(np.zeros(1, RECORD))[0]
        self.record.t, self.record.step = start.t, max(self.span, 1.0)
        self.record.least, self.record.barrier = -1.0, np.nan
        varies = drivers & ~np.isclose(least, SHORTEST * lengths)
        wary = _WARY, _LOST
        self.record.margin, self.record.lost = wary if varies.any() else (_MARGIN, REDUNDANT)
        self._workspace = Workspace(
            p=equations.p, scale=self.scale, weights=self.scale**2, shortest=self.shortest,
            q=self.q, v=self.v, a=self.a, lam=lam, modes=self.modes, q_out=self.q_out,
            v_out=self.v_out, rows=rows.astype(np.int64), columns=columns.astype(np.int64),
            values=np.zeros(len(rows)), dense=np.zeros((m, n)), pivots=np.zeros((3, m)),
            orders=np.zeros((2, m), np.int64), compared=np.zeros((2, n)), good=np.zeros((2, n)),
            trial=np.zeros((4, n)),
        )  # fmt: skip

    @property
    def t(self) -> float:
        """Present instant, s."""
        return float(self.record.t)

    @property
    def mark(self) -> int:
        """Number of instants done."""
        return int(self.record.mark)

    @property
    def ahead(self) -> float:
        """1 where the next instant lies ahead, -1 where it lies behind; see `sample`."""
        return 1.0 if self.times[self.mark] > self.t else -1.0

    @property
    def finished(self) -> bool:
        """Whether all instants are done."""
        return self.mark == len(self.times)

    @property
    def speed(self) -> float:
        """Largest scaled velocity, 1/s, at least 1e-3."""
        return max(float(np.abs(self.v / self.scale).max()), 1e-3)

    def advance(self) -> int:
        """Continue through some of the instants; the code of `predictor_corrector.advance`."""
        times = self.times[: self.mark + _CHUNK]
        return int(advance(self.equations.table, times, self._workspace, self.record))

    def cross(self, zone: "Zone", coming: float) -> bool:
        """Sample within the zone and leave it towards the next instant; whether it was crossed.

        Instants within it that were sampled before it was known are sampled again: the
        predictor-corrector's velocities are less accurate there.
        """
        done, times, reached = self.mark, self.times, self.t
        earlier = done - 1
        while earlier >= 0 and zone.holds(float(times[earlier])):
            q, v = zone.at(float(times[earlier]))
            if np.abs((q - self.q_out[earlier]) / self.scale).max() > _SAME:
                break
            self.q_out[earlier], self.v_out[earlier] = q, v
            earlier -= 1
        while done < len(times) and zone.holds(float(times[done])):
            reached = float(times[done])
            self.q_out[done], self.v_out[done] = zone.at(reached)
            done += 1
        self.record.mark = done
        if done < len(times):
            side = 1.0 if times[done] > zone.t else -1.0
            reached = zone.t + side * zone.reach
        self.q[:], self.v[:] = zone.at(reached)
        self.resume(reached, 0.5 * zone.reach)
        return bool((reached - zone.t) * coming > _KNOWN * zone.reach)

    def resume(self, t: float, step: float) -> None:
        """Restart the predictor-corrector at the present state."""
        r, new = self.record, (t, step, -1.0, np.nan, 0.0, 0.0)
        r.t, r.step, r.least, r.barrier, r.travel, r.best = new
        self.a[:] = self.equations.motion(t, self.q, self.v, self.modes)[0]

    def sample(self) -> None:
        """Store the state if the next instant is the present one, so that `ahead` has a sign."""
        if not self.finished and self.times[done := self.mark] == self.t:
            self.q_out[done], self.v_out[done] = self.q, self.v
            self.record.mark = done + 1

    def return_to_good(self) -> None:
        """Return to the state at which the pivots were last good."""
        r = self.record
        if r.good_t != self.t:
            self.q[:], self.v[:] = self._workspace.good
            r.mark = r.good_mark
            self.resume(float(r.good_t), float(r.step))
            self.sample()

    def sample_piece(self, curve: Curve, piece: Piece, ahead: float) -> None:
        """Store the instants that lie on a piece of the curve."""
        start, end = (curve.position(point.z)[0] for point in (piece.start, piece.end))
        done, times = self.mark, self.times
        while done < len(times) and 0.0 < (times[done] - start) * ahead <= (end - start) * ahead:
            there = curve.at_time(piece, float(times[done]))
            self.q_out[done], self.v_out[done] = curve.position(there.z)[1], curve.velocity(there)
            done += 1
            if ahead < 0.0 and done < len(times) and times[done] > times[done - 1]:
                break
        self.record.mark = done
