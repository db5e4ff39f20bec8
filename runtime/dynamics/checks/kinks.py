"""Runs that end at a place where the equation of a joint or driver is not smooth.

The motion beyond is not known there: a velocity would have to jump, for which no impulse is known,
or a slope grows without bound. On the way in a run meets steps that fail in many ways.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from runtime.continuation.predictor_corrector import DrivenMotion
from runtime.core.outcomes import Outcome, Site
from runtime.integrate.problem import Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.assembled_state import Assembly

_CLOSE = 1e-6  # safety: of the run; nearer to a kink, the kink is why it ends
_WAYS_IN = {
    *(Outcome.SINGULAR, Outcome.CONTRADICTED, Outcome.STEP_TOO_SMALL, Outcome.NEWTON_FAILED),
    *(Outcome.NOT_FINITE, Outcome.DISCONTINUOUS, Outcome.INCONSISTENT, Outcome.ZENO),
}
_PLACES = {
    "root": "{} comes to 0, where its slope jumps",
    "steep": "{} comes to 0, where its slope has no bound",
    "end": "{} comes to an end of its range, where its slope has no bound",
    "cut": "{} comes to its cut, where it jumps by 2 pi",
    "origin": "both arguments of {} come to 0, where it has no value",
}
_ADVICE = {
    "cut": "Count turns: take the angles of bodies, rack_and_pinion, gear or belt in place of it",
}
_OTHER_ADVICE = "State the equation without it, squared or by an angle that passes this place"


_POINTS = 17  # measured: instants of a stretch in which a kink is looked for
_ROUNDS = 16  # safety: such stretches, each an eighth of the one before
_FLAT = 4.0  # safety: ratio of an argument beside its least value, from which on that is resolved
_VANISHED = 1e-13  # accuracy: of an argument; a smaller least value is 0
_MAY_VANISH = 0.05  # safety: the same by a cubic through both ends of a stretch


def nearest_kink(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> tuple[int, float]:
    """The kink of a constraint that a state is nearest to, and about the time to it, s; or -1."""
    kinks = _kinks(equations)
    if not kinks:
        return -1, np.inf
    u, rate = _arguments(equations, t, q, v)
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.nan_to_num(np.abs(u / rate), nan=np.inf)
    times[np.isnan(u) | (u == 0.0)] = 0.0
    return kinks[int(times.argmin())], float(times.min())


def end_at_kink(equations: Equations, run: Trajectory, duration: float) -> Trajectory:
    """The run, ended by a kink of a constraint where one is near; `duration`, s, is its whole."""
    if run.outcome not in _WAYS_IN:
        return run
    kink, time = nearest_kink(equations, *run.end)
    if not time <= _CLOSE * duration:
        return run
    elements = [row.element for row in equations.description.constraints]
    row = elements.index(equations.description.peaks[kink][0])
    outcome, note = _end(equations, kink, run.final_t)
    return replace(run, outcome=outcome, site=Site.KINK, index=row, note=note)


def end_motion_at_kink(
    equations: Equations, begin: Assembly, motion: DrivenMotion,
    through: Callable[[FloatArray], DrivenMotion],
) -> DrivenMotion:  # fmt: skip
    """The motion of drivers up to the first kink that it meets; `through` follows it again."""
    if not _kinks(equations):
        return motion
    states = [(begin.t, begin.q, begin.v), *zip(motion.t.tolist(), motion.q, motion.v, strict=True)]
    t = np.array([state[0] for state in states])
    seen = np.array([_arguments(equations, *state) for state in states])  # (states, 2, kinks)
    found = None
    for k, (u, rate) in enumerate(seen.transpose(2, 1, 0)):
        for i in np.flatnonzero(_may_vanish(u, rate, np.diff(t))).tolist():
            at = _instant(equations, k, t[i], t[i + 1], through)
            if at is not None and (found is None or i < found[0]):
                found = i, at, _kinks(equations)[k]
                break
    if found is None and motion.outcome is not Outcome.OK:
        kink, time = nearest_kink(equations, *states[-1])
        if time <= _CLOSE * float(np.ptp(t)):
            found = len(motion.t) - 1, float(t[-1]), kink
    if found is None:
        return motion
    kept, at, kink = found
    outcome, note = _end(equations, kink, at)
    return motion._replace(
        t=motion.t[:kept], q=motion.q[:kept], v=motion.v[:kept], outcome=outcome,
        message=f"Stopped before t = {at:.9g} s. {note}",
    )  # fmt: skip


def _may_vanish(u: FloatArray, rate: FloatArray, h: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether an argument comes near to 0 within each stretch, by a cubic through its ends."""
    x = np.linspace(0.0, 1.0, _POINTS)[:, None]
    a, b, leave, arrive = u[:-1], u[1:], h * rate[:-1], h * rate[1:]
    least = (
        a + x**2 * (3 - 2 * x) * (b - a) + x * (1 - x) ** 2 * leave + x**2 * (x - 1) * arrive
    ).min(axis=0)
    dips: npt.NDArray[np.bool_] = least <= _MAY_VANISH * np.maximum(a, b)
    return dips


def _instant(
    equations: Equations, k: int, begin: float, end: float,
    through: Callable[[FloatArray], DrivenMotion],
) -> float | None:  # fmt: skip
    """When an argument vanishes between two instants, s; None where it does not."""
    largest = 0.0
    for _ in range(_ROUNDS):
        times = np.linspace(begin, end, _POINTS)
        part = through(times)
        if len(part.t) < len(times) or part.outcome is not Outcome.OK:
            return float(part.t[-1])
        states = zip(part.t.tolist(), part.q, part.v, strict=True)
        u = np.array([_arguments(equations, *state)[0][k] for state in states])
        largest, i = max(largest, float(u.max())), int(u.argmin())
        low, high = max(i - 1, 0), min(i + 1, _POINTS - 1)
        if u[i] <= _VANISHED * largest:
            return float(times[i])
        if max(u[low], u[high]) <= _FLAT * u[i]:
            return None
        begin, end = times[low], times[high]
    return None


def _kinks(equations: Equations) -> list[int]:
    """Numbers of the kinks among the peaks."""
    return [k for k, row in enumerate(equations.description.peaks) if row[1] == "kink"]


def _arguments(
    equations: Equations, t: float, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What vanishes at each kink, and its rate."""
    u, rate = np.zeros((2, len(equations.description.peaks)))
    modes = np.zeros(len(equations.description.switches), np.int64)
    equations.kernels.peak_arguments(t, q, v, equations.p, modes, u, rate)
    kinks = _kinks(equations)
    return u[kinks], rate[kinks]


def _end(equations: Equations, kink: int, t: float) -> tuple[Outcome, str]:
    """How a motion ends at a kink, and sentences on it."""
    description = equations.description
    element, _, _, kind, function = description.peaks[kink]
    word = "driver" if element in description.drivers else "joint"
    note = (
        f"In {word} '{element}' {_PLACES[kind].format(function)}, at t = {t:.9g} s: no motion "
        f"through this place is known. {_ADVICE.get(kind, _OTHER_ADVICE)}; or end the run before."
    )
    return Outcome.NOT_FINITE if kind in ("steep", "end") else Outcome.DISCONTINUOUS, note
