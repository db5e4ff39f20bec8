"""A result at other instants: between its samples, on a side of an event, or at some samples."""

import sys
from copy import copy
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.readers.quantities import each_in_unit
from codegen.readers.values import shown
from runtime.core.arrays import EPS
from runtime.results.assembled_state import DiscreteState, State
from runtime.results.samples import FloatArray, Samples, undefined_outputs

if TYPE_CHECKING:
    from runtime.results.result import Result

Side = Literal["before", "after"]

# accuracy: units of rounding of a run's times; the two sides of a kink are 32 of them apart
_CLOSE = 40.0
_SHOWN = 6  # layout: instants that a message names
_NARROW = 1e-9  # accuracy: of a run's time, the interval in which a mode is known to change
_FLIPS = 3  # safety: changes of modes within an interval of samples that are looked for


class Sampling(NamedTuple):
    """How densely curves are sampled."""

    a_step: int = 4  # layout: points of a curve in a step of the run
    least: int = 1000  # layout: points of a short curve
    most: int = 8000  # layout: points of a long curve
    events: int = 8000  # layout: events of which both sides are drawn
    patience: float = 1.0  # measured: s of integration that a picture takes once more


class Motion(Protocol):
    """What a result asks for its motion at other instants than its own; by default drivers'."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant, s."""

    @property
    def t_end(self) -> float:
        """The end that was asked for, s, which a run may not have reached."""
        return self.span[1]

    @property
    def behind(self) -> float:
        """Where a motion that begins on a kink is sampled first, s, just behind that; else -inf."""
        return -np.inf

    def scene(self, t: float) -> str:
        """The scene whose joints act at an instant of the span, s."""

    def clocks(self, result: Any, t: float) -> tuple[bool, DiscreteState | None]:
        """Where clocks and watched conditions stand at an instant of the span, s.

        The first says whether clocks have renewed what is due in the state there.
        """
        return False, None

    def at(self, result: Any, times: FloatArray) -> tuple[Samples, dict[str, FloatArray]]:
        """Samples, and works by name, at ascending instants, (k,), s."""

    def saved(self) -> dict[str, Any]:
        """What a file keeps of it, as `pack` takes it."""

    def resumed(
        self, result: Any, t_end: Any, t_eval: Any, max_steps: int | None, progress: bool
    ) -> Any:
        """The result of going on to another end, see `Result.resume`; None where none goes on."""
        return None


def at(result: "Result", t: Any, side: Any) -> "Result":
    """See `Result.at`."""
    title, motion = result.description.title, result._motion
    if motion is None:
        raise InputError(
            f"{title}: at() needs the motion behind the result, and this is one of "
            f"{result.analysis}. Ask a result of simulate, kinematics or inverse_dynamics."
        )
    if side is not None and not (isinstance(side, str) and side in ("before", "after")):
        raise InputError(f'{title}: side is {shown(side)}; it must be "before" or "after".')
    times, (first, last) = _instants(title, t), _span(result, motion)
    outside = times[(times < first) | (times > last)]
    if len(outside):
        named = ", ".join(f"{x:.9g}" for x in outside[:_SHOWN])
        more = f" and {len(outside) - _SHOWN} more" if len(outside) > _SHOWN else ""
        advice = "Ask within, or simulate for longer."
        if result.ended_by and outside.max() > last:
            advice = f"'{result.ended_by}' ended it there: ask within, or `resume` it past that."
        raise InputError(
            f"{title}: t = {named}{more} s lies outside of the result, which goes from "
            f"t = {first:.9g} to {last:.9g} s. {advice}"
        )
    return _sampled(result, motion, times, _on_side(result, motion, times, side))


def for_curves(result: "Result") -> "Result":
    """A result with so many instants that its curves look smooth, and both sides of its events."""
    return resampled(result, Sampling())


def resampled(result: "Result", how: Sampling, besides: FloatArray | None = None) -> "Result":
    """A result with evenly spaced instants, its own ones, both sides of its events, and `besides`.

    Where the run took long it is the result itself, since its motion takes as long again.
    """
    motion, stats, count = result._motion, result.stats, len(result.t)
    if motion is None or count < 2 or stats.get("integration_seconds", 0.0) > how.patience:
        return result
    first, last = float(result.t.min()), float(result.t.max())
    points = int(np.clip(how.a_step * stats.get("steps", 0), how.least, how.most)) + 1
    events = np.unique([event.time for event in result.events if first < event.time <= last])
    events = events[: 0 if len(events) > how.events else None]
    own = result.t if count <= how.most else result.t[:0]
    between = np.union1d(np.linspace(first, last, points), own)
    if besides is not None:
        between = np.union1d(between, besides)
    sides = [_on_side(result, motion, events, side) for side in ("before", "after")]
    moved = np.concatenate([between, *sides])
    order = np.argsort(moved, kind="stable")
    times = np.concatenate([between, events, events])[order]
    return _sampled(result, motion, times, moved[order])


def thinned(result: "Result", most: int) -> "Result":
    """A result with no more than so many of its instants, the first and the last among them."""
    count = len(result.t)
    rows = np.linspace(0, count - 1, min(count, most)).round().astype(int)
    found = copy(result)
    found.samples, found._moved = result.samples.at(rows), result.instants_of_states[rows]
    found.works = {name: work[rows] for name, work in result.works.items()}
    return found


def with_both_sides(result: "Result") -> "Result":
    """A result with both sides of events, and of modes that change without in driven motions."""
    motion, t, found = result._motion, result.instants_of_states, result
    if motion is None or len(t) < 2:
        return result
    changes = [one.time for one in result.reconnections if t[0] <= one.time < t[-1]]
    besides, most = np.array([*changes, *np.nextafter(changes, np.inf)]), len(t)
    while result.analysis != "simulation":
        (k,) = np.nonzero(np.diff(found.samples.modes, axis=0).any(axis=1))
        besides = np.concatenate([t[k], t[k + 1]])
        if not _NARROW * np.abs(t).max() < np.max(t[k + 1] - t[k], initial=0.0) or len(k) > most:
            break
        most = _FLIPS * len(k)  # more change by rounding
        t = np.unique(np.linspace(t[k], t[k + 1], 10))
        found = _sampled(result, motion, t, t)
    if not len(besides) and not result.events:
        return result
    every = Sampling(a_step=0, least=0, most=sys.maxsize, events=sys.maxsize, patience=np.inf)
    return resampled(result, every, besides)


def _sampled(result: "Result", motion: Motion, times: FloatArray, moved: FloatArray) -> "Result":
    """The result with other instants, (k,) s; its motion is taken where they are moved to."""
    unique, place = np.unique(np.clip(moved, *_span(result, motion)), return_inverse=True)
    samples, works = _taken(result, motion, unique)
    found = copy(result)
    found.samples, found._moved = samples.at(place)._replace(t=times), unique[place]
    found._chosen = True
    before, after = (undefined_outputs(x.description, x.samples) for x in (result, found))
    found.message = result.message.replace(before, "") + after
    found.works = {name: work[place] for name, work in works.items()}
    return found


def _taken(
    result: "Result", motion: Motion, times: FloatArray
) -> tuple[Samples, dict[str, FloatArray]]:
    """At ascending instants; that at which an analysis failed is the last sample itself."""
    known = int(result.failed and len(result.t) > 0 and times[-1] == result.t[-1])
    asked = times[: len(times) - known]
    pieces = [motion.at(result, asked)] if len(asked) else []
    if known:
        works = {name: work[-1:] for name, work in result.works.items()}
        pieces.append((result.samples.at(slice(-1, None)), works))
    samples = Samples.joined([samples for samples, _ in pieces])
    return samples, {n: np.concatenate([works[n] for _, works in pieces]) for n in result.works}


def _span(result: "Result", motion: Motion) -> tuple[float, float]:
    """First and last instant, s; of an analysis that failed the last sample is the last."""
    first, last = motion.span
    return first, float(result.t[-1]) if result.failed and len(result.t) else last


def finite_numbers(given: Any, unit: str = "") -> FloatArray | None:
    """Numbers, quantities or texts in a unit, (k,); None where any is none or not finite."""
    try:
        found = np.asarray(None if np.ma.is_masked(given) else each_in_unit(given, unit))
    except Exception:  # of an array of another library as well
        return None
    fits = found.dtype.kind in "iuf" and found.ndim < 2 and found.size > 0
    return np.atleast_1d(found.astype(float)) if fits and np.isfinite(found).all() else None


def _instants(title: str, t: Any) -> FloatArray:
    """Finite instants in any order, (k,)."""
    found = finite_numbers(t, "s")
    if found is None:
        raise InputError(
            f"{title}: t is {shown(t)}; it must be an instant in s, or some of them in one "
            "dimension, all finite numbers."
        )
    return found


def _on_side(result: "Result", motion: Motion, times: FloatArray, side: str | None) -> FloatArray:
    """Instants, those of events moved to the side that is asked for, s."""
    if side is None or not result.events:
        return times
    of_time = {function.title for function in result.description.time_functions}
    moved, width = times.copy(), _CLOSE * EPS * max(map(abs, (*motion.span, motion.t_end)))
    exact = np.isin(times, [event.time for event in result.events])
    for event in result.events if side == "after" else reversed(result.events):
        reach = width if event.name in of_time else 0.0
        here = np.abs(times - event.time) <= np.where(exact, reach, width)
        if side == "after":
            moved[here] = np.nextafter(event.time, np.inf)
        else:
            moved[here] = event.time - reach
    return moved


def state(result: "Result", t: float | None, side: Side | None) -> State:
    """See `Result.state`."""
    title, motion = result.description.title, result._motion
    if t is None and motion is not None and not result._chosen:
        end = _span(result, motion)[1]
        t = end if not len(result.t) or result.t[-1] != end else None
    if t is not None:
        times = _instants(title, t)
        if len(times) != 1:
            raise InputError(f"{title}: a state is that of one instant; t has {len(times)}.")
        result = at(result, t, side)
    elif not len(result.t):
        raise InputError(f"{title}: the result has no sample, and no state to start from.")
    q, v, now = result.samples.q[-1].copy(), result.samples.v[-1].copy(), float(result.t[-1])
    if motion is None:
        return State(now, q, v, result.description.coordinates, scene=result.description.scene)
    clocks, scene = motion.clocks(result, now), motion.scene(now)
    return State(now, q, v, result.description.coordinates, *clocks, scene)


def keep(result: "Result", rows: npt.NDArray[np.bool_], first: float, last: float) -> None:
    """Keep these rows, (k,), and what happened behind `first` and up to `last`, s.

    Of the partitions the one in force at `first` is kept from there on.
    """
    result.samples = result.samples.at(rows)
    result.works = {name: work[rows] for name, work in result.works.items()}

    def within(rows: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(row for row in rows if first < row.time <= last)

    result.events, result.singular = within(result.events), within(result.singular)
    # those at `first` are of this result: an earlier one that ended there has not told them
    result.reconnections = tuple(one for one in result.reconnections if one.time <= last)
    sets = [one for one in result.partitions if one.time <= last]
    before = [one._replace(time=first) for one in sets if one.time <= first][-1:]
    result.partitions = (*before, *(one for one in sets if one.time > first))


def end_after(result: "Result", count: int) -> None:
    """Let a result end at one of its instants, behind which it is not what was asked for."""
    last = float(result.t[count - 1])
    keep(result, np.arange(len(result.t)) < count, -np.inf, last)
    result.ended_by = ""
