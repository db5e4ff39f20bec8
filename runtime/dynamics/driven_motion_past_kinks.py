"""A driven motion under laws that bend or jump at instants known beforehand."""

from itertools import pairwise

import numpy as np

from codegen.object_display import counted
from runtime.continuation.driven_motion import follow
from runtime.continuation.driven_motion_state import DrivenMotion
from runtime.core.outcomes import Outcome
from runtime.dynamics.prepared_simulation import passages_of
from runtime.explicit_time.instants import Kink
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
    passages = passages_of(equations, float(path.min()), float(path.max()), sizes)
    if passages is None:
        return follow(equations, times, start, preferred, progress), []
    ascending = bool((np.diff(path) >= 0.0).all())
    behind = passages.first_instant(start.q, start.v) if ascending else start.t
    if behind > start.t:
        times = np.maximum(times, behind)
        path = np.concatenate([[start.t], times])
        passages = Passages(equations, behind, float(path.max()), sizes)
    passed, ends = _kink_events_and_ends(passages, start, ascending)
    reached, end = _instants_before_end(path, ends)
    done = times[:reached]
    instants = done
    if ascending and reached:
        sides = [t for kink, _ in passed for t in kink[:2] if start.t <= t <= done[-1]]
        instants = np.union1d(done, sides)
    motion = follow(equations, instants if reached else path[:1], start, preferred, progress)
    rows = {float(t): row for row, t in enumerate(motion.t[: len(instants)])}
    found = []
    for kink, passage in passed:
        row = rows.get(kink.after)
        if row is not None and instants is not done:
            state = motion.q[row], motion.v[row]
            title = equations.description.time_functions[passage.source].title
            found.append(Event(title, kink.after, int(passage.event or 0), *state))
    return _of_instants(motion, times, done, instants, end), found


def _kink_events_and_ends(
    passages: Passages, start: Assembly, ascending: bool
) -> tuple[list[tuple[Kink, Passage]], list[tuple[float, Passage]]]:
    """The kinks that are events, and where laws end and how, each with its passage."""
    passed, ends = list[tuple[Kink, Passage]](), list[tuple[float, Passage]]()
    for part in passages.parts():
        for kink in part.kinks:
            g = passages.equations.switching(kink.before, start.q, start.v)
            state = start.q, start.v, (g > 0.0).astype(np.int64)
            passage, end = passages.passage(kink, *state), kink.before
            if kink.steep is not None:
                steep = passages.steep(kink, *state)
                if steep.outcome is not Outcome.OK:  # a run ends there first
                    passage, end = steep, kink.steep
            if passage.outcome is not Outcome.OK:
                ends.append((end, passage))
            elif passage.event is not None:
                passed.append((kink, passage))
        if part.crowd is not None:
            ends.append((part.crowd[0], passages.crowded(part)))
        if ends and ascending:
            break
    return passed, ends


def _instants_before_end(
    path: FloatArray, ends: list[tuple[float, Passage]]
) -> tuple[int, tuple[float, Passage] | None]:
    """How many instants are reached before a law ends, and where and how that is; None: all."""
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
    message = f"{counted(len(times), 'instant')} from t = {times[0]:g} to {times[-1]:g} s.{notes}"
    if end is None:
        return motion._replace(message=message)
    t, passage = end
    message = f"Stopped before t = {t:.9g} s. {passage.text}"
    return motion._replace(outcome=passage.outcome, message=message)
