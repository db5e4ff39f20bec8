"""What the runs say: times at an accuracy, the front, and sentences; all from the runs alone."""

import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from runtime.studies.work_precision.diagram import Choice, Line, Point, Setting, WorkPrecision

TARGETS = (1e-3, 1e-6, 1e-9)
"""Scaled errors at which times are told; the first is what the IFToMM benchmarks call precise."""
NOISY = 1.3
"""Spread from which on a time is doubtful."""
LONG = 160
"""Characters of a reason on a screen; what is longer ends at a word, and stands in the records."""


class Best(NamedTuple):
    """The fastest line at an accuracy, and its time, s."""

    seconds: float
    line: Line


def digits(error: float) -> str:
    """1e-6 → "6"."""
    return f"{-math.log10(error):.3g}"


def time_at(line: Line, error: float) -> float | None:
    """Time in s at which a line reaches a scaled error, None where it does not.

    On the straight line between two runs in logarithms, where the first to reach it comes after one
    that does not; of the run itself where it is the loosest. A tighter run that is faster reaches
    it as well, so that no accuracy takes longer than a better one.
    """
    found = _first_time(line, error)
    if found is None:
        return None
    better = (p.seconds for p in line.done if p.errors and p.errors.worst <= error)
    return min(found, *better)


def _first_time(line: Line, error: float) -> float | None:
    """That of the first to reach it, or on the way to it."""
    before: Point | None = None
    for point in line.done:
        assert point.errors is not None
        if point.errors.worst <= error:
            if before is None or before.errors is None or math.isinf(before.errors.worst):
                return point.seconds
            far, near = math.log(before.errors.worst), math.log(max(point.errors.worst, 1e-17))
            share = (far - math.log(error)) / (far - near)
            slow, fast = math.log(point.seconds), math.log(before.seconds)
            return math.exp(fast + share * (slow - fast))
        before = point
    return None


def best_at(told: WorkPrecision, error: float) -> Best | None:
    """The fastest line at an accuracy that the reference can tell."""
    if error < told.reference.floor:
        return None
    found = [(time_at(line, error), k) for k, line in enumerate(told.lines)]
    times = [(seconds, k) for seconds, k in found if seconds is not None]
    if not times:
        return None
    seconds, k = min(times)
    return Best(seconds, told.lines[k])


def front(lines: Sequence[Line]) -> list[tuple[Setting, Point]]:
    """The Pareto front: the runs than which none is both faster and more accurate, fastest first.

    Runs beyond what the reference is known to are none of it, but for the fastest.
    """
    runs = [(line.setting, point) for line in lines for point in line.done]
    found: list[tuple[Setting, Point]] = []
    least = math.inf
    for setting, point in sorted(runs, key=lambda run: run[1].seconds):
        assert point.errors is not None
        if point.errors.worst < least:
            found.append((setting, point))
            least = point.errors.worst
        if point.beyond:
            break
    return found


def slope(line: Line) -> float | None:
    """d log E / d log rtol over the runs whose error is known: 1 where errors follow tolerances."""
    runs = [(p.rtol, p.errors.worst) for p in line.known if p.errors and p.errors.worst < 0.1]
    if len(runs) < 2:
        return None
    rtols, worst = np.log(np.array(runs)).T
    return float(np.polyfit(rtols, worst, 1)[0])


def effectivity(line: Line) -> float | None:
    """Median of E over rtol: by how much a run's error exceeds what its steps are held to."""
    ratios = [p.errors.worst / p.rtol for p in line.known if p.errors]
    return float(np.median(ratios)) if ratios else None


def sentences(told: WorkPrecision, *, whole: bool = False) -> Iterator[str]:
    """What the picture shows, a line each, the most important first; reasons short or whole."""
    most = math.inf if whole else LONG
    yield headline(told)
    yield from _methods(told)
    yield from _corrections(told)
    yield from _formulations(told)
    yield from _choices(told, most)
    yield from _reference(told)
    yield from _failures(told, most)
    yield from _times(told)


def headline(told: WorkPrecision) -> str:
    """What three more digits cost."""
    reached = [(target, best) for target in TARGETS if (best := best_at(told, target))]
    if len(reached) < 2:
        runs = front(told.lines)
        most = max((point.digits for _, point in runs), default=0.0)
        return f"No run has more than {most:.1f} digits, of which the reference can tell."
    (loose, fast), (tight, slow) = reached[-2:]
    more = "three" if round(math.log10(loose / tight)) == 3 else digits(tight / loose)
    return (
        f"{more.capitalize()} more digits, {digits(tight)} in place of {digits(loose)}, cost "
        f"{slow.seconds / fast.seconds:.2g} times the time: {milliseconds(fast.seconds)}"
        f"{'' if slow.line is fast.line else f' ({fast.line.setting.title})'} become "
        f"{milliseconds(slow.seconds)} ({slow.line.setting.title})."
    )


def milliseconds(seconds: float) -> str:
    """A time with its unit."""
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


def _target(told: WorkPrecision) -> float | None:
    """The accuracy at which settings are compared: six digits, or three."""
    return next((target for target in (1e-6, 1e-3) if best_at(told, target)), None)


def _methods(told: WorkPrecision) -> Iterator[str]:
    target = _target(told)
    if target is None:
        return
    times = sorted(
        (seconds, line.setting.title)
        for line in told.lines
        if line.setting.correction == "step" and (seconds := time_at(line, target)) is not None
    )
    if len(times) > 1:
        (least, first), (most, last) = times[0], times[-1]
        yield (
            f"At {digits(target)} digits {first} takes {milliseconds(least)}, {last} "
            f"{most / least:.3g} times as long."
        )


def _corrections(told: WorkPrecision) -> Iterator[str]:
    target, base = _target(told), Setting("dop853")
    for way, name in (("stage", "at every stage"), ("projection", "by projection")):
        ratio = _ratio(told, base._replace(correction=way), base, target)
        if ratio is not None and target is not None:
            yield (
                f"Correction {name} takes {ratio:.2f} times the time of correction once a step at "
                f"{digits(target)} digits ({base.title})."
            )


def _formulations(told: WorkPrecision) -> Iterator[str]:
    target, base = _target(told), Setting("dop853")
    other = base._replace(formulation="reduced")
    ratio = _ratio(told, other, base, target)
    if ratio is not None and target is not None:
        yield (
            f"{other.title} takes {ratio:.2f} times the time of {base.title} at {digits(target)} "
            "digits."
        )


def _ratio(told: WorkPrecision, this: Setting, that: Setting, target: float | None) -> float | None:
    """Time of one setting over that of another at an accuracy; None where one has none."""
    of = {line.setting: line for line in told.lines}
    if target is None or this not in of or that not in of:
        return None
    over, under = time_at(of[this], target), time_at(of[that], target)
    return None if over is None or under is None else over / under


def _choices(told: WorkPrecision, most: float) -> Iterator[str]:
    for choice in told.choices:
        yield _choice(told, choice, most)


def _choice(told: WorkPrecision, choice: Choice, most: float) -> str:
    """What a modelling choice costs in accuracy, and in time beside the scene as it is declared."""
    point = choice.point
    if point is None or point.errors is None or choice.setting is None:
        return f"{choice.title}: not run. {_short(choice.reason, most)}"
    error = point.errors.worst
    if point.beyond:
        kept = "all digits that the reference is known to"
    else:
        kept = f"{max(point.digits, 0.0):.1f} digits, however tight the tolerance"
    full = best_at(told, max(min(error, 0.1), told.reference.floor))
    beside = ""
    if full is not None:
        beside = f"; the scene as declared has as many after {milliseconds(full.seconds)}"
    return f"{choice.title} keeps {kept}, after {milliseconds(point.seconds)}{beside}."


def _reference(told: WorkPrecision) -> Iterator[str]:
    reference = told.reference
    checks = ", ".join(
        f"{check.title} differs by {check.error:.1e}"
        for check in reference.checks
        if check.error is not None
    )
    kind = "is given" if reference.independent else "is a run, and no independent one"
    yield (
        f"The reference, {reference.source}, {kind}: {checks}. Errors below "
        f"{reference.floor:.1e} cannot be told."
    )
    if reference.horizon is not None:
        yield (
            f"From t = {reference.horizon:.4g} s on the reference is known to less than six "
            "digits: the motion is too sensitive to be followed for longer, or the reference is "
            "that of another machine. End the run earlier, or compare what is less sensitive."
        )


def _failures(told: WorkPrecision, most: float) -> Iterator[str]:
    reasons: dict[str, list[str]] = {}
    for line in told.lines:
        if line.refused:
            reasons.setdefault(line.refused, []).append(line.setting.title)
        if line.failed:
            outcomes = ", ".join(dict.fromkeys(point.outcome for point in line.failed))
            count = f"{len(line.failed)} of {len(line.points)} runs did not reach the end"
            why = _short(line.failed[0].message, most)
            yield f"{line.setting.title}: {count}: {outcomes}. {why}"
    for reason, titles in reasons.items():
        yield f"Not tried: {'; '.join(titles)}. {_short(reason, most)}"


def _times(told: WorkPrecision) -> Iterator[str]:
    noisy = sum(p.spread > NOISY for line in told.lines for p in line.done)
    runs = sum(len(line.done) for line in told.lines)
    if noisy:
        yield (
            f"Times of {noisy} of {runs} runs spread by more than {NOISY:g} (median over least): "
            "others use the machine; the least counts."
        )
    if told.build:
        parts = ", ".join(f"{stage} {seconds:.2g}" for stage, seconds in told.build.items())
        yield f"Built once, apart from all runs, in s: {parts}."


def _short(text: str, most: float) -> str:
    return text if len(text) <= most else textwrap.shorten(text, int(most), placeholder=" …")
