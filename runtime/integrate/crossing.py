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

from itertools import pairwise
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.constraints.singular import Motion, Positions, Singularity, hermite, taylor
from runtime.integrate import driver
from runtime.integrate.attempt import TOO_LARGE
from runtime.integrate.changing import adopt
from runtime.integrate.control import first_step
from runtime.integrate.problem import Crossing, Problem, System
from runtime.integrate.signatures import Vector, no_right_side
from runtime.integrate.workspace import (
    APPROACHING,
    CROSSING,
    FREE,
    LEAVING,
    MISSING,
    ROWS,
    Y0,
    Y1,
    K,
)
from runtime.outcomes import Outcome

if TYPE_CHECKING:
    from runtime.integrate.run import _Run

FloatArray = npt.NDArray[np.float64]
_EPS = 2.2e-16
_ROUNDING = 64.0  # units of rounding within which a constraint counts as satisfied
_RESIDUE = 1e-15  # of a position: what Newton's iterations leave of a constraint
_ALLOWANCE = 100.0  # the part of rounding in an error may be this many times what is expected
_ASTRAY = 1e-6  # of a velocity: what a start may be off the branch that it follows
_SLACK = 1e3  # where rounding rules, the estimate of it may be wrong by as much as this
_TRIES = 4
_LEADING = "dop853"  # across, for methods that do not reach
_ITERATING = ("bdf", "radau5")
_POOR = 10.0  # error over tolerance from which on another method leads across
_LEARNING = 0.2  # of the way there: the first step of a method that is lent
_ROOM = 0.1  # of a step: the distance from a node below which errors of stages tell
_WEIGHT = 0.1  # of one stage in the result of a step
_TAYLOR = 5e-3  # eps ** (1/7): of the time scale, where rounding balances a cubic's error


class Leap(NamedTuple):
    """A step across: its length, its beginning before the singular instant, s, and errors.

    `method` and `rounding` are expected errors over the tolerance; `start` is the part of the
    latter that is due to the derivative at the beginning; `total` is what to choose by.
    """

    h: float
    lead: float
    method: float
    rounding: float
    start: float
    total: float


class Crossings:
    """Singular positions of one run: looked for when the loop asks, planned, and remembered."""

    def __init__(self, system: System, problem: Problem, run: "_Run", parts: ModuleType) -> None:
        self.run, self.r, self.system = run, run.r, system
        self.follow(parts)
        self.scale = np.asarray(problem.scale, dtype=np.float64)
        self.positions = Positions(
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
        if system.constraints is no_right_side:
            self.r["quiet"] = np.inf  # nothing tells a position that is passed from one missed
        self.passed: list[Crossing] = []
        self.note = ""
        self.found: Singularity | None = None
        self.leap = Leap(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.tries, self.kept = 0, 0.0

    # -- what the loop asks -------------------------------------------------------------------

    def follow(self, parts: ModuleType) -> None:
        """Plan for the steps of the method that is a module `parts`."""
        self.order = parts.ERROR_ORDER + 1
        nodes = sorted(getattr(parts, "NODES", (0.0, 1.0)))
        self.gaps = [(a, b) for a, b in pairwise(nodes) if b > a]

    def look(self) -> int:
        """Answer the loop: go on as planned, or the code of an outcome."""
        r = self.r
        if r["plan"] == FREE and r["lent"] and r["t"] >= r["lent_until"]:
            return self._given_back()
        if r["plan"] == APPROACHING:
            return self.cross()
        if r["plan"] == CROSSING:
            return self._crossed()
        return self._plan(float(r["vanishing"]))

    def begin(self) -> bool:
        """Prepare a start in a singular position; false where no motion leads out of it."""
        run = self.run
        if not np.isfinite(self.r["quiet"]) and self.r["quiet"] > 0.0:
            return False
        q, v = run.state
        motion = taylor(float(self.r["t"]), q, v, np.zeros_like(v))
        found = self.positions.near(motion, 0.0)
        if found is None or found.gap > self._rounding(q) or not found.rate > 0.0:
            return False
        if found.astray > max(_ASTRAY, float(self.r["rtol"])):
            self.note = (
                f"The machine starts at, or too near to be told from it, a position in which its "
                f"motions cross; its velocity is off them by {found.astray:.1e} of itself."
            )
            return False
        v += found.veer
        self.found = found
        self.r["plan"] = CROSSING
        return self._continued(self._motion(), found)

    def leave(self) -> int:
        """Lay the first step out of a singular position in which the run starts."""
        assert self.found is not None
        self._lend(self.found, 0.0)
        return self.cross()

    # -- steps of a plan ----------------------------------------------------------------------

    def _plan(self, s: float) -> int:
        """Find the singular position about the time `s` hence, and where its step begins."""
        r, motion = self.r, self._motion()
        found = self.positions.near(motion, s)
        self.tries = 0
        usual = self._usual()
        if (found is None or not found.rate > 0.0) and r["weak"] >= driver.WEAK_STATES:
            return int(Outcome.SINGULAR)
        r["weak"] = 0
        if found is None or not found.rate > 0.0:
            # The step that was tried may be taken; the look at the next one is another.
            r["quiet"] = motion.t + max(0.5 * abs(s), 0.5 * usual, 1.001 * r["tried"])
            return driver.GOING
        if found.gap > self._rounding(motion.q):
            return self._missed(found)
        ahead = found.t - motion.t
        if ahead < 0.0 and self._noise(found) * usual < -(ahead**3):
            r["quiet"] = motion.t + usual  # it lies behind, and far enough
            return driver.GOING
        self.found = found
        if self._lend(found, ahead):
            return driver.GOING
        return driver.GOING if self._approached(found, ahead) else self.cross()

    def _approached(self, found: Singularity, ahead: float) -> bool:
        """Whether to come nearer first, to where the best step across begins."""
        r, usual = self.r, self._usual()
        best = self._best(found, usual)
        if best.lead > ahead - 1e-3 * usual:
            return False
        r["plan"], r["turn"], r["h"] = APPROACHING, found.t - best.lead, usual
        return True

    def cross(self) -> int:
        """Lay the step across from where the run stands."""
        r, motion, found = self.r, self._motion(), self.found
        usual = self._usual()
        assert found is not None
        again = self.positions.again(motion, found)
        if again is None or again.gap > self._rounding(motion.q):
            r["plan"] = FREE
            return self._plan(found.t - motion.t) if self.tries < _TRIES else driver.GOING
        self.found = found = again
        leap = self._from_here(found, found.t - motion.t, usual)
        noisy = self._noise(found) * leap.h > abs(leap.lead) ** 3
        if noisy and abs(leap.lead) < self._reach(found) and not self._continued(motion, found):
            return int(Outcome.SINGULAR)
        self.leap = leap
        r["plan"], r["leap"] = CROSSING, leap.h
        r["permitted"] = 2.0 * leap.method + _ALLOWANCE * (leap.rounding + leap.start)
        blind = np.sqrt(self._noise(found))
        r["blind_from"], r["blind_to"] = found.t - blind, found.t + blind
        return driver.GOING

    def _crossed(self) -> int:
        """The step across was accepted, or not."""
        r, found = self.r, self.found
        assert found is not None
        if r["t"] > found.t:
            row = int(found.rows.argmax())
            error = float(r["error"])
            self.passed.append(Crossing(found.t, row, found.lost, found.direction, error))
            r["plan"], r["quiet"] = LEAVING, r["t"] + r["leap"]
            r["lent_until"] = r["quiet"]
            r["permitted"] = 1.0
            self.tries = 0
            r["h"] = self._usual()
            return driver.GOING
        self.tries += 1
        error = float(r["error"])
        leap = self.leap
        rounded = r["reason"] == TOO_LARGE and leap.rounding + leap.start > leap.method
        if rounded and error < _SLACK * r["permitted"]:
            r["permitted"] = 1.01 * error  # rounding again: another step would fare no better
            return driver.GOING
        if self.tries > _TRIES:
            r["index"] = int(found.rows.argmax())
            self.note = f"The step across errs by {error:.1e} times the tolerance; loosen rtol."
            return int(Outcome.SINGULAR)
        ahead = found.t - float(r["t"])
        return driver.GOING if self._approached(found, ahead) else self.cross()

    def _missed(self, found: Singularity) -> int:
        """The machine misses the position by a gap: its motion bends away, within the width τ.

        There the singular value is σ' τ and the distance from the position about as large as the
        gap over it: σ' v τ² = gap. Steps must not be longer than that bend, and rounding must
        allow to follow it.
        """
        r = self.r
        width = float(np.sqrt(found.gap / (found.rate * found.speed)))
        ahead = found.t - float(r["t"])
        if ahead < width and self._noise(found) > width**2:
            r["index"] = int(found.rows.argmax())
            self.note = (
                f"At t = {found.t:.9g} s the machine misses a position in which its motions cross "
                f"by {found.gap:.1e}, too little to be followed in rounded numbers with this rtol."
            )
            return int(Outcome.SINGULAR)
        r["plan"], r["turn"], r["leap"] = MISSING, found.t, 0.5 * width
        # From further away than the bend is wide, what is missed may turn out to be met.
        r["quiet"] = r["t"] + 0.5 * ahead
        if ahead < width:
            r["quiet"] = max(found.t + 3.0 * width, r["t"] - 0.5 * ahead)
        return driver.GOING

    # -- methods ------------------------------------------------------------------------------

    def _lend(self, found: Singularity, ahead: float) -> bool:
        """Let the explicit method of highest order step for one that does not reach across.

        None that is implicit does: at the distance τ the derivative of the accelerations by the
        velocities is 2/τ, of opposite signs on both sides, and no Newton iteration goes through
        that. One of low order does not where its steps are so short that rounding rules.

        Returns whether there is way left on which to learn how long steps may be.
        """
        run, r = self.run, self.r
        name = run.methods[-1][1]
        if name in {_LEADING, "auto"} or r["lent"]:
            return False
        if name not in _ITERATING and self._best(found, self._usual()).total < _POOR:
            return False
        self.kept = float(r["h"])
        r["lent"], r["automatic"] = 1, 0
        r["lent_until"] = found.t + max(ahead, self.kept)
        adopt(run, _LEADING)
        p, modes, lam = run.fixed_arrays[3], run.fixed_arrays[4], run.fixed_arrays[6]
        first = first_step(
            run.wiring.table, r["t"], r["h_max"], r["rtol"], r["order"], run.w, p, modes, lam
        )
        way = _LEARNING * ahead
        r["usual"] = r["h"] = min(first, way) if way > 0.0 else max(first, self.kept)
        r["look_at"] = r["t"]
        return way > 0.0

    def _given_back(self) -> int:
        """Go on with the method that was asked for."""
        run, r = self.run, self.r
        r["lent"], r["automatic"] = 0, int(run.options.method == "auto")
        r["h"] = self.kept
        adopt(run, run.methods[-1][1])
        return driver.GOING

    # -- lengths ------------------------------------------------------------------------------

    def _noise(self, found: Singularity) -> float:
        """Error over tolerance, times g³ h², of a step h that keeps the distance g h."""
        rounding = _RESIDUE * self._size(found.q)
        return 2.0 * _WEIGHT * rounding / (found.rate * found.speed * float(self.r["rtol"]))

    def _leap(self, found: Singularity, h: float, lead: float, g: float, usual: float) -> Leap:
        """A step that keeps the distance g h between its nodes and the singular instant.

        Its error is that of the method, of rounding, and of stages: they lie off the constraints
        by their own errors, which the accelerations at that distance multiply by about 1/g; and
        the instant is known only so well.
        """
        method = max(h / usual, 1.0) ** self.order
        rounding = self._noise(found) / (g**3 * h**2)
        start = self._noise(found) * h / max(abs(lead), 1e-100) ** 3
        if abs(lead) < self._reach(found):
            start = min(start, 1.0)  # it will be found by continuity
        unsure = found.miss / (found.speed * g * h)
        total = method * (1.0 + (_ROOM / g) ** 2) + rounding + start + unsure**2
        return Leap(h, lead, method, rounding, start, total)

    def _reach(self, found: Singularity) -> float:
        """Time from a singular instant within which accelerations can be found by continuity."""
        return _TAYLOR / max(found.rate, found.speed)

    def _balanced(self, found: Singularity, g: float, usual: float) -> float:
        """Length of the step that errs least, not shorter than the usual one."""
        here = self._noise(found) / (g**3 * usual**2)
        return float(usual * max(1.0, (2.0 * here / self.order) ** (1.0 / (self.order + 2))))

    def _best(self, found: Singularity, usual: float) -> Leap:
        """The step across that errs least, wherever it begins."""
        leaps = []
        for a, b in self.gaps:
            g = 0.5 * (b - a)
            h = self._balanced(found, g, usual)
            leaps.append(self._leap(found, h, 0.5 * (a + b) * h, g, usual))
        return min(leaps, key=lambda leap: leap.total)

    def _from_here(self, found: Singularity, ahead: float, usual: float) -> Leap:
        """The step across that errs least among those that begin now."""
        leaps = []
        for a, b in self.gaps if ahead > 1e-9 * usual else ():
            h = ahead / (0.5 * (a + b))
            leaps.append(self._leap(found, h, ahead, 0.5 * (b - a), usual))
        # Just behind its beginning, or before it: then only the second node must be far away.
        second = self.gaps[0][1]
        h = self._balanced(found, second, usual)
        if ahead < 0.5 * second * h or not leaps:
            g = max(second - ahead / h, 0.5 * second)
            leaps.append(self._leap(found, h, ahead, g, usual))
        return min(leaps, key=lambda leap: leap.total)

    def _continued(self, motion: Motion, found: Singularity) -> bool:
        """Write the derivative at the start of the step, by continuity; false where there is none.

        The accelerations at four instants, before and behind the singular one, at states on the
        constraints that the motion passes; a cubic through them gives its own, and better states.
        """
        run, system, n = self.run, self.system, self.run.n
        p, modes = run.fixed_arrays[3], run.modes
        delta = self._reach(found)
        places = found.t - motion.t + delta * np.array([-2.0, -1.0, 1.0, 2.0])
        powers = np.vander(places, 4, increasing=True)
        series: FloatArray = np.zeros((4, n))
        lam = np.zeros(run.m)
        for _ in range(4):
            found_a = np.zeros((4, n))
            for place, a in zip(places, found_a, strict=True):
                factors = place ** np.arange(1, 5)
                v = motion.v + (factors / np.arange(1, 5)) @ series
                q = (
                    motion.q
                    + place * motion.v
                    + (factors * place / (np.arange(1, 5) * np.arange(2, 6))) @ series
                )
                t = motion.t + place
                if not self._projected(t, q, v):
                    return False
                system.accelerations(t, q, v, p, modes, a, lam)
            series = np.asarray(np.linalg.solve(powers, found_a), dtype=np.float64)
        if not np.isfinite(series).all():
            return False
        run.w.reshape(ROWS, 2, n)[K, 1] = series[0]
        return True

    def _projected(self, t: float, q: Vector, v: Vector) -> bool:
        """Bring q and v onto the constraints, least in the metric of the masses."""
        dq, dv, moved = np.zeros_like(q), np.zeros_like(v), np.inf
        for _ in range(8):
            self.system.correction(t, q, v, self.run.fixed_arrays[3], self.scale**2, dq, dv)
            q += dq
            v += dv
            if not np.isfinite(dq + dv).all():
                return False
            moved = float(np.abs(dq / self.scale).max())
            if moved < 1e-13:
                break
        return moved < 1e-10  # near a singular position rounding keeps it from less

    def _usual(self) -> float:
        """Length of a step here; after a step across that failed, less."""
        return float(max(self.r["usual"], self.r["h"])) * 0.5**self.tries

    def _rounding(self, q: Vector) -> float:
        """What a constraint misses by rounding alone."""
        return _ROUNDING * _EPS * self._size(q)

    def _size(self, q: Vector) -> float:
        return float(np.abs(q / self.scale).max(initial=1.0))

    def _motion(self) -> Motion:
        """How the machine moves from where the run stands; over a step just tried, where it was."""
        r, n = self.r, self.run.n
        rows = self.run.w.reshape(ROWS, 2, n)
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
