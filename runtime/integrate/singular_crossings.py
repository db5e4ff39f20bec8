"""How a run passes a singular position: with one step laid across it.

Where constraints cease to be independent the motion may go on smoothly, but the accelerations are a
quotient 0/0: at the distance τ in time, a rounding error ε of the constraints makes one of
2 ε / (σ' τ³) in them, σ' the rate at which the smallest singular value passes through zero. No
step control helps, as shorter steps only come nearer. But a method evaluates the equations at a few
nodes of its step: the step is laid so that the singular instant falls into the middle of a gap
between two of them. Then nothing is ever computed close to it, nothing has to be rejected, and the
other branches, whose velocities differ, are never seen. Its length balances the error of the method
against rounding, and its error may be the larger of the two. Near the position, states return onto
the constraints by projection: there no choice of independent coordinates is a good one.
"""

from math import sqrt

import numpy as np

from runtime.core.arrays import Vector
from runtime.core.kernel_abi import find_stand_in
from runtime.core.loop_record import Plan
from runtime.core.outcomes import Outcome, Site
from runtime.core.workspace_rows import Y0, Y1, K
from runtime.integrate import crossing_step_planning as cs
from runtime.integrate.loop import WEAK_STATES
from runtime.integrate.problem import Crossing, Problem
from runtime.integrate.run_state import RunState
from runtime.integrate.step import Signal, TrialStep
from runtime.singularity.motion_polynomial import Motion, hermite, taylor
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.singular_position_near_motion import Singularity, SingularPositions

_ALLOWANCE = 100.0  # measured: permitted ratio of the rounding in an error to its expected size
_ASTRAY = 1e-6  # accuracy: of a velocity; error of a start against the branch that it follows
_WRONG = 1e-3  # accuracy: of the sizes of coordinates; a step that errs by more is not taken
_SLACK = 1e3  # measured: factor by which the estimate may err if rounding dominates
_LARGE = 0.5  # measured: of the largest share; units of rows and masses change a share by as much
_PROBE = 0.01  # safety: of the way to a lock-up; distance at which its singular value is compared
_ASKED = 0.1  # safety: of a velocity; a smaller part does not come from a lock-up
_BEND = 10.0  # safety: widths of a bend, from its middle, within which a run may have got stuck
_TRIES = 4  # safety: plans for one crossing

# As integers: looking up a member of an enumeration is slow in Python 3.11.
_FREE, _APPROACHING, _CROSSING, _LEAVING, _MISSING = map(int, Plan)
_GOING = int(Signal.GOING)


class Crossings:
    """Singular positions of one run: looked for when the loop asks, planned, and remembered."""

    def __init__(self, state: RunState, problem: Problem) -> None:
        self.state, self.record, system = state, state.record, state.system
        self.scale = np.asarray(problem.scale, dtype=np.float64)
        m, kernels = system.constraint_count, (system.constraints, system.jacobian)
        places = np.asarray(system.jacobian_rows), np.asarray(system.jacobian_columns)
        rows = np.array(system.independent or range(system.rank), np.int64)
        state.wiring.arrays["shortest"][:] = problem.shortest
        constraints = ScaledConstraints(
            *kernels, system.velocity_rhs, *places, problem.p, self.scale, rows, m,
            state.wiring.arrays["shortest"],
        )  # fmt: skip
        self.positions = SingularPositions(constraints)
        self.handover = cs.MethodHandover(state)
        if system.constraints is find_stand_in("constraints") or m == 0:
            self.record["quiet"] = np.inf  # nothing tells a position that is passed from one missed
        self.begin()

    def begin(self) -> None:
        """Nothing is planned, where the run starts or goes on from one in other coordinates."""
        self.passed: list[Crossing] = []  # those that were crossed
        self.note = ""  # says why one was not
        self.position: Singularity | None = None
        self.step = cs.CrossingStep(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.tries = 0
        self.began, self.rtol = float(self.record["t"]), float(self.record["rtol"])
        self.before = self._start_state()

    @property
    def steps(self) -> cs.CrossingSteps:
        """The steps across that the present method can take."""
        return cs.CrossingSteps(self.scale, self.rtol, self.state.method)

    # -- what the loop asks -------------------------------------------------------------------

    def decide(self) -> int:
        """Answer the loop: go on as planned, or the code of an outcome."""
        r = self.record
        plan = int(r["plan"])
        if plan == _FREE and r["lent"] and r["t"] >= r["lent_until"]:
            self.handover.end()
            return _GOING
        if plan == _APPROACHING:
            return self._cross()
        if plan == _CROSSING:
            return self._judge_step_across()
        return self._plan_crossing(float(r["vanishing"]))

    def prepare_start(self) -> bool:
        """Prepare a start in a singular position; false where no motion leads out of it."""
        if self.record["quiet"] == np.inf:
            return False
        q, v = self.state.y
        motion = taylor(float(self.record["t"]), q, v, np.zeros_like(v))
        position = self.positions.find(motion, 0.0, branch=True)
        if position is None or position.gap > self.steps.rounding(q):
            return False
        if position.astray > max(_ASTRAY, self.rtol):
            self.note = (
                f"The machine starts at, or too near to be told from it, a position in which its "
                f"motions cross; its velocity is off them by {position.astray:.1e} of itself."
            )
            return False
        if not position.rate > 0.0:
            return False
        v += position.veer
        self.position = position
        self.record["plan"] = _CROSSING
        return self._extrapolate(self._motion(), position)

    def leave_start(self) -> int:
        """Lay the first step out of a singular position in which the run starts."""
        assert self.position is not None
        self.handover.begin(self.steps, self.position, 0.0, self._usual_length())
        return self._cross()

    def find_lock_up(self, within: float) -> int:
        """The constraint whose own motion ends in a lock-up within that time, s; -1 for none.

        There the least singular value σ of Φ_q goes as the root of the time left, which is
        -σ/(2 σ̇), and (uᵀν)/σ, what moving constraints ask of it, a good part of the velocity.
        """
        constraints, (q, v), t = self.positions.constraints, self.state.y, float(self.record["t"])
        speed = self._length(v)
        if not (constraints.m and 0.0 < speed < np.inf):
            return -1
        lost, rest, rates = constraints.weakest(t, q)
        asked = lost * rates
        h = _PROBE * rest / speed
        if not abs(asked.sum()) > _ASKED * rest * speed or t + h == t:
            return -1
        change = constraints.weakest(t + h, q + h * v)[1] - rest
        close = change < 0.0 and rest * h <= -2.0 * change * within
        return int(constraints.independent[np.abs(asked).argmax()]) if close else -1

    def is_near_miss(self) -> bool:
        """Whether a run that can go no further is in the bend by which a position is missed."""
        motion = self._motion()
        position = self.positions.find(motion, 0.0)
        if position is None or not position.rate > 0.0:
            return False
        if position.gap <= self.steps.rounding(motion.position):
            return False
        width = _width(position)
        near = abs(position.t - motion.t) < _BEND * width
        if near:
            self._end_at_miss(position, width)
        return near

    # -- steps of a plan ----------------------------------------------------------------------

    def _plan_crossing(self, s: float) -> int:
        """Find the singular position about the time `s` hence, and where its step begins."""
        r, motion = self.record, self._motion()
        position = self.positions.find(motion, s)
        self.tries = 0
        usual, steps = self._usual_length(), self.steps
        weak, r["weak"] = r["weak"], 0
        if position is None or not position.rate > 0.0:
            if weak >= WEAK_STATES:
                return self._end(Site.NO_POSITION)
            # The step that was tried may be taken; the look at the next one is another.
            r["quiet"] = motion.t + max(0.5 * abs(s), 0.5 * usual, 1.001 * r["tried"])
            return _GOING
        if position.gap > steps.rounding(motion.position):
            return self._follow_miss(position)
        ahead = position.t - motion.t
        if ahead < 0.0 and steps.noise(position) * usual < -(ahead**3):
            r["quiet"] = motion.t + usual  # it lies behind, and far enough
            return _GOING
        self.position = position
        if self.handover.begin(steps, position, ahead, usual):
            return _GOING
        return _GOING if self._approach(position, ahead) else self._cross()

    def _approach(self, position: Singularity, ahead: float) -> bool:
        """Whether to come nearer first, to where the best step across begins."""
        r, usual = self.record, self._usual_length()
        best = self.steps.best(position, usual)
        if best.lead > ahead - 1e-3 * usual:
            return False
        r["plan"], r["turn"], r["h"] = _APPROACHING, position.t - best.lead, usual
        return True

    def _cross(self) -> int:
        """Lay the step across from where the run stands."""
        r, motion, position = self.record, self._motion(), self.position
        usual, steps = self._usual_length(), self.steps
        assert position is not None
        again = self.positions.find_again(motion, position)
        if again is None or again.gap > steps.rounding(motion.position):
            r["plan"] = _FREE
            if self.tries >= _TRIES:
                return _GOING
            return self._plan_crossing(position.t - motion.t)
        self.position = position = again
        step, noise = steps.best(position, usual, position.t - motion.t), steps.noise(position)
        noisy = noise * step.h > abs(step.lead) ** 3
        close = abs(step.lead) < steps.reach(position)
        if noisy and close and not self._extrapolate(motion, position):
            return self._end(Site.NO_ACCELERATIONS, position)
        self.step, self.before = step, self._start_state()
        r["plan"], r["length_across"] = _CROSSING, step.h
        permitted = 2.0 * step.method + _ALLOWANCE * (step.rounding + step.start)
        r["permitted"] = min(permitted, _WRONG / self.rtol)
        blind = sqrt(noise)
        r["blind_from"], r["blind_to"] = position.t - blind, position.t + blind
        return _GOING

    def _judge_step_across(self) -> int:
        """The step across was accepted, or not."""
        r, position, step = self.record, self.position, self.step
        error = float(r["error"])
        assert position is not None
        if r["t"] > position.t:
            if r["t"] > self.before[0]:  # or it was refused, and began behind the position
                self._record_crossing(position, error)
            r["plan"], r["quiet"] = _LEAVING, r["t"] + r["length_across"]
            r["lent_until"] = r["quiet"]
            r["permitted"] = 1.0
            self.tries = 0
            r["h"] = self._usual_length()
            return _GOING
        self.tries += 1
        rounded = r["reason"] == TrialStep.TOO_LARGE and step.rounding + step.start > step.method
        is_late = error <= r["permitted"]  # rejected for its samples, or its balance of energy
        if rounded and not is_late and error < min(_SLACK * r["permitted"], _WRONG / self.rtol):
            r["permitted"] = 1.01 * error  # rounding again: another step would fare no better
            return _GOING
        if self.tries > _TRIES:
            way = "loosen" if error * self.rtol < _WRONG else "tighten"
            self.note = f"The step across errs by {error:.1e} times the tolerance; {way} rtol."
            if is_late:
                self.note = (
                    "No step across has samples that meet the constraints and balances the energy; "
                    "take other instants, or loosen rtol."
                )
            return self._end(Site.STEPS_ACROSS, position)
        ahead = position.t - float(r["t"])
        return _GOING if self._approach(position, ahead) else self._cross()

    def _record_crossing(self, position: Singularity, error: float) -> None:
        """Remember a position that is passed, unless a run starts in it, or behind it."""
        t, shares = self._instant(position), position.rows.tolist()
        largest = max(shares)
        large = [row for row, share in enumerate(shares) if share > _LARGE * largest]
        rows = tuple(sorted(large, key=lambda row: shares[row] < largest))
        if t > self.began + self.steps.rounding(position.q) / position.speed:
            self.passed.append(Crossing(t, rows, position.lost, position.direction, error))

    def _end(self, site: Site, position: Singularity | None = None) -> int:
        """End the run; without a position the constraint that the loop named stays."""
        if position is not None:
            self.record["index"] = int(position.rows.argmax())
        self.record["site"] = site
        return int(Outcome.SINGULAR)

    def _follow_miss(self, position: Singularity) -> int:
        """The machine misses the position by a gap: its motion bends away, within the width τ.

        There the singular value is σ' τ and the distance from the position about as large as the
        gap over it: σ' v τ² = gap. Steps must not be longer than that bend, and rounding must
        allow to follow it: a look within the bend ends the run where `noise` > τ²,
        which is gap < 2 `_WEIGHT` `_RESIDUE` size / rtol = 2e-16 size / rtol, whatever σ' and v
        (size: largest coordinate in units of `scale`, at least 1).
        """
        r = self.record
        width = _width(position)
        ahead = position.t - float(r["t"])
        if ahead < width and self.steps.noise(position) > width**2:
            return self._end_at_miss(position, width)
        r["plan"], r["turn"], r["length_across"] = _MISSING, position.t, 0.5 * width
        # From further away than the bend is wide, what is missed may turn out to be met.
        r["quiet"] = r["t"] + 0.5 * ahead
        if ahead < width:
            r["quiet"] = max(position.t + 3.0 * width, r["t"] - 0.5 * ahead)
        return _GOING

    def _end_at_miss(self, position: Singularity, width: float) -> int:
        # Twice the rtol at which rounding and the bend are equal.
        needed = 2.0 * self.rtol * self.steps.noise(position) / width**2
        self.note = (
            f"At t = {position.t:.9g} s the machine misses a position in which its motions "
            f"cross by {position.gap:.1e}, too little to be followed in rounded numbers with "
            f"this rtol; loosen rtol to about {needed:.0e}, or make the lengths agree exactly."
        )
        return self._end(Site.NARROW_MISS, position)

    def _extrapolate(self, motion: Motion, position: Singularity) -> bool:
        """Write the derivative at the step's start, by continuity; false where there is none."""
        reach = self.steps.reach(position)
        a = cs.extrapolate_accelerations(self.state, self.scale, motion, position.t, reach)
        if a is None:
            return False
        self.state.rows[K, 1] = a
        return True

    def _start_state(self) -> tuple[float, tuple[Vector, ...]]:
        """t, and q, v and dv/dt, from which the next step starts."""
        (q, v), a = self.state.rows[Y0].copy(), self.state.rows[K, 1].copy()
        return float(self.record["t"]), (q, v, a)

    def _instant(self, position: Singularity) -> float:
        """When the step across passed the position: from both its ends, not as it was foreseen."""
        (t, start), (t_end, end) = self.before, self._start_state()
        if np.isfinite(position.due):
            return position.due
        if not np.isfinite([start[2], end[2]]).all():
            return position.t
        return self.positions.passing_time(hermite(t, t_end - t, start, end), position)

    # -- what is known -----------------------------------------------------------------------

    def _usual_length(self) -> float:
        """Length of a step here; after a step across that failed, less."""
        return float(max(self.record["usual"], self.record["h"])) * 0.5**self.tries

    def _motion(self) -> Motion:
        """How the machine moves from where the run stands; over a step just tried, where it was."""
        r, rows = self.record, self.state.rows
        t, (q, v), a = float(r["t"]), rows[Y0], rows[K, 1]
        change, speed = 0.1 * float(r["usual"]) * self._length(a), self._length(v)
        if not change <= speed:  # of the velocity in a tenth of a step; also where not finite
            a = np.zeros_like(a)
        if r["tried"] > 0.0:
            return hermite(t, float(r["tried"]), (q, v, a), (*rows[Y1], rows[K + r["last"], 1]))
        return taylor(t, q, v, a)

    def _length(self, vector: Vector) -> float:
        scaled = vector / self.scale
        return sqrt(scaled @ scaled)


def _width(position: Singularity) -> float:
    """The time within which a machine bends away from a position that it misses, s."""
    return sqrt(position.gap / (position.rate * position.speed))
