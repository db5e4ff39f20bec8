"""State of the continuation of a driven motion: position, record and samples so far."""

from typing import NamedTuple

import numpy as np

from runtime.continuation.arclength import Curve, Piece
from runtime.continuation.motion_across_branch_point import Zone
from runtime.continuation.predictor_corrector import RECORD, Workspace, advance
from runtime.core.outcomes import Outcome
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.assembled_state import Assembly
from runtime.results.event_records import SingularPosition

_CHUNK = 4096  # measured: instants between two returns to Python, for progress and interrupts
# accuracy: uncertainty of the instant of a singular position, in parts of its zone's reach
_KNOWN = 1e-9
# accuracy: scaled distance of positions that differ by rounding, near a singular position
_SAME = 1e-8


class DrivenMotion(NamedTuple):
    """A driven motion: states at the instants reached, outcome, and singular configurations."""

    t: FloatArray
    q: FloatArray
    v: FloatArray
    outcome: Outcome
    message: str
    stats: dict[str, float]
    singular: tuple[SingularPosition, ...]


class ContinuationState:
    """State, record and samples of one continuation through `times` from an assembled start."""

    def __init__(self, equations: Equations, times: FloatArray, start: Assembly) -> None:
        description, n, m = equations.description, equations.n, equations.m
        rows, columns = description.jacobian_rows, description.jacobian_columns
        self.equations, self.times = equations, times
        self.scale = equations.scale(equations.size(start.t, start.q))  # of changes, (n,)
        self.q, self.v = start.q.copy(), start.v.copy()
        self.modes = np.zeros(len(description.switches), dtype=np.int64)
        # weak: 1 + the constraint with a weak pivot at the start, or 0
        self.a, lam, self.weak = equations.motion(start.t, self.q, self.v, self.modes)
        self.q_out, self.v_out = np.zeros((2, len(times), n))
        self.began, self.span = start.t, max(abs(float(times[-1]) - start.t), 1e-300)
        self.record = np.rec.array(np.zeros(1, RECORD))[0]
        self.record.t, self.record.step = start.t, max(self.span, 1.0)
        self.record.least, self.record.barrier = -1.0, np.nan
        self._workspace = Workspace(
            p=equations.p, scale=self.scale, weights=self.scale**2, q=self.q, v=self.v, a=self.a,
            lam=lam, modes=self.modes, q_out=self.q_out, v_out=self.v_out,
            rows=rows.astype(np.int64), columns=columns.astype(np.int64),
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

    def cross(self, zone: Zone, coming: float) -> bool:
        """Sample within the zone and leave it towards the next instant; whether it was crossed.

        Instants within it that were sampled before it was known are sampled again: the
        predictor-corrector's velocities are less accurate there.
        """
        done, times = self.mark, self.times
        reached = self.t
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
        r = self.record
        r.t, r.step, r.least, r.barrier, r.travel, r.best = t, step, -1.0, np.nan, 0.0, 0.0
        self.a[:] = self.equations.motion(t, self.q, self.v, self.modes)[0]

    def sample(self) -> None:
        """Store the state if the next instant is the present one, so that `ahead` has a sign."""
        done = self.mark
        if not self.finished and self.times[done] == self.t:
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
