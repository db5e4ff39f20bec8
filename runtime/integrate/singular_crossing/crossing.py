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

from typing import TYPE_CHECKING

import numpy as np

from runtime.core.array_types import Vector
from runtime.core.kernel_abi import find_stand_in
from runtime.core.outcomes import Outcome
from runtime.core.run_record import Plan
from runtime.core.system import System
from runtime.core.workspace import Y0, Y1, K
from runtime.integrate.loop import WEAK_STATES
from runtime.integrate.method import Method
from runtime.integrate.problem import Problem
from runtime.integrate.signals import Signal
from runtime.integrate.singular_crossing.crossing_step import Leap, Leaps
from runtime.integrate.singular_crossing.extrapolated_accelerations import Continuity
from runtime.integrate.singular_crossing.method_handover import Lending
from runtime.integrate.step import TrialStep
from runtime.integrate.trajectory import Crossing
from runtime.singularity.local_motion import Motion, hermite, taylor
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.singular_position import Singularity, SingularPositions

if TYPE_CHECKING:
    from runtime.integrate.run import _Run

_ALLOWANCE = 100.0  # measured: ratio of rounding in an error to its expectation that is let pass
_ASTRAY = 1e-6  # accuracy: of a velocity; error of a start against the branch that it follows
_SLACK = 1e3  # measured: factor by which the estimate may be wrong where rounding rules
_TRIES = 4  # safety: plans for one crossing


class Crossings:
    """Singular positions of one run: looked for when the loop asks, planned, and remembered."""

    def __init__(self, system: System, problem: Problem, run: "_Run", method: Method) -> None:
        self.run, self.r = run, run.r
        self.scale = np.asarray(problem.scale, dtype=np.float64)
        constraints = ScaledConstraints(
            system.constraints,
            system.jacobian,
            system.velocity_rhs,
            np.asarray(system.jacobian_rows),
            np.asarray(system.jacobian_columns),
            problem.p,
            self.scale,
            np.arange(system.constraint_count)
            if system.independent is None
            else np.asarray(system.independent, dtype=np.int64),
            system.constraint_count,
        )
        self.positions = SingularPositions(constraints)
        self.leaps = Leaps(self.scale, float(self.r["rtol"]), method)
        self.lending = Lending(run, self.leaps)
        self.continuity = Continuity(system, run.p, run.modes, self.scale)
        if system.constraints is find_stand_in("constraints") or system.constraint_count == 0:
            self.r["quiet"] = np.inf  # nothing tells a position that is passed from one missed
        self.passed: list[Crossing] = []
        self.note = ""
        self.found: Singularity | None = None
        self.leap = Leap(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.tries = 0
        self.began = float(self.r["t"])
        self.before = (self.began, *(np.zeros(self.scale.size),) * 3)

    # -- what the loop asks -------------------------------------------------------------------

    def follow(self, method: Method) -> None:
        """Plan for the steps of the method."""
        self.leaps.follow(method)

    def look(self) -> int:
        """Answer the loop: go on as planned, or the code of an outcome."""
        r = self.r
        if r["plan"] == Plan.FREE and r["lent"] and r["t"] >= r["lent_until"]:
            self.lending.end()
            return Signal.GOING
        if r["plan"] == Plan.APPROACHING:
            return self.cross()
        if r["plan"] == Plan.CROSSING:
            return self._crossed()
        return self._plan(float(r["vanishing"]))

    def begin(self) -> bool:
        """Prepare a start in a singular position; false where no motion leads out of it."""
        run = self.run
        if not np.isfinite(self.r["quiet"]) and self.r["quiet"] > 0.0:
            return False
        q, v = run.state
        motion = taylor(float(self.r["t"]), q, v, np.zeros_like(v))
        found = self.positions.find(motion, 0.0)
        if found is None or found.gap > self.leaps.rounding(q):
            return False
        if found.astray > max(_ASTRAY, float(self.r["rtol"])):
            self.note = (
                f"The machine starts at, or too near to be told from it, a position in which its "
                f"motions cross; its velocity is off them by {found.astray:.1e} of itself."
            )
            return False
        if not found.rate > 0.0:
            return False
        v += found.veer
        self.found = found
        self.r["plan"] = Plan.CROSSING
        return self._continued(self._motion(), found)

    def leave(self) -> int:
        """Lay the first step out of a singular position in which the run starts."""
        assert self.found is not None
        self.lending.lend(self.found, 0.0, self._usual())
        return self.cross()

    # -- steps of a plan ----------------------------------------------------------------------

    def _plan(self, s: float) -> int:
        """Find the singular position about the time `s` hence, and where its step begins."""
        r, motion = self.r, self._motion()
        found = self.positions.find(motion, s)
        self.tries = 0
        usual = self._usual()
        if (found is None or not found.rate > 0.0) and r["weak"] >= WEAK_STATES:
            return int(Outcome.SINGULAR)
        r["weak"] = 0
        if found is None or not found.rate > 0.0:
            # The step that was tried may be taken; the look at the next one is another.
            r["quiet"] = motion.t + max(0.5 * abs(s), 0.5 * usual, 1.001 * r["tried"])
            return Signal.GOING
        if found.gap > self.leaps.rounding(motion.q):
            return self._missed(found)
        ahead = found.t - motion.t
        if ahead < 0.0 and self.leaps.noise(found) * usual < -(ahead**3):
            r["quiet"] = motion.t + usual  # it lies behind, and far enough
            return Signal.GOING
        self.found = found
        if self.lending.lend(found, ahead, usual):
            return Signal.GOING
        return Signal.GOING if self._approached(found, ahead) else self.cross()

    def _approached(self, found: Singularity, ahead: float) -> bool:
        """Whether to come nearer first, to where the best step across begins."""
        r, usual = self.r, self._usual()
        best = self.leaps.best(found, usual)
        if best.lead > ahead - 1e-3 * usual:
            return False
        r["plan"], r["turn"], r["h"] = Plan.APPROACHING, found.t - best.lead, usual
        return True

    def cross(self) -> int:
        """Lay the step across from where the run stands."""
        r, motion, found = self.r, self._motion(), self.found
        usual = self._usual()
        assert found is not None
        again = self.positions.find_again(motion, found)
        if again is None or again.gap > self.leaps.rounding(motion.q):
            r["plan"] = Plan.FREE
            return self._plan(found.t - motion.t) if self.tries < _TRIES else Signal.GOING
        self.found = found = again
        leap = self.leaps.from_here(found, found.t - motion.t, usual)
        noisy = self.leaps.noise(found) * leap.h > abs(leap.lead) ** 3
        if (
            noisy
            and abs(leap.lead) < self.leaps.reach(found)
            and not self._continued(motion, found)
        ):
            return int(Outcome.SINGULAR)
        self.leap, self.before = leap, self._state()
        r["plan"], r["leap"] = Plan.CROSSING, leap.h
        r["permitted"] = 2.0 * leap.method + _ALLOWANCE * (leap.rounding + leap.start)
        blind = np.sqrt(self.leaps.noise(found))
        r["blind_from"], r["blind_to"] = found.t - blind, found.t + blind
        return Signal.GOING

    def _crossed(self) -> int:
        """The step across was accepted, or not."""
        r, found = self.r, self.found
        assert found is not None
        if r["t"] > found.t:
            row = int(found.rows.argmax())
            error = float(r["error"])
            t = self._instant(found)
            # A position in which a run starts, or that lies before its start, is not passed in it.
            if t > self.began + self.leaps.rounding(found.q) / found.speed:
                self.passed.append(Crossing(t, row, found.lost, found.direction, error))
            r["plan"], r["quiet"] = Plan.LEAVING, r["t"] + r["leap"]
            r["lent_until"] = r["quiet"]
            r["permitted"] = 1.0
            self.tries = 0
            r["h"] = self._usual()
            return Signal.GOING
        self.tries += 1
        error = float(r["error"])
        leap = self.leap
        rounded = r["reason"] == TrialStep.TOO_LARGE and leap.rounding + leap.start > leap.method
        if rounded and error < _SLACK * r["permitted"]:
            r["permitted"] = 1.01 * error  # rounding again: another step would fare no better
            return Signal.GOING
        if self.tries > _TRIES:
            r["index"] = int(found.rows.argmax())
            self.note = f"The step across errs by {error:.1e} times the tolerance; loosen rtol."
            return int(Outcome.SINGULAR)
        ahead = found.t - float(r["t"])
        return Signal.GOING if self._approached(found, ahead) else self.cross()

    def _missed(self, found: Singularity) -> int:
        """The machine misses the position by a gap: its motion bends away, within the width τ.

        There the singular value is σ' τ and the distance from the position about as large as the
        gap over it: σ' v τ² = gap. Steps must not be longer than that bend, and rounding must
        allow to follow it.
        """
        r = self.r
        width = float(np.sqrt(found.gap / (found.rate * found.speed)))
        ahead = found.t - float(r["t"])
        if ahead < width and self.leaps.noise(found) > width**2:
            r["index"] = int(found.rows.argmax())
            self.note = (
                f"At t = {found.t:.9g} s the machine misses a position in which its motions cross "
                f"by {found.gap:.1e}, too little to be followed in rounded numbers with this rtol."
            )
            return int(Outcome.SINGULAR)
        r["plan"], r["turn"], r["leap"] = Plan.MISSING, found.t, 0.5 * width
        # From further away than the bend is wide, what is missed may turn out to be met.
        r["quiet"] = r["t"] + 0.5 * ahead
        if ahead < width:
            r["quiet"] = max(found.t + 3.0 * width, r["t"] - 0.5 * ahead)
        return Signal.GOING

    def _continued(self, motion: Motion, found: Singularity) -> bool:
        """Write the derivative at the step's start, by continuity; false where there is none."""
        a = self.continuity.accelerations(motion, found.t, self.leaps.reach(found))
        if a is None:
            return False
        self.run.rows[K, 1] = a
        return True

    def _state(self) -> tuple[float, Vector, Vector, Vector]:
        """t, q, v and dv/dt from which the next step starts."""
        rows = self.run.rows
        return float(self.r["t"]), rows[Y0, 0].copy(), rows[Y0, 1].copy(), rows[K, 1].copy()

    def _instant(self, found: Singularity) -> float:
        """When the step across passed the position: from both its ends, not as it was foreseen."""
        t, q, v, a = self.before
        after = self._state()
        if np.isfinite(found.due):
            return found.due
        if not (np.isfinite(a).all() and np.isfinite(after[3]).all()):
            return found.t
        motion = hermite(t, after[0] - t, (q, v, a), after[1:])
        return self.positions.passing_time(motion, found)

    # -- what is known -----------------------------------------------------------------------

    def _usual(self) -> float:
        """Length of a step here; after a step across that failed, less."""
        return float(max(self.r["usual"], self.r["h"])) * 0.5**self.tries

    def _motion(self) -> Motion:
        """How the machine moves from where the run stands; over a step just tried, where it was."""
        r, n = self.r, self.run.n
        rows = self.run.rows
        t = float(r["t"])
        start = rows[Y0, 0], rows[Y0, 1], rows[K, 1]
        if not np.isfinite(start[2]).all() or self._bent(start):
            start = start[0], start[1], np.zeros(n)
        if r["tried"] > 0.0:
            return hermite(t, float(r["tried"]), start, (*rows[Y1], rows[K + r["last"], 1]))
        return taylor(t, *start)

    def _bent(self, start: tuple[Vector, ...]) -> bool:
        """Whether these accelerations would change the velocity within a tenth of a step."""
        step = 0.1 * float(self.r["usual"])
        return bool(step * self._length(start[2]) > self._length(start[1]))

    def _length(self, vector: Vector) -> float:
        return float(np.linalg.norm(vector / self.scale))
