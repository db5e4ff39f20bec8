"""Continuation of a driven motion through its instants, folds and branch points included.

Where the predictor-corrector gets stuck, or lands on another assembly of the machine, the singular
configuration behind it is located (`runtime.singularity.singular_position_near_motion`). At a
branch point the branch of continuous velocity is interpolated (`bifurcation_branches`). Where
branches only come close, or at a fold, the curve of positions is followed by its arc length
(`arclength`).
"""

from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from codegen.object_display import counted
from codegen.termination_signals import SignalDeferral
from runtime.continuation import singular_position_messages as classification
from runtime.continuation.arclength import Curve, Point
from runtime.continuation.bifurcation_branches import (
    DISTANCE,
    RankDeficiency,
    distance_between,
    interpolate_branch,
    is_ambiguous,
)
from runtime.continuation.predictor_corrector import (
    ARRIVED,
    DONE,
    STEEP,
    SUSPECT,
    ContinuationState,
)
from runtime.core.arrays import EPS
from runtime.core.outcomes import Outcome
from runtime.mechanism.dense_equations import Equations, FloatArray, row_lengths
from runtime.progress_bar import Progress
from runtime.results.assembled_state import Assembly
from runtime.results.run_records import Kind, SingularPosition
from runtime.singularity.motion_polynomial import taylor
from runtime.singularity.singular_position_near_motion import Singularity, SingularPositions

_ROUNDING = 64.0 * EPS  # accuracy: gap, in parts of the largest coordinate, that is rounding
_DRIFT = 1e-4  # accuracy: |uᵀ ν| of a branch point or a near miss of one, if the drivers' pace is 1
_SEEN = 17  # safety: instants at which the drivers' pace is sampled
# measured: scaled length from which on a stretch without a singular position is traced
_CLOSE = 1e-3
_ABOUT = 1e-2  # measured: scaled distance of a cause from the position at which the steps get stuck
# accuracy: distance of a state from its branch, over that from the next branch
_NEARER = 0.3
# accuracy: scaled distance from a singular position from which on a start shows its branch
_DISTINCT = 1e-7
_MOST_STEPS = 20_000_000  # safety: of the predictor-corrector; ten seconds with one body
_PATIENCE = 100  # safety: searches for a cause in a row without progress
_WITHIN = 0.99  # measured: part of a zone's reach that lies safely inside
# measured: of the smallest singular value at the start of a trace; from there on the trace has left
_REGAINED = 0.3
_WIDE = 1e-2  # measured: or the singular value from which on it has left
_FARTHEST = 1.0  # safety: scaled length of the longest trace


class DrivenMotion(NamedTuple):
    """A driven motion: states at the instants reached, outcome, and singular configurations."""

    t: FloatArray
    q: FloatArray
    v: FloatArray
    outcome: Outcome
    message: str
    stats: dict[str, float]
    singular: tuple[SingularPosition, ...]


class Continuation(ContinuationState):
    """One continuation through `times` from an assembled start; call `run` once."""

    def __init__(self, equations: Equations, times: FloatArray, start: Assembly) -> None:
        super().__init__(equations, times, start)
        self.positions = SingularPositions(self.constraints)
        self.awaited: Singularity | None = None
        self.singular: list[SingularPosition] = []
        self.notes = ""

    @cached_property
    def pace(self) -> float:
        """Fastest rate at which the drivers move the constraints, 1/s, at least 1e-3.

        At some instants and one position, since most laws of time do not depend on q.
        """
        equations, ends = self.equations, (self.began, *map(float, self.times[[0, -1]]))
        seen = np.concatenate([np.linspace(*pair, _SEEN) for pair in pairwise(ends)])
        lengths = row_lengths(equations.jacobian(seen[0], self.q) * self.scale)
        lengths = np.maximum(lengths, self.shortest)
        rates = [np.linalg.norm(equations.velocity_rhs(t, self.q) / lengths) for t in seen]
        return max([1e-3, *(float(rate) for rate in rates if np.isfinite(rate))])

    def run(self, progress: Progress) -> tuple[Outcome, str]:
        """Continue to the last instant, to the end of the motion, or to an interrupt."""
        with SignalDeferral(computing=True) as signals:
            return self._run(progress, signals)

    def _run(self, progress: Progress, signals: SignalDeferral) -> tuple[Outcome, str]:
        farthest, idle = (-1, 0.0), 0
        steepest = self._steepest()
        while not self.finished:
            if signals.arrived:
                signals.answered, outcome = True, Outcome.INTERRUPTED
                text = f"Stopped at t = {self.t:.9g} s. {outcome.meaning} {outcome.advice}"
                return outcome, text
            done, status = self.mark, self.advance()
            progress(abs(self.t - self.began) / self.span)
            taken = int(self.record.steps + self.record.rejected)
            soaring = status == DONE and done == self.mark and self._steepest() > STEEP * steepest
            if (taken >= _MOST_STEPS or soaring) and not self.finished:
                return Outcome.MAX_STEPS, self._too_far(taken)
            if status == DONE:
                continue
            self.sample()
            place = self.mark, self.ahead * self.t
            farthest, idle = (place, 0) if place > farthest else (farthest, idle + 1)
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

    def _steepest(self) -> float:
        return float(np.abs(self.equations.slopes(self.t, self.q)).max(initial=0.0))

    def _judge(self, suspect: bool) -> tuple[Outcome, str] | None:
        """Find why the predictor-corrector stopped, and continue; or return the end of the run."""
        r = self.record
        t, ahead, speed = self.t, self.ahead, self.speed
        stretch = abs(float(r.end) - t) if suspect else _ABOUT / speed
        guess = ahead * stretch * float(r.zero) if suspect else 0.0
        found = self.positions.find(taylor(t, self.q, self.v, self.a), guess)
        if found is not None and not self._on_the_way(found, ahead, stretch):
            found = None
        if found is not None and found.gap <= self._rounding:
            known = self.awaited is not None and abs(self.awaited.t - found.t) * speed < 1e-6
            if suspect and known and (r.barrier - t) * ahead > 0.0:
                r.step = 0.25 * stretch  # it strayed on the way there
                return None
            self.awaited = found
            self.return_to_good()
            r.step = max(r.step, _ABOUT / speed)
            t, ahead = self.t, self.ahead
            barrier = found.t - ahead * 2.0 * DISTANCE / max(found.rate, found.speed)
            if (barrier - t) * ahead > 0.0:
                r.barrier = barrier
                return None
            return self._cross(found)
        if found is None and suspect and stretch * speed > _CLOSE:
            r.step = 0.25 * stretch
            return None
        return self._trace(found, t + ahead * stretch if suspect else t)

    @property
    def _rounding(self) -> float:
        """A gap that is rounding, in units of the rows here."""
        return _ROUNDING * float(np.abs(self.q / self.scale).max(initial=1.0))

    def _on_the_way(self, found: Singularity, ahead: float, stretch: float) -> bool:
        """Whether motions, or their continuations, cross within the stretch.

        Near a fold the motion is so fast that time hardly tells: it must not take part in what is
        lost.
        """
        way = ahead * (found.t - self.t)
        room = 1e-3 / found.speed
        if not (found.rate > 0.0 and -room < way < 1.5 * stretch + room):
            return False
        return self._deficiency(found.t, found.q, least=1).drift(self.pace) < _DRIFT

    # -- branch points ------------------------------------------------------------------------

    def _cross(self, found: Singularity) -> tuple[Outcome, str] | None:
        """Cross a branch point with continuous velocity; end where the branch is undecided."""
        equations = self.equations
        coming = self.v + (found.t - self.t) * self.a
        t, q = self._due(found), found.q
        choices = self._deficiency(t, q).branches(coming)
        if choices:
            # Once more from there: located from afar, it is as accurate as one Newton step.
            motion = taylor(t, q, choices[0].v, choices[0].a)
            again = self.positions.find(motion, 0.0) or found
            t, q = self._due(again), again.q
            choices = self._deficiency(t, q).branches(coming)
        zone = None
        if choices and (len(choices) == 1 or choices[0].far < _NEARER * choices[1].far):
            zone = interpolate_branch(equations, t, q, choices, self.scale, found.rate)
        if zone is not None and zone.holds(self.t):
            off = np.linalg.norm((zone.at(self.t)[0] - self.q) / self.scale)
            apart = distance_between(choices, self.scale)
            if off > _NEARER * apart * abs(t - self.t) + 1e-9:
                zone = None
        if zone is None:
            return Outcome.SINGULAR, self._unclear()
        entry = zone.t - self.ahead * _WITHIN * zone.reach
        if not zone.holds(self.t) and (entry - self.t) * self.ahead > 0.0:
            self.record.barrier = entry  # nearer than most: go there first
            return None
        self.awaited = None
        if self.cross(zone, np.sign(t - self.t) or self.ahead):
            self._record("crossing", t, q, choices[0].v)
        return None

    def _due(self, found: Singularity) -> float:
        """When the drivers reach a singular position, s; their rates may vanish there."""
        if abs(found.due - found.t) * found.speed < _ABOUT:
            return found.due
        return classification.driven_instant(self.equations, found.t, found.q)

    def begin(self, preferred: FloatArray) -> None:
        """Start in a singular configuration, on the branch nearest to `preferred` velocities.

        Farther than `_DISTINCT` off it, the branch is that of the assembled velocities.
        """
        equations, scale = self.equations, self.scale
        t, q = self.t, self.q.copy()
        found = self.positions.find(taylor(t, q, self.v, np.zeros_like(q)), 0.0)
        away = np.inf if found is None else np.linalg.norm((q - found.q) / scale)
        if found is not None and away < _CLOSE and found.gap <= self._rounding:
            preferred = self.v if away > _DISTINCT else preferred
            t, q = self._due(found), found.q
        at = self._deficiency(t, q)
        if at.k == 0 and not self.weak:
            return  # a row is short, but not lost
        choices = at.branches(preferred)
        position = self._describe("start", self.t, q, self.v)
        if not choices or is_ambiguous(choices, scale):
            raise classification.no_start(equations, position, choices)
        self.v[:], self.a[:] = choices[0].v, choices[0].a
        if (self.times == t).all():
            self.q_out[:], self.v_out[:] = q, self.v
            self.record.mark = len(self.times)
        else:
            found = self.positions.find(taylor(t, q, self.v, self.a), 0.0)
            rate = self.speed if found is None else found.rate
            zone = interpolate_branch(equations, t, q, choices, scale, rate)
            if zone is None:
                raise classification.no_start(equations, position, [])
            self.cross(zone, self.ahead)
        self.singular.append(position._replace(v=choices[0].v))
        self.notes += (
            f" Started in a singular position at t = {position.time:.6g} s, on the branch nearest "
            f"to the start velocities; without them the machine is free to move by {position.free}."
        )

    # -- folds and near misses of branch points ------------------------------------------------

    def _trace(self, missed: Singularity | None, end: float) -> tuple[Outcome, str] | None:
        """Follow the curve of positions by its arc length until Phi_q is regular beyond `end`."""
        ahead, rate = self.ahead, self.pace
        curve = Curve(self.constraints, self.t, self.q, rate)
        along = ahead * np.append(self.v / self.scale, rate)
        begin = curve.point(curve.z(self.t, self.q), along)
        if begin is None:
            return self._stopped(self.t, self.q)
        wide = min(max(_REGAINED * curve.narrowness(begin), 1e-3), _WIDE)

        def free(point: Point) -> bool:
            beyond = (curve.position(point.z)[0] - end) * ahead > 0.0
            far = float(np.linalg.norm(point.z - begin.z))
            return (beyond and curve.narrowness(point) > wide) or far > _FARTHEST

        avoid = None if missed is None else curve.z(missed.t, missed.q)
        trace = curve.trace(begin, ahead, free, avoid)
        for piece in trace.pieces:
            self.sample_piece(curve, piece, ahead)
        self.record.steps += len(trace.pieces)
        if self.finished:
            return None
        point = trace.pieces[-1].end if trace.pieces else begin
        t, q = curve.position(point.z)
        self.q[:], self.record.t = q, t
        if trace.lost:
            return self._stopped(t, q)
        if trace.folded:
            self.v[:] = np.nan
            found = self._record("lock-up", t, q, self.v)
            return Outcome.LOCKED, classification.lock_up(self.equations, found)
        self.v[:] = curve.velocity(point)
        self.resume(t, trace.pieces[-1].h / rate)
        self.awaited = None
        return None

    def _stopped(self, t: float, q: FloatArray) -> tuple[Outcome, str]:
        """The end where there is no fold: an element has no value, or no smooth motion leads on."""
        message = classification.undefined(self.equations, t, self.ahead, q)
        return Outcome.LOCKED, message or self._unclear()

    def _too_far(self, taken: int) -> str:
        """What the steps have come to, and what there still is to do."""
        return (
            f"Stopped at t = {self.t:.9g} s. {Outcome.MAX_STEPS.meaning} In {taken} steps the "
            f"motion was followed for {abs(self.t - self.began):.3g} s of {self.span:.3g} s; it "
            f"goes {self.speed:.3g} times its own size in a second. Look for a driver that is too "
            "fast, or go on from there: give t_start= and, with guess=, the state reached."
        )

    def _unclear(self) -> str:
        """Record the present position as singular, and say why no motion leads on."""
        return classification.unclear(self._record("unclear", self.t, self.q, self.v))

    def _deficiency(self, t: float, q: FloatArray, least: int = 0) -> RankDeficiency:
        return RankDeficiency(self.equations, t, q, self.scale, self.shortest, least)

    def _describe(self, kind: Kind, t: float, q: FloatArray, v: FloatArray) -> SingularPosition:
        return classification.describe(self._deficiency(t, q, least=1), kind, v, self.pace)

    def _record(self, kind: Kind, t: float, q: FloatArray, v: FloatArray) -> SingularPosition:
        self.singular.append(self._describe(kind, t, q, v))
        return self.singular[-1]


def follow(
    equations: Equations, times: FloatArray, start: Assembly, preferred: FloatArray,
    progress: Progress,
) -> DrivenMotion:  # fmt: skip
    """Continue from the assembled start through `times`.

    `preferred` are the start velocities that the user gave; they choose the branch at a singular
    start.
    """
    state = Continuation(equations, times, start)
    if state.weak or start.singular or state.has_vanishing_row:
        # Here Phi_q determines neither the branch nor its curvature.
        state.begin(preferred)
    outcome, message = state.run(progress)
    done, r = state.mark, state.record
    crossed = [row for row in state.singular if row.kind == "crossing"]
    stats: dict[str, float] = {
        "steps": int(r.steps),
        "rejected": int(r.rejected),
        "newton_iterations": int(r.newton),
        "singular_crossings": len(crossed),
    }
    t, q, v = times[:done], state.q_out[:done], state.v_out[:done]
    if outcome is Outcome.OK:
        message = f"{counted(len(times), 'instant')} from t = {times[0]:g} to {times[-1]:g} s."
    elif done == 0 or state.t > times[done - 1]:
        t, q, v = np.append(t, state.t), np.vstack([q, state.q]), np.vstack([v, state.v])
    message += state.notes + classification.crossings(crossed)
    return DrivenMotion(t, q, v, outcome, message, stats, tuple(state.singular))
