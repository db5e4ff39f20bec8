"""Conclusions from runs: times at an accuracy, Pareto front, sentences, tables, JSON records."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from codegen.presentation import milliseconds, new_table, shortened
from runtime.results.samples import plain
from runtime.studies.diagram import Choice, Line, Point, WorkPrecision
from runtime.studies.harness import Setting
from runtime.studies.timing import time_to_error

if TYPE_CHECKING:
    from rich.table import Table

# Scaled errors at which times are given; the IFToMM benchmarks call the first precise.
TARGETS = (1e-3, 1e-6, 1e-9)
COMPARED = 1e-6  # scaled error at which the work of runs is compared
NOISY = 1.3  # spread from which on a time is doubtful
LONG = 160  # characters of a reason on a screen; a longer one is cut there, not in the records


class Best(NamedTuple):
    """The fastest line at an accuracy, and its time, s."""

    seconds: float
    line: Line


def digits(error: float) -> str:
    """1e-6 → "6"."""
    return f"{-math.log10(error):.3g}"


def time_at(line: Line, error: float) -> float | None:
    """Time in s in which a line reaches a scaled error, as a tighter, faster run does too."""
    points = [(point.worst, point.seconds) for point in line.done]
    seconds = time_to_error(points, error)
    if seconds is None:
        return None
    return min(seconds, *(time for worst, time in points if worst <= error))


def fastest(lines: Sequence[Line], error: float) -> Best | None:
    """The fastest line at an accuracy."""
    times = ((time_at(line, error), line) for line in lines)
    reached = [Best(seconds, line) for seconds, line in times if seconds is not None]
    return min(reached, key=lambda best: best.seconds, default=None)


def best_at(study: WorkPrecision, error: float) -> Best | None:
    """The fastest line at an accuracy that the reference can resolve."""
    return None if error < study.reference.floor else fastest(study.lines, error)


def front(lines: Sequence[Line]) -> list[Point]:
    """The Pareto front, fastest first; of runs beyond the reference's accuracy the fastest only."""
    best: list[Point] = []
    runs = [point for line in lines for point in line.done]
    for point in sorted(runs, key=lambda run: run.seconds):
        if point.worst < (best[-1].worst if best else math.inf):
            best.append(point)
        if point.beyond:
            break
    return best


def slope(line: Line) -> float | None:
    """d log E / d log rtol over the runs whose error is known: 1 where errors follow tolerances."""
    runs = [(point.rtol, point.worst) for point in line.known if point.worst < 0.1]
    if len(runs) < 2:
        return None
    rtols, worst = np.log(np.array(runs)).T
    return float(np.polyfit(rtols, worst, 1)[0])


def effectivity(line: Line) -> float | None:
    """Median of E over rtol: the factor between the error of a run and the tolerance of a step."""
    ratios = [point.worst / point.rtol for point in line.known]
    return float(np.median(ratios)) if ratios else None


def sentences(study: WorkPrecision, *, whole: bool = False) -> Iterator[str]:
    """Conclusions, a line each, the most important first; reasons of failures short or whole."""
    longest = math.inf if whole else LONG
    yield headline(study)
    target = next((target for target in (1e-6, 1e-3) if best_at(study, target)), None)
    if target is not None:
        yield from _comparisons(study, target)
    for choice in study.choices:
        yield _choice(study, choice, longest)
    yield from _reference(study)
    yield from _failures(study, longest)
    yield from _times(study)


def headline(study: WorkPrecision) -> str:
    """The cost of three more digits."""
    reached = [(target, best) for target in TARGETS if (best := best_at(study, target))]
    if len(reached) < 2:
        most = max((point.digits for point in front(study.lines)), default=0.0)
        return f"No run has more than {most:.1f} digits that the reference can resolve."
    (loose, fast), (tight, slow) = reached[-2:]
    return (
        f"Three more digits, {digits(tight)} instead of {digits(loose)}, cost "
        f"{slow.seconds / fast.seconds:.2g} times the time: {milliseconds(fast.seconds)}"
        f"{'' if slow.line is fast.line else f' ({fast.line.setting.title})'} become "
        f"{milliseconds(slow.seconds)} ({slow.line.setting.title})."
    )


def _comparisons(study: WorkPrecision, target: float) -> Iterator[str]:
    """Methods, corrections and formulations at one accuracy."""
    reached = {line.setting: time_at(line, target) for line in study.lines}
    times = {setting: seconds for setting, seconds in reached.items() if seconds is not None}
    at, base = f"at {digits(target)} digits", Setting("dop853")
    once = sorted((seconds, s.title) for s, seconds in times.items() if s.correction == "step")
    if len(once) > 1:
        (least, first), (most, last) = once[0], once[-1]
        yield (
            f"{at.capitalize()} {first} takes {milliseconds(least)}, {last} {most / least:.3g} "
            "times as long."
        )
    others = (
        (replace(base, correction="stage"), "Correction at every stage"),
        (replace(base, correction="projection"), "Correction by projection"),
        (replace(base, formulation="reduced"), f"{base.method}, reduced"),
    )
    for other, name in others:
        if base in times and other in times:
            ratio = times[other] / times[base]
            yield f"{name} takes {ratio:.2f} times the time of {base.title} {at}."


def _choice(study: WorkPrecision, choice: Choice, longest: float) -> str:
    """Accuracy and time of a modelling choice, and the time of the declared scene beside it."""
    point = choice.point
    if point is None:
        return f"{choice.title}: not run. {shortened(choice.reason, longest)}"
    if point.beyond:
        kept = "all digits that the reference can resolve"
    else:
        kept = f"{max(point.digits, 0.0):.1f} digits, however tight the tolerance"
    full = best_at(study, max(min(point.worst, 0.1), study.reference.floor))
    declared = ""
    if full is not None:
        declared = f"; the declared scene has as many after {milliseconds(full.seconds)}"
    return f"{choice.title} keeps {kept}, after {milliseconds(point.seconds)}{declared}."


def _reference(study: WorkPrecision) -> Iterator[str]:
    reference = study.reference
    checks = ", ".join(f"{check.title} differs by {check.error:.1e}" for check in reference.checks)
    kind = "was given" if reference.independent else "is itself a run and not independent"
    yield (
        f"The reference, {reference.source}, {kind}: {checks}. Errors below "
        f"{reference.floor:.1e} cannot be resolved."
    )
    if reference.horizon is not None:
        yield (
            f"From t = {reference.horizon:.4g} s on, the reference is known to fewer than six "
            "digits: the motion is too sensitive to be followed for longer, or the reference "
            "belongs to another machine. End the run earlier, or compare less sensitive "
            "quantities."
        )


def _failures(study: WorkPrecision, longest: float) -> Iterator[str]:
    refusals: dict[str, list[str]] = {}
    for line in study.lines:
        if line.refused:
            refusals.setdefault(line.refused, []).append(line.setting.title)
        if line.failed:
            outcomes = ", ".join(dict.fromkeys(point.outcome for point in line.failed))
            count = f"{len(line.failed)} of {len(line.points)} runs did not reach the end"
            reason = shortened(line.failed[0].message, longest)
            yield f"{line.setting.title}: {count}: {outcomes}. {reason}"
    for reason, titles in refusals.items():
        yield f"Not tried: {'; '.join(titles)}. {shortened(reason, longest)}"


def _times(study: WorkPrecision) -> Iterator[str]:
    noisy = [point.spread > NOISY for line in study.lines for point in line.done]
    if any(noisy):
        yield (
            f"The times of {sum(noisy)} of {len(noisy)} runs spread by more than {NOISY:g} "
            "(median over least): others use the machine; the least counts."
        )
    if study.build:
        parts = ", ".join(f"{stage} {seconds:.2g}" for stage, seconds in study.build.items())
        yield f"Building, once, apart from all runs, in s: {parts}."


def records(study: WorkPrecision) -> Iterator[dict[str, Any]]:
    """One mapping per run, per refused setting, and per modelling choice that did not run."""
    names = ("model", "scene", "model_sha256", "t_start", "t_end", "instants", "environment")
    common = {name: getattr(study, name) for name in names} | {
        "artefact_sha256": study.artefact,
        "scales": {scale.name: scale.value for scale in study.quantities},
        "reference": study.reference.source,
        "independent": study.reference.independent,
        "floor": study.reference.floor,
        "energy_against": study.energy,
    }
    for line in study.lines:
        about = {**common, **asdict(line.setting), "choice": ""}
        of_line = {"slope": slope(line), "effectivity": effectivity(line)}
        if line.refused:
            yield plain({**about, **_refusal(line.refused)})
        for point in line.points:
            yield plain({**about, **_run(study, point), **of_line})
    for choice in study.choices:
        about = {**common, "scene_run": choice.scene, "choice": choice.title}
        run = _run(study, choice.point) if choice.point else _refusal(choice.reason)
        yield plain({**about, **asdict(choice.setting or Setting("")), **run})


def _refusal(reason: str) -> dict[str, Any]:
    return {"outcome": "REFUSED", "message": reason}


def _run(study: WorkPrecision, point: Point) -> dict[str, Any]:
    positions = [scale for scale in study.quantities if scale.group == "positions"]
    atol = {scale.name: point.rtol * min(1.0, scale.value) for scale in positions}
    return {**asdict(point), "atol": atol, "digits": point.digits}


SCORES = ("setting", *(f"{digits(target)} digits" for target in TARGETS), "most", "slope")
SCORES += ("E/rtol", "failed")


def score(study: WorkPrecision) -> "Table":
    """Times at three, six and nine digits, blank where these are not reached; the best marked."""
    title = f"{study.model}/{study.scene}, {study.t_end:g} s: time in ms for this many digits"
    caption = "*: the fastest; slope of error over tolerance; error over tolerance, median"
    return new_table(title, caption, SCORES, *score_sections(study), least=14)


def score_sections(study: WorkPrecision) -> Iterator[list[tuple[object, ...]]]:
    """Rows of the settings, and of modelling choices."""
    yield [(line.setting.title, *_score(study, line)) for line in study.lines]
    yield [(choice.title, *_score_of_choice(choice)) for choice in study.choices]


def _score(study: WorkPrecision, line: Line) -> tuple[object, ...]:
    """Times, the most digits, and how errors follow tolerances."""
    if line.refused:
        return (*[""] * 6, "refused")
    times = []
    for target in TARGETS:
        best = best_at(study, target)
        seconds = time_at(line, target) if best else None
        mark = "*" if best and best.line is line else " "
        times.append("" if seconds is None else f"{1e3 * seconds:.3g}{mark}")
    most = max((f"{point.digits:.1f}" for point in line.known), key=float, default="")
    if any(point.beyond for point in line.done):
        most = f">{-math.log10(study.reference.floor):.1f}"
    steep, ratio = slope(line), effectivity(line)
    follows = "" if steep is None else f"{steep:.2f}", "" if ratio is None else f"{ratio:.2g}"
    return *times, most, *follows, len(line.failed) or ""


def _score_of_choice(choice: Choice) -> tuple[object, ...]:
    point = choice.point
    if point is None:
        return (*[""] * 6, "not run")
    times = [f"{1e3 * point.seconds:.3g} " if point.worst <= target else "" for target in TARGETS]
    return *times, f"{point.digits:.1f}", "", "", ""


def work(study: WorkPrecision) -> "Table":
    """Counters and residuals of the first run of each setting with six digits."""
    against = " (against the reference)" if study.energy == "reference" else ""
    caption = (
        "largest |Φ| over the machine's size, |Φ_q q̇ - ν| over the largest speed, energy "
        f"error over the energy{against}"
    )
    head = ("setting", "rtol", "steps", "rej.", "rhs", "Newton", "J", "LU", "|Φ|", "|Φ̇|", "energy")
    firsts = (
        (line, next((point for point in line.done if point.worst <= COMPARED), None))
        for line in study.lines
    )
    rows = [(line.setting.title, *_work_cells(point)) for line, point in firsts if point]
    title = f"the loosest run with {digits(COMPARED)} digits"
    return new_table(title, caption, head, rows, least=14)


def _work_cells(point: Point) -> tuple[str, ...]:
    names = ("steps", "rejected", "rhs_evaluations", "newton", "jacobians", "factorizations")
    counts = {**dict.fromkeys(names, 0.0), **point.counts}
    counts["newton"] = counts.get("corrections", 0.0) + counts.get("stage_iterations", 0.0)
    residuals = point.position_residual, point.velocity_residual, point.energy
    return (
        f"{point.rtol:.0e}", *(f"{counts[name]:.0f}" for name in names),
        *("" if size is None else f"{size:.0e}" for size in residuals),
    )  # fmt: skip
