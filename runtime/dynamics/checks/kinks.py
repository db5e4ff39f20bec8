"""Runs that end at a place where the equation of a joint or driver is not smooth.

The motion beyond is not known there: a velocity would have to jump, for which no impulse is known,
or a slope grows without bound. On the way in a run meets steps that fail in many ways.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from runtime.continuation.driven_motion import DrivenMotion
from runtime.continuation.predictor_corrector import STEEP
from runtime.core.outcomes import Outcome, Site
from runtime.integrate.problem import Trajectory
from runtime.mechanism.dense_equations import Equations, FloatArray, row_lengths
from runtime.results.assembled_state import Assembly

_CLOSE = 1e-6  # safety: of the run; a kink that is nearer to the end is its cause
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
    "quotient": "the quotient in {} comes to a pole, where it jumps",
    "pole": "a slope grows without bound, as at a pole of a tangent, a quotient or a logarithm",
    "jump": "a slope jumps, as where two points meet and their distance comes to 0",
}
_ADVICE = {
    "jump": "Drive a coordinate, or keep the distance above 0",
    "pole": "Multiply the equation by what comes to 0 there",
    "quotient": "Take atan2 in place of atan, or multiply the equation by what comes to 0 there",
    "cut": "Count turns: take the angles of bodies, rack_and_pinion, gear or belt in place of it",
}
_STEEP = "steep", "end", "pole"
_OTHER_ADVICE = "State the equation without it, squared or by an angle that passes this place"

Kink = tuple[str, str, str]  # element, kind of place, function there

_NEARBY = 1e-5  # safety: scaled motion over which a slope changes much at a kink only
_TURNED = 0.5  # safety: change of a slope over this motion, in parts of the slope, that is a jump
_LOOKED = 200  # measured: least number of instants of a motion between which kinks are sought
_POINTS = 17  # measured: instants of a stretch in which a kink is looked for
_ROUNDS = 16  # safety: number of such stretches, each an eighth of the one before
_FLAT = 4.0  # safety: ratio of an argument near its least value to it, at which this is resolved
_VANISHED = 1e-13  # accuracy: of an argument; a smaller least value is 0
_MAY_VANISH = 0.05  # safety: the same by a cubic through both ends of a stretch


def end_at_kink(
    equations: Equations, begin: Assembly, run: Trajectory, duration: float
) -> Trajectory:
    """The run, ended by a kink of a constraint where one is near; `duration`, s, is its whole."""
    cause = _cause(equations, begin, *run.end, duration) if run.outcome in _WAYS_IN else None
    if cause is None:
        return run
    elements = [row.element for row in equations.description.constraints]
    outcome, note = _end(equations, cause, run.final_t)
    return run._replace(outcome=outcome, site=Site.KINK, index=elements.index(cause[0]), note=note)


def _cause(
    equations: Equations, begin: Assembly, t: float, q: FloatArray, v: FloatArray, duration: float
) -> Kink | None:
    """The kink that a motion has come to, of those watched, or else by the slopes about it."""
    if kinks := _kinks(equations):
        u, rate = _arguments(equations, t, q, v)
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.nan_to_num(np.abs(u / rate), nan=np.inf)
        times[np.isnan(u) | (u == 0.0)] = 0.0
        if times.min() <= _CLOSE * duration:
            return kinks[int(times.argmin())]
    elements = [row.element for row in equations.description.constraints]
    if not elements:
        return None
    slopes = [equations.jacobian(*state) for state in ((begin.t, begin.q), (t, q))]
    before, here = map(row_lengths, slopes)
    if (here >= STEEP * before).any():
        return elements[int((here / before).argmax())], "pole", ""
    speed = float(np.abs(v / equations.scale(equations.size(begin.t, begin.q))).max())
    step = min(_CLOSE * duration, _NEARBY / max(speed, 1e-300))
    sides = [equations.jacobian(t, q + h * v) for h in (-step, step)]
    turned = np.linalg.norm(sides[1] - sides[0], axis=1)
    share = turned / np.maximum(before, here)  # a row that vanishes smoothly turns about, and is 0
    row = int(share.argmax())
    return (elements[row], "jump", "") if share[row] > _TURNED else None


def end_motion_at_kink(
    equations: Equations, begin: Assembly, motion: DrivenMotion,
    through: Callable[[FloatArray], DrivenMotion],
) -> DrivenMotion:  # fmt: skip
    """The motion of drivers up to the first kink that it meets; `through` follows it again."""
    kinks = _kinks(equations)
    if not kinks and motion.outcome is Outcome.OK:
        return motion
    seen = motion
    if kinks and len(motion.t) < _LOOKED and (np.diff([begin.t, *motion.t]) >= 0.0).all():
        seen = through(np.union1d(motion.t, np.linspace(begin.t, motion.t[-1], _LOOKED)))
        seen = seen if seen.outcome is Outcome.OK else motion
    states = [(begin.t, begin.q, begin.v), *zip(seen.t.tolist(), seen.q, seen.v, strict=True)]
    t = np.array([state[0] for state in states])
    arguments = np.array([_arguments(equations, *state) for state in states])  # (…, 2, kinks)
    found = None
    for k, (u, rate) in enumerate(arguments.transpose(2, 1, 0)):
        for i in np.flatnonzero(_may_vanish(u, rate, np.diff(t))).tolist():
            at = _instant(equations, k, t[i], t[i + 1], through)
            if at is not None and (found is None or i < found[0]):
                found = i, at, kinks[k]
                break
    if found is None and motion.outcome is not Outcome.OK:
        cause, away = _cause(equations, begin, *states[-1], float(np.ptp(t))), np.abs(t[1:] - t[-1])
        found = cause and (int((away > _CLOSE * np.ptp(t)).sum()), float(t[-1]), cause)
    if found is None:
        return motion
    kept, at, cause = found
    kept = kept if seen is motion else int((motion.t <= t[kept]).sum())
    outcome, note = _end(equations, cause, at)
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


def _kinks(equations: Equations) -> list[Kink]:
    """The kinks that are watched."""
    return [(row[0], *row[3:]) for row in equations.description.peaks if row[1] == "kink"]


def _arguments(
    equations: Equations, t: float, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What vanishes at each kink, and its rate."""
    u, rate = np.zeros((2, len(equations.description.peaks)))
    modes = np.zeros(len(equations.description.switches), np.int64)
    equations.kernels.peak_arguments(t, q, v, equations.p, modes, u, rate)
    kinks = [k for k, row in enumerate(equations.description.peaks) if row[1] == "kink"]
    return u[kinks], rate[kinks]


def _end(equations: Equations, cause: Kink, t: float) -> tuple[Outcome, str]:
    """How a motion ends at a kink, and sentences on it."""
    element, kind, function = cause
    word = "driver" if element in equations.description.drivers else "joint"
    note = (
        f"In {word} '{element}' {_PLACES[kind].format(function)}, at t = {t:.9g} s: no motion "
        f"through this place is known. {_ADVICE.get(kind, _OTHER_ADVICE)}; or keep away from it."
    )
    return Outcome.NOT_FINITE if kind in _STEEP else Outcome.DISCONTINUOUS, note


def kink_at_rest(equations: Equations, start: Assembly, end: FloatArray) -> str:
    """Sentences on the kink at which a search for rest has ended; empty where there is none."""
    cause = _cause(equations, start, start.t, end, end - start.q, 1.0)
    return "" if cause is None else _end(equations, cause, start.t)[1]
