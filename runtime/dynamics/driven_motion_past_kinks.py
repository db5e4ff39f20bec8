"""A driven motion under laws that bend or jump at instants known beforehand."""

from itertools import pairwise

import numpy as np

from runtime.continuation.driven_motion import follow
from runtime.continuation.driven_motion_state import DrivenMotion
from runtime.core.outcomes import Outcome
from runtime.dynamics.prepared_simulation import passages_of
from runtime.explicit_time.passage import Passages
from runtime.integrate.problem import Passage
from runtime.mechanism.dense_equations import Equations, FloatArray, magnitudes
from runtime.progress_bar import Progress
from runtime.results.assembled_state import Assembly
from runtime.results.event_records import Event


def follow_past_kinks(
    equations: Equations, times: FloatArray, start: Assembly, preferred: FloatArray,
    progress: Progress,
) -> tuple[DrivenMotion, list[Event]]:  # fmt: skip
    """The motion of `follow`, up to where a law has no value or jumps, and the events of laws."""
    sizes = magnitudes(equations, start.t, start.q)
    path = np.concatenate([[start.t], times])
    passages = passages_of(equations, start, float(path.max()), sizes, float(path.min()))
    if passages is None:
        return follow(equations, times, start, preferred, progress), []
    modes = np.zeros(len(equations.description.switches), np.int64)
    kinks = passages.instants.kinks
    passed = [passages.passage(k, start.q, start.v, modes) for k in range(len(kinks))]
    reached, end = _reached(path, passages, passed)
    done = times[:reached]
    events = [k for k, passage in enumerate(passed) if passage.event is not None]
    instants = done
    if (np.diff(path) >= 0.0).all() and reached:
        sides = [t for k in events for t in kinks[k][:2] if start.t <= t <= done[-1]]
        instants = np.union1d(done, sides)
    motion = follow(equations, instants if reached else path[:1], start, preferred, progress)
    rows = {float(t): row for row, t in enumerate(motion.t[: len(instants)])}
    found = []
    for k in events:
        row = rows.get(kinks[k].after)
        if row is not None and instants is not done:
            state = motion.q[row], motion.v[row]
            found.append(Event(kinks[k].title, kinks[k].after, int(passed[k].event or 0), *state))
    return _of_instants(motion, times, done, instants, end), found


def _reached(
    path: FloatArray, passages: Passages, passed: list[Passage]
) -> tuple[int, tuple[float, Passage] | None]:
    """How many instants are reached before a law ends, and where and how that is; None: all."""
    instants = passages.instants
    ends = [
        (kink.before, passage)
        for kink, passage in zip(instants.kinks, passed, strict=True)
        if passage.outcome is not Outcome.OK
    ]
    if instants.crowd is not None:
        none = np.zeros(0, np.int64)
        last = passages.passage(len(instants.kinks), *passages.start, none)
        ends.append((instants.crowd[0], last))
    for reached, (a, b) in enumerate(pairwise(path.tolist())):
        within = [end for end in ends if min(a, b) <= end[0] < max(a, b)]
        if within:
            return reached, min(within, key=lambda end: abs(end[0] - a))
    return len(path) - 1, None


def _of_instants(
    motion: DrivenMotion, times: FloatArray, done: FloatArray, instants: FloatArray,
    end: tuple[float, Passage] | None,
) -> DrivenMotion:  # fmt: skip
    """The motion at the instants that were asked for, its outcome that of a law that ends it."""
    if instants is not done:  # ascending
        wanted = done[done <= motion.t[-1]]
        rows = np.searchsorted(motion.t, wanted)
        if motion.outcome is not Outcome.OK and not (len(rows) and rows[-1] == len(motion.t) - 1):
            rows = np.append(rows, len(motion.t) - 1)
        motion = motion._replace(t=motion.t[rows], q=motion.q[rows], v=motion.v[rows])
    if motion.outcome is not Outcome.OK:
        return motion
    _, _, notes = motion.message.partition(" s.")
    message = f"{len(times)} instants from t = {times[0]:g} to {times[-1]:g} s.{notes}"
    if end is None:
        return motion._replace(message=message)
    t, (outcome, _, note, *_) = end
    message = f"Stopped before t = {t:.9g} s. {outcome.meaning} {note} {outcome.advice}"
    return motion._replace(outcome=outcome, message=message)
