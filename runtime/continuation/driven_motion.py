"""Follow a driven machine through its instants: the compiled walk, and what stands in its way.

Where the walk gets stuck, or lands where another assembly of the machine is, the singular position
that is the cause is looked for. Where motions cross (`runtime.singularity.singular_position` finds
where), the branch on which the velocity is continuous is taken (`passing`). Where they only
come close, or where time turns back, the curve of positions is followed by its length (`tracing`).
"""

from functools import cached_property
from itertools import pairwise

import numpy as np

from runtime.continuation import singularity_classification as meeting
from runtime.continuation.arclength import Curve, Point
from runtime.continuation.bifurcation_branches import Branch, ambiguous, branches
from runtime.continuation.branch_interpolation import DISTANCE, Zone, zone
from runtime.continuation.continuation_state import Course, Walk
from runtime.continuation.pivot_monitor import (
    BARRIER,
    END,
    MARK,
    NEWTON,
    REJECTED,
    STEP,
    STEPS,
    ZERO,
    T,
)
from runtime.continuation.predictor_corrector import ARRIVED, DONE, SUSPECT
from runtime.core.outcomes import Outcome
from runtime.core.rounding import EPS
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.progress_bar import Progress
from runtime.results.assembled_state import Assembly
from runtime.results.singular_positions import Kind, SingularPosition
from runtime.singularity.local_motion import taylor
from runtime.singularity.singular_position import Singularity, SingularPositions

_ROUNDING = 64.0 * EPS  # accuracy: gap, in parts of the largest coordinate, that is rounding
_DRIFT = 1e-4  # accuracy: |uᵀ ν|, the drivers' pace 1, at a branch point or a near miss of one
_SEEN = 17  # safety: instants at which the drivers' pace is sampled
# measured: scaled length of a stretch that is traced where no singular position was found
_CLOSE = 1e-3
_ABOUT = 1e-2  # measured: scaled distance of a cause from the position at which the walk is stuck
# accuracy: distance from its branch, over that of the next branch, at which a state is on it
_NEARER = 0.3
_PATIENCE = 100  # safety: searches for a cause in a row without progress
_WITHIN = 0.99  # measured: part of a zone's reach that is well inside
# measured: part of the smallest singular value at its start with which a trace has left
_REGAINED = 0.3
_WIDE = 1e-2  # measured: or this singular value, with which it has
_FARTHEST = 1.0  # safety: scaled length of a trace


class Follower:
    """One walk through `times` from an assembled start; call `run` once."""

    def __init__(self, equations: Equations, times: FloatArray, start: Assembly) -> None:
        self.equations, self.course = equations, Course(equations, times, start)
        self.scale = self.course.scale
        independent = np.asarray(start.independent, dtype=np.int64)
        self.constraints = equations.scaled(self.scale, independent)
        self.positions = SingularPositions(self.constraints)
        self.awaited: Singularity | None = None
        self.singular: list[SingularPosition] = []
        self.notes = ""

    @cached_property
    def pace(self) -> float:
        """How fast the drivers go at their fastest, 1/s, and not nothing."""
        course = self.course
        ends = course.began, float(course.times[0]), float(course.times[-1])
        seen = np.concatenate([np.linspace(*pair, _SEEN) for pair in pairwise(ends)])
        return max(meeting.pace(self.equations, seen, course.q, self.scale), 1e-3)

    def run(self, progress: Progress) -> tuple[Outcome, str]:
        """Walk to the last instant, or to where the motion ends."""
        course, furthest, idle = self.course, (-1, 0.0), 0
        while not course.finished:
            status = course.walk()
            progress(abs(course.t - course.began) / course.span)
            if status == DONE:
                continue
            course.sample()
            place = course.mark, course.ahead * course.t
            furthest, idle = (place, 0) if place > furthest else (furthest, idle + 1)
            if idle > _PATIENCE:
                return Outcome.SINGULAR, self._unclear()
            if status == ARRIVED:
                assert self.awaited is not None
                ended = self._cross(self.awaited)
            else:
                ended = self._judge(suspect=status == SUSPECT)
            if ended is not None:
                return ended
        return Outcome.OK, ""

    def _judge(self, suspect: bool) -> tuple[Outcome, str] | None:
        """Find out why the walk did not go on, and go on; or how it ends."""
        course, r = self.course, self.course.record
        t, ahead, speed = course.t, course.ahead, course.speed
        stretch = abs(float(r[END]) - t) if suspect else _ABOUT / speed
        guess = ahead * stretch * float(r[ZERO]) if suspect else 0.0
        found = self.positions.find(taylor(t, course.q, course.v, course.a), guess)
        if found is not None and not self._on_the_way(found, ahead, stretch):
            found = None
        if found is not None and found.gap <= self._rounding():
            known = self.awaited is not None and abs(self.awaited.t - found.t) * speed < 1e-6
            if suspect and known and (r[BARRIER] - t) * ahead > 0.0:
                r[STEP] = 0.25 * stretch  # it strayed on the way there
                return None
            self.awaited = found
            course.return_to_good()
            r[STEP] = max(r[STEP], _ABOUT / speed)
            t, ahead = course.t, course.ahead
            barrier = found.t - ahead * 2.0 * DISTANCE / max(found.rate, found.speed)
            if (barrier - t) * ahead > 0.0:
                r[BARRIER] = barrier
                return None
            return self._cross(found)
        if found is None and suspect and stretch * speed > _CLOSE:
            r[STEP] = 0.25 * stretch
            return None
        return self._trace(found, t + ahead * stretch if suspect else t)

    def _on_the_way(self, found: Singularity, ahead: float, stretch: float) -> bool:
        """Whether motions, or their continuations, cross within the stretch.

        Near a fold the motion is so fast that time hardly tells: it must not take part in what is
        lost.
        """
        way = ahead * (found.t - self.course.t)
        room = 1e-3 / found.speed
        if not (found.rate > 0.0 and -room < way < 1.5 * stretch + room):
            return False
        drift = meeting.drift(self.equations, found.t, found.q, self.scale, self.pace)
        return drift < _DRIFT

    # -- where motions cross ------------------------------------------------------------------

    def _cross(self, found: Singularity) -> tuple[Outcome, str] | None:
        """Go across on the branch of continuous velocity; an end where nothing says which it is."""
        course, equations = self.course, self.equations
        coming = course.v + (found.t - course.t) * course.a
        t, q, choices = found.t, found.q, branches(equations, found.t, found.q, coming, self.scale)
        if choices:
            # Once more from there: what was found by one look from afar is as good as its step.
            motion = taylor(t, q, choices[0].v, choices[0].a)
            q = (self.positions.find(motion, 0.0) or found).q
            t = meeting.instant(equations, t, q)
            choices = branches(equations, t, q, coming, self.scale)
        made = None
        if choices and (len(choices) == 1 or choices[0].far < _NEARER * choices[1].far):
            made = self._zone(t, q, choices, found.rate)
        if made is not None and made.holds(course.t):
            off = np.linalg.norm((made.at(course.t)[0] - course.q) / self.scale)
            if off > _NEARER * self._apart(choices) * abs(t - course.t) + 1e-9:
                made = None
        if made is None:
            return Outcome.SINGULAR, self._unclear()
        entry = made.t - course.ahead * _WITHIN * made.reach
        if not made.holds(course.t) and (entry - course.t) * course.ahead > 0.0:
            course.record[BARRIER] = entry  # nearer than most: first walk there
            return None
        self.awaited = None
        if course.through(made, np.sign(t - course.t) or course.ahead):
            row = self._met("crossing", t, q, choices[0].v)
            self.singular.append(row)
        return None

    def begin(self, wished: FloatArray) -> None:
        """Start in a singular position, on the branch nearest to the velocities wished for."""
        course, equations, scale = self.course, self.equations, self.scale
        t, q = course.t, course.q.copy()
        choices = branches(equations, t, q, wished, scale)
        told = self._met("start", t, q, course.v)
        if not choices or ambiguous(choices, scale):
            raise meeting.no_start(equations, told, choices)
        course.v[:], course.a[:] = choices[0].v, choices[0].a
        if (course.times == t).all():
            course.q_out[:], course.v_out[:] = q, course.v
            course.record[MARK] = len(course.times)
        else:
            found = self.positions.find(taylor(t, q, course.v, course.a), 0.0)
            made = self._zone(t, q, choices, course.speed if found is None else found.rate)
            if made is None:
                raise meeting.no_start(equations, told, [])
            course.through(made, course.ahead)
        self.singular.append(told._replace(v=choices[0].v))
        self.notes += (
            f" Started in a singular position at t = {t:.6g} s, on the branch nearest to "
            f"the start velocities; without them the machine is free to move by {told.free}."
        )

    def _zone(self, t: float, q: FloatArray, choices: list[Branch], rate: float) -> Zone | None:
        speed = float(np.linalg.norm(choices[0].v / self.scale))
        rate = max(rate, speed, 1e-3)
        return zone(self.equations, t, q, choices[0], self._apart(choices), self.scale, rate)

    def _apart(self, choices: list[Branch]) -> float:
        """How far the next branch's velocity is from that of the first, scaled, 1/s."""
        first = choices[0].v
        return min(
            (float(np.linalg.norm((other.v - first) / self.scale)) for other in choices[1:]),
            default=np.inf,
        )

    # -- where they do not --------------------------------------------------------------------

    def _trace(self, missed: Singularity | None, end: float) -> tuple[Outcome, str] | None:
        """Follow the curve of positions by its length, until beyond `end` all is well again."""
        course, equations, ahead = self.course, self.equations, self.course.ahead
        rate = self.pace
        curve = Curve(self.constraints, course.t, course.q, rate)
        along = ahead * np.append(course.v / self.scale, rate)
        begin = curve.point(curve.z(course.t, course.q), along)
        if begin is None:
            return self._stopped(course.t, course.q)
        wide = min(max(_REGAINED * curve.narrowness(begin), 1e-3), _WIDE)

        def free(point: Point) -> bool:
            beyond = (curve.position(point.z)[0] - end) * ahead > 0.0
            far = float(np.linalg.norm(point.z - begin.z))
            return (beyond and curve.narrowness(point) > wide) or far > _FARTHEST

        avoid = None if missed is None else curve.z(missed.t, missed.q)
        trace = curve.trace(begin, ahead, free, avoid)
        for piece in trace.pieces:
            course.along(curve, piece, ahead)
        course.record[STEPS] += len(trace.pieces)
        if course.finished:
            return None
        point = trace.pieces[-1].end if trace.pieces else begin
        t, q = curve.position(point.z)
        course.q[:], course.record[T] = q, t
        if trace.lost:
            return self._stopped(t, q)
        if trace.folded:
            course.v[:] = np.nan
            found = self._met("lock-up", t, q, course.v)
            self.singular.append(found)
            return Outcome.LOCKED, meeting.lock_up(equations, found)
        course.v[:] = curve.velocity(point)
        course.resume(t, trace.pieces[-1].h / rate)
        self.awaited = None
        return None

    def _stopped(self, t: float, q: FloatArray) -> tuple[Outcome, str]:
        """The end where no fold was found: an element without a value, or no smooth motion."""
        told = meeting.undefined(self.equations, t, self.course.ahead, q)
        return Outcome.LOCKED, told or self._unclear()

    def _unclear(self) -> str:
        """Record where the course stands as singular, and why nothing leads on."""
        course = self.course
        row = self._met("unclear", course.t, course.q, course.v)
        self.singular.append(row)
        return meeting.unclear(row)

    def _met(self, kind: Kind, t: float, q: FloatArray, v: FloatArray) -> SingularPosition:
        return meeting.met(self.equations, kind, t, q, v, self.scale, self.pace)

    def _rounding(self) -> float:
        return _ROUNDING * float(np.abs(self.course.q / self.scale).max(initial=1.0))


def follow(
    mechanism: Mechanism,
    times: FloatArray,
    start: Assembly,
    wished: FloatArray,
    p: FloatArray,
    progress: Progress,
) -> Walk:
    """Walk from the assembled start through `times`; `wished`: the start velocities asked for."""
    follower = Follower(Equations(mechanism, p), times, start)
    course = follower.course
    if course.weak or start.singular:
        # Here Phi_q says neither which branch it is nor how it curves.
        follower.begin(wished)
    outcome, message = follower.run(progress)
    done, r = course.mark, course.record
    crossed = [row for row in follower.singular if row.kind == "crossing"]
    stats: dict[str, float] = {
        "steps": int(r[STEPS]),
        "rejected": int(r[REJECTED]),
        "newton_iterations": int(r[NEWTON]),
        "singular_crossings": len(crossed),
    }
    t, q, v = times[:done], course.q_out[:done], course.v_out[:done]
    if outcome is Outcome.OK:
        message = f"{len(times)} instants from t = {times[0]:g} to {times[-1]:g} s."
    elif done == 0 or course.t > times[done - 1]:
        t, q, v = np.append(t, course.t), np.vstack([q, course.q]), np.vstack([v, course.v])
    message += follower.notes + meeting.crossings(crossed)
    return Walk(t, q, v, outcome, message, stats, tuple(follower.singular))
