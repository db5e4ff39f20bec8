"""Follow a driven machine through its instants: the compiled walk, and what stands in its way.

Where the walk gets stuck, or lands where another assembly of the machine is, the singular position
that is the cause is looked for. Where motions cross (`runtime.constraints.singular` finds where),
the branch on which the velocity is continuous is taken (`passing`). Where they only come close, or
where time turns back, the curve of positions is followed by its length (`tracing`).
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from runtime.analyses import meeting
from runtime.analyses.assemble import Assembly
from runtime.analyses.branches import Branch, ambiguous, branches
from runtime.analyses.equations import Equations, FloatArray
from runtime.analyses.passing import Zone, zone
from runtime.analyses.tracing import Curve, Piece, Point
from runtime.analyses.walking import (
    ARRIVED,
    BARRIER,
    DONE,
    END,
    LEAST,
    MARK,
    NEWTON,
    RECORD,
    REJECTED,
    ROWS,
    STEP,
    STEPS,
    SUSPECT,
    TRAVEL,
    ZERO,
    T,
    walk,
)
from runtime.constraints.singular import Positions, Singularity, taylor
from runtime.outcomes import Outcome
from runtime.progress import Progress
from runtime.results.singular import SingularPosition

if TYPE_CHECKING:
    from runtime.machine import Machine

_CHUNK = 4096
_ROUNDING = 64.0 * 2.2e-16  # of the largest coordinate: a gap that closes but for rounding
_CLOSE = 1e-3  # scaled: a stretch that is followed by its length where nothing was found on it
_ABOUT = 1e-2  # scaled: how far from where a walk is stuck the cause may lie
_REGAINED = 0.3  # of the smallest singular value where a trace began: it has left the narrows
_WIDE = 1e-2  # or this singular value
_FARTHEST = 1.0  # scaled length of a trace


class Walk(NamedTuple):
    """A driven motion: states at the instants reached, how it ended, what it met."""

    t: FloatArray
    q: FloatArray
    v: FloatArray
    outcome: Outcome
    message: str
    stats: dict[str, float]
    singular: tuple[SingularPosition, ...]


class Follower:
    """One walk through `times` from an assembled start; call `run` once."""

    def __init__(self, equations: Equations, times: FloatArray, start: Assembly) -> None:
        told, n, m = equations.description, equations.n, equations.m
        self.equations, self.times = equations, times
        self.scale = equations.scale(equations.size(start.t, start.q))
        self.q, self.v = start.q.copy(), start.v.copy()
        self.modes = np.zeros(len(told.switches), dtype=np.int64)
        self.a, self.lam, self.weak = equations.motion(start.t, self.q, self.v, self.modes)
        self.q_out, self.v_out = np.zeros((len(times), n)), np.zeros((len(times), n))
        self.span = max(abs(float(times[-1]) - start.t), 1e-300)
        self.record = np.zeros(RECORD)
        self.record[T], self.record[STEP] = start.t, max(self.span, 1.0)
        self.record[LEAST], self.record[BARRIER] = -1.0, np.nan
        self.positions = Positions(
            equations.kernels.constraints,
            equations.kernels.jacobian,
            equations.kernels.velocity_rhs,
            np.asarray(told.jacobian_rows),
            np.asarray(told.jacobian_columns),
            equations.p,
            self.scale,
            np.arange(m),
            m,
        )
        nonzeros = len(told.jacobian_rows)
        self.work = (
            np.zeros((ROWS, n)),
            np.ascontiguousarray([told.jacobian_rows, told.jacobian_columns], dtype=np.int64),
            np.zeros(nonzeros),
            np.zeros((m, n)),
            np.zeros((3, m)),
            np.zeros((2, m), dtype=np.int64),
        )
        self.awaited: Singularity | None = None
        self.singular: list[SingularPosition] = []
        self.notes = ""

    @property
    def t(self) -> float:
        """The instant reached."""
        return float(self.record[T])

    @property
    def mark(self) -> int:
        """Instants done."""
        return int(self.record[MARK])

    @property
    def ahead(self) -> float:
        """1 where the next instant lies ahead, -1 where it lies behind."""
        return 1.0 if self.times[self.mark] > self.t else -1.0

    # -- the walk -----------------------------------------------------------------------------

    def run(self, progress: Progress) -> tuple[Outcome, str]:
        """Walk to the last instant, or to where the motion ends."""
        began, count = self.t, len(self.times)
        while self.mark < count:
            chunk = min(self.mark + _CHUNK, count)
            status = walk(
                self.equations.table, self.times[:chunk], self.equations.p, self.scale**2,
                self.scale, self.q, self.v, self.a, self.modes, self.lam, self.q_out, self.v_out,
                self.record, *self.work,
            )  # fmt: skip
            progress(abs(self.t - began) / self.span)
            if status == DONE:
                continue
            if status == ARRIVED:
                assert self.awaited is not None
                going = self._cross(self.awaited)
                ended = None if going else self._nowhere()
            else:
                ended = self._judge(suspect=status == SUSPECT)
            if ended is not None:
                return ended
        return Outcome.OK, ""

    def _judge(self, suspect: bool) -> tuple[Outcome, str] | None:
        """Find out why the walk did not go on, and go on; or how it ends."""
        r, ahead, speed = self.record, self.ahead, self._speed()
        stretch = abs(float(r[END]) - self.t) if suspect else _ABOUT / speed
        guess = ahead * stretch * float(r[ZERO]) if suspect else 0.0
        found = self.positions.near(taylor(self.t, self.q, self.v, self.a), guess)
        if found is not None and not self._on_the_way(found, ahead, stretch):
            found = None
        if found is not None and found.gap <= self._rounding():
            known = self.awaited is not None and abs(self.awaited.t - found.t) * speed < 1e-6
            if suspect and known and (r[BARRIER] - self.t) * ahead > 0.0:
                r[STEP] = 0.25 * stretch  # it strayed on the way there
                return None
            self.awaited = found
            barrier = found.t - ahead * self._reach(found)
            if (barrier - self.t) * ahead > 0.0:
                r[BARRIER] = barrier
                return None
            return None if self._cross(found) else self._nowhere()
        if found is None and suspect and stretch * speed > _CLOSE:
            r[STEP] = 0.25 * stretch
            return None
        return self._trace(found, self.t + ahead * stretch if suspect else self.t)

    def _on_the_way(self, found: Singularity, ahead: float, stretch: float) -> bool:
        way = ahead * (found.t - self.t)
        room = 1e-3 / found.speed
        return found.rate > 0.0 and -room < way < 1.5 * stretch + room

    def _nowhere(self) -> tuple[Outcome, str]:
        return Outcome.SINGULAR, meeting.stuck(self.equations, self.t, self.q, self.scale)

    # -- where motions cross ------------------------------------------------------------------

    def _cross(self, found: Singularity) -> bool:
        """Go across on the branch of continuous velocity; false where there is none."""
        before = self.t
        coming = self.v + (found.t - before) * self.a
        choices = branches(self.equations, found.t, found.q, coming, self.scale)
        if not choices or (len(choices) > 1 and choices[0].far > 0.3 * choices[1].far):
            return False
        made = self._zone(found.t, found.q, choices, found.rate)
        if made is None:
            return False
        if made.holds(before):
            off = np.linalg.norm((made.at(before)[0] - self.q) / self.scale)
            if off > 0.3 * self._apart(choices) * abs(found.t - before) + 1e-9:
                return False
        if self._passed(made, np.sign(found.t - before) or self.ahead):
            self.singular.append(
                meeting.met(self.equations, "crossing", found.t, found.q, choices[0].v, self.scale)
            )
        return True

    def begin(self, wished: FloatArray) -> None:
        """Start in a singular position, on the branch nearest to the velocities wished for."""
        equations, t, scale = self.equations, self.t, self.scale
        choices = branches(equations, t, self.q, wished, scale)
        told = meeting.met(equations, "start", t, self.q, self.v, scale)
        if not choices or ambiguous(choices, scale):
            raise meeting.no_start(equations, told, choices)
        self.v[:], self.a[:] = choices[0].v, choices[0].a
        speed = self._speed()
        if not (self.times == t).all():
            found = self.positions.near(taylor(t, self.q, self.v, self.a), 0.0)
            rate = found.rate if found is not None else speed
            made = self._zone(t, self.q, choices, rate)
            if made is None:
                raise meeting.no_start(equations, told, [])
            self._passed(made, self.ahead)
        else:
            self.q_out[:], self.v_out[:] = self.q, self.v
            self.record[MARK] = len(self.times)
        self.singular.append(told._replace(v=choices[0].v))
        self.notes += (
            f" Started in a singular position at t = {t:.6g} s, on the branch nearest to "
            f"the start velocities; without them the machine is free to move by {told.free}."
        )

    def _zone(self, t: float, q: FloatArray, choices: list[Branch], rate: float) -> Zone | None:
        speed = float(np.linalg.norm(choices[0].v / self.scale))
        return zone(
            self.equations, t, q, choices[0], self._apart(choices), self.scale,
            max(rate, speed, 1e-3),
        )  # fmt: skip

    def _apart(self, choices: list[Branch]) -> float:
        first = choices[0].v
        return min(
            (float(np.linalg.norm((other.v - first) / self.scale)) for other in choices[1:]),
            default=np.inf,
        )

    def _passed(self, made: Zone, coming: float) -> bool:
        """Sample within the zone and leave it towards the next instant; whether it was crossed."""
        done, times = self.mark, self.times
        reached = self.t
        while done < len(times) and made.holds(float(times[done])):
            reached = float(times[done])
            self.q_out[done], self.v_out[done] = made.at(reached)
            done += 1
        self.record[MARK] = done
        if done < len(times):
            side = 1.0 if times[done] > made.t else -1.0
            reached = made.t + side * made.reach
        self.q[:], self.v[:] = made.at(reached)
        self._resume(reached, 0.5 * made.reach)
        return bool((reached - made.t) * coming >= 0.0)

    def _resume(self, t: float, step: float) -> None:
        """Let the walk go on from the state as it is now."""
        r = self.record
        r[T], r[STEP], r[LEAST], r[BARRIER], r[TRAVEL] = t, step, -1.0, np.nan, 0.0
        self.awaited = None
        motion = self.equations.motion(t, self.q, self.v, self.modes)
        self.a[:], self.lam[:] = motion.a, motion.lam

    # -- where they do not --------------------------------------------------------------------

    def _trace(self, missed: Singularity | None, end: float) -> tuple[Outcome, str] | None:
        """Follow the curve of positions by its length, until beyond `end` all is well again."""
        ahead, speed = self.ahead, self._speed()
        curve = Curve(self.positions, self.t, self.q, speed)
        along = ahead * np.append(self.v / self.scale, speed)
        begin = curve.point(curve.z(self.t, self.q), along)
        if begin is None:
            return self._stopped(self.t, self.q)
        wide = min(max(_REGAINED * self._least(curve, begin), 1e-3), _WIDE)

        def free(point: Point) -> bool:
            there = float(point.z[-1]) / speed
            far = float(np.linalg.norm(point.z - begin.z))
            well = self._least(curve, point) > wide and (there - end) * ahead > 0.0
            return well or far > _FARTHEST

        avoid = None if missed is None else curve.z(missed.t, missed.q)
        trace = curve.trace(begin, ahead, free, avoid)
        for piece in trace.pieces:
            self._sample(curve, piece, ahead)
        point = trace.pieces[-1].end if trace.pieces else begin
        t, q = curve.position(point.z)
        self.record[STEPS] += len(trace.pieces)
        if self.mark == len(self.times):
            return None
        if trace.lost:
            self.q[:], self.record[T] = q, t
            return self._stopped(t, q)
        if trace.folded:
            nowhere = np.full_like(q, np.nan)
            found = meeting.met(self.equations, "lock-up", t, q, nowhere, self.scale)
            self.singular.append(found)
            self.q[:], self.v[:], self.record[T] = q, nowhere, t
            return Outcome.LOCKED, meeting.lock_up(self.equations, found)
        self.q[:], self.v[:] = q, curve.velocity(point)
        self._resume(t, trace.pieces[-1].h / speed)
        return None

    def _sample(self, curve: Curve, piece: Piece, ahead: float) -> None:
        """Store the instants that lie on a piece of the curve."""
        start, end = (curve.position(point.z)[0] for point in (piece.start, piece.end))
        done, times = self.mark, self.times
        while done < len(times) and 0.0 < (times[done] - start) * ahead <= (end - start) * ahead:
            there = curve.at_time(piece, float(times[done]))
            self.q_out[done], self.v_out[done] = curve.position(there.z)[1], curve.velocity(there)
            done += 1
            if ahead < 0.0 and done < len(times) and times[done] > times[done - 1]:
                break
        self.record[MARK] = done

    def _stopped(self, t: float, q: FloatArray) -> tuple[Outcome, str]:
        """The end where no fold was found: an element without a value, or no smooth motion."""
        told = meeting.undefined(self.equations, t, self.ahead, q)
        if told:
            return Outcome.LOCKED, told
        return Outcome.SINGULAR, meeting.stuck(self.equations, t, q, self.scale)

    # -- sizes --------------------------------------------------------------------------------

    def _least(self, curve: Curve, point: Point) -> float:
        values = np.linalg.svd(curve.matrix(point.z)[:, :-1], compute_uv=False)
        return float(values[-1])

    def _reach(self, found: Singularity) -> float:
        """How far from a crossing the walk stops."""
        return 2e-2 / max(found.rate, found.speed)

    def _speed(self) -> float:
        return max(float(np.abs(self.v / self.scale).max()), 1e-3)

    def _rounding(self) -> float:
        return _ROUNDING * float(np.abs(self.q / self.scale).max(initial=1.0))


def follow(
    machine: "Machine",
    times: FloatArray,
    start: Assembly,
    wished: FloatArray,
    p: FloatArray,
    progress: Progress,
) -> Walk:
    """Walk from the assembled start through `times`; `wished`: the start velocities asked for."""
    follower = Follower(Equations(machine, p), times, start)
    if follower.weak or start.singular:
        # Here Phi_q says neither which branch it is nor how it curves.
        follower.begin(wished)
    outcome, message = follower.run(progress)
    done, r = follower.mark, follower.record
    crossed = [row for row in follower.singular if row.kind == "crossing"]
    stats: dict[str, float] = {
        "steps": int(r[STEPS]),
        "rejected": int(r[REJECTED]),
        "newton_iterations": int(r[NEWTON]),
        "singular_crossings": len(crossed),
    }
    t, q, v = times[:done], follower.q_out[:done], follower.v_out[:done]
    if outcome is Outcome.OK:
        message = f"{len(times)} instants from t = {times[0]:g} to {times[-1]:g} s."
    elif done == 0 or follower.t > times[done - 1]:
        t, q, v = np.append(t, follower.t), np.vstack([q, follower.q]), np.vstack([v, follower.v])
    message += follower.notes + meeting.crossings(crossed)
    return Walk(t, q, v, outcome, message, stats, tuple(follower.singular))
