"""A work-precision diagram as data; conclusions, sentences and tables, read from it alone."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from codegen.object_display import counted
from codegen.presentation import in_pyplot, milliseconds, new_table, shortened
from codegen.readers.calls import checked_class
from runtime.accuracy_target.error_norms import Errors, Scale
from runtime.studies.answer import Answer, titled
from runtime.studies.harness import Setting, time_to_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table

# Scaled errors at which times are given; the IFToMM benchmarks call the first precise.
TARGETS = (1e-3, 1e-6, 1e-9)
NOISY = 1.3  # spread from which on a time is doubtful
LONG = 160  # characters of a reason on a screen; a longer one is cut there, not in the records


@dataclass(frozen=True)
class Point:
    """One run."""

    rtol: float
    # the name of a `runtime.Outcome`; "TIMEOUT"; "NOT_TRIED" where looser tolerances had met that
    # twice; "OTHER_END" where joints come and go, or a condition ends it, not as in the reference
    outcome: str
    message: str = ""  # how it ended, in a sentence
    errors: Errors | None = None  # against the reference; None of a run that did not reach its end
    beyond: bool = False  # whether the error is smaller than that of the reference: not known
    seconds: float = math.nan  # processor time of the integration alone, the least of the runs
    spread: float = math.nan  # median of the runs' times over the least
    runs: int = 0
    counts: dict[str, float] = field(default_factory=dict)  # entries of `Result.stats`
    position_residual: float = math.nan  # largest |Φ| over the machine's size
    velocity_residual: float = math.nan  # largest |Φ_q q̇ - ν| over the largest velocity
    energy: float | None = None  # largest error over its largest magnitude; None without energy

    @property
    def worst(self) -> float:
        """The largest scaled error; nan of a run that failed."""
        return math.nan if self.errors is None else self.errors.worst

    @property
    def digits(self) -> float:
        """-log10 of the largest scaled error; nan of a run that failed."""
        return math.nan if self.errors is None else -math.log10(max(self.worst, 1e-17))


@dataclass(frozen=True)
class Line:
    """A setting at all tolerances, the loosest first; or why the scene cannot take it."""

    setting: Setting
    points: tuple[Point, ...] = ()
    refused: str = ""

    @property
    def done(self) -> tuple[Point, ...]:
        """The runs that reached their end."""
        return tuple(point for point in self.points if point.errors is not None)

    @property
    def known(self) -> tuple[Point, ...]:
        """Those of them whose error the reference can resolve."""
        return tuple(point for point in self.done if not point.beyond)

    @property
    def failed(self) -> tuple[Point, ...]:
        """The runs that did not reach their end."""
        return tuple(point for point in self.points if point.errors is None)


@dataclass(frozen=True)
class Check:
    """A run that confirms the reference to a scaled error."""

    title: str
    error: float


@dataclass(frozen=True)
class Reference:
    """The solution with which all runs are compared."""

    source: str  # the file, or the setting of a run at a tolerance that no other run has
    independent: bool  # whether it was given, not computed by the methods that are compared
    checks: tuple[Check, ...]  # runs of other methods that confirm it
    floor: float  # scaled error to which it is known: the least difference of a check
    horizon: float | None = None  # instant, s, from which on it is known to fewer than six digits


@dataclass(frozen=True)
class Choice:
    """The scene with one thing modelled differently."""

    title: str  # ``rod as link``
    kind: str  # of the thing
    scene: str  # that was run
    setting: Setting | None = None  # of the run; None where none was possible
    point: Point | None = None  # the loosest run whose error is that of the model alone
    reason: str = ""  # why there is no run


@checked_class
@dataclass(frozen=True, repr=False)
class WorkPrecision(Answer):
    """The time that the accuracy of a scene's motion costs.

    Attributes
    ----------
    t_start, t_end, instants
        The run, s, and the number of instants at which it is compared.
    quantities
        The compared quantities, and the scales of their errors.
    energy
        What the energy is compared with: "start" where it is conserved, "reference" where it
        changes, "" where the scene has none.
    limit, steps
        Time, s, and steps that a run may take.
    build
        Stage → seconds of building the scene anew once, apart from all runs.
    environment
        Machine and versions.
    model_sha256, artefact
        SHA-256 of the model's file, where it has one, and of the generated module.
    """

    model: str
    scene: str
    t_start: float
    t_end: float
    instants: int
    quantities: tuple[Scale, ...]
    energy: str
    limit: float
    steps: int
    reference: Reference
    lines: tuple[Line, ...]
    choices: tuple[Choice, ...] = ()
    build: dict[str, float] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)
    model_sha256: str = ""
    artefact: str = ""

    def __getitem__(self, title: str) -> Line:
        """The line of a setting, by its title."""
        return titled("setting", {line.setting.title: line for line in self.lines}, title)

    @in_pyplot()
    def plot(self) -> "Figure":
        """Draw the error of every setting over the time that it takes.

        Raises
        ------
        InputError
            If matplotlib is not installed.
        """
        from runtime.studies.pictures import draw_diagram

        return draw_diagram(self)

    @property
    def title(self) -> str:
        """The scene and the run."""
        settings = counted(len(self.lines), "setting")
        span = f"t = {self.t_start:g} to {self.t_end:g} s"
        return f"{self.model}/{self.scene}, accuracy: {settings}, {span}"

    def sentences(self, *, whole: bool = False) -> Iterator[str]:
        """Conclusions, the most important first; reasons of failures short or whole."""
        longest = math.inf if whole else LONG
        yield headline(self)
        target = next((target for target in (1e-6, 1e-3) if best_at(self, target)), None)
        if target is not None:
            yield from _comparisons(self, target)
        for choice in self.choices:
            yield _choice(self, choice, longest)
        yield from _reference(self.reference)
        yield from _failures(self, longest)
        noisy = [point.spread > NOISY for line in self.lines for point in line.done]
        if any(noisy):
            yield (
                f"The times of {sum(noisy)} of {len(noisy)} runs spread by more than {NOISY:g} "
                "(median over least): others use the machine; the least counts."
            )
        if self.build:
            parts = ", ".join(f"{stage} {seconds:.2g}" for stage, seconds in self.build.items())
            yield f"Building, once, apart from all runs, in s: {parts}."

    def tables(self) -> "tuple[Table, Table]":
        """Times at three, six and nine digits, the best marked; counters and residuals."""
        title = f"{self.model}/{self.scene}, {self.t_end:g} s: time in ms for this many digits"
        caption = (
            "times in ms, *: the fastest; slope of error over tolerance; error over tolerance, "
            "median"
        )
        head = ["setting", "3 digits", "6 digits", "9 digits", "most", "slope", "E/rtol", "failed"]
        lines = [(line.setting.title, *_score(self, line)) for line in self.lines]
        choices = [(choice.title, *_score_of_choice(choice)) for choice in self.choices]
        times = new_table(title, head, lines, choices, caption=caption, least=14)
        against = " (against the reference)" if self.energy == "reference" else ""
        caption = (
            "largest |Φ| over the machine's size, |Φ_q q̇ - ν| over the largest speed, energy "
            f"error over the energy{against}"
        )
        head = ["setting", "rtol", "steps", "rej.", "rhs", "Newton", "J", "LU", "|Φ|", "|Φ̇|"]
        rows = [row for line in self.lines for row in _work(line)]
        title = "the loosest run with 6 digits"
        return times, new_table(title, [*head, "energy"], rows, caption=caption, least=14)


def digits(error: float) -> str:
    """1e-6 → "6"."""
    return f"{-math.log10(error):.3g}"


def time_at(line: Line, error: float) -> float:
    """Time in s in which a line reaches a scaled error, as a tighter, faster run does too; or ∞."""
    points = [(point.worst, point.seconds) for point in line.done]
    return min([time_to_error(points, error), *(time for worst, time in points if worst <= error)])


def fastest(lines: Sequence[Line], error: float) -> Line | None:
    """The fastest line at an accuracy."""
    best = min(lines, key=lambda line: time_at(line, error), default=None)
    return None if best is None or math.isinf(time_at(best, error)) else best


def best_at(study: WorkPrecision, error: float) -> Line | None:
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
    return median(ratios) if ratios else None


def headline(study: WorkPrecision) -> str:
    """The cost of three more digits."""
    reached = [(target, line) for target in TARGETS if (line := best_at(study, target))]
    if len(reached) < 2:
        most = max((point.digits for point in front(study.lines)), default=0.0)
        return f"No run has more than {most:.1f} digits that the reference can resolve."
    (loose, fast), (tight, slow) = reached[-2:]
    before, after = time_at(fast, loose), time_at(slow, tight)
    return (
        f"Three more digits, {digits(tight)} instead of {digits(loose)}, cost "
        f"{after / before:.2g} times the time: {milliseconds(before)}"
        f"{'' if slow is fast else f' ({fast.setting.title})'} become "
        f"{milliseconds(after)} ({slow.setting.title})."
    )


def _comparisons(study: WorkPrecision, target: float) -> Iterator[str]:
    """Methods, corrections and formulations at one accuracy."""
    reached = {line.setting: time_at(line, target) for line in study.lines}
    times = {setting: seconds for setting, seconds in reached.items() if math.isfinite(seconds)}
    at, base = f"at {digits(target)} digits", Setting("dop853")
    once = sorted((seconds, s.title) for s, seconds in times.items() if s.correction == "step")
    if len(once) > 1:
        (least, first), (most, last) = once[0], once[-1]
        yield (
            f"{at.capitalize()} {first} takes {milliseconds(least)}, {last} {most / least:.3g} "
            "times as long."
        )
    others = {
        "Correction at every stage": replace(base, correction="stage"),
        "Correction by projection": replace(base, correction="projection"),
        f"{base.method}, reduced": replace(base, formulation="reduced"),
    }
    for name, other in others.items():
        if base in times and other in times:
            ratio = times[other] / times[base]
            yield f"{name} takes {ratio:.2f} times the time of {base.title} {at}."


def _choice(study: WorkPrecision, choice: Choice, longest: float) -> str:
    """Accuracy and time of a modelling choice, and the time of the declared scene beside it."""
    point = choice.point
    if point is None:
        return f"{choice.title}: not run. {shortened(choice.reason, longest)}"
    kept = f"{max(point.digits, 0.0):.1f} digits, however tight the tolerance"
    if point.beyond:
        kept = "all digits that the reference can resolve"
    error, declared = max(min(point.worst, 0.1), study.reference.floor), ""
    if full := fastest(study.lines, error):
        declared = f"; the declared scene has as many after {milliseconds(time_at(full, error))}"
    return f"{choice.title} keeps {kept}, after {milliseconds(point.seconds)}{declared}."


def _reference(reference: Reference) -> Iterator[str]:
    checks = ", ".join(f"{check.title} differs by {check.error:.1e}" for check in reference.checks)
    kind = "was given" if reference.independent else "is itself a run and not independent"
    yield (
        f"The reference, {reference.source}, {kind}: {checks}. Errors below "
        f"{reference.floor:.1e} cannot be resolved."
    )
    if reference.horizon is not None:
        yield (
            f"From t = {reference.horizon:.4g} s on, the reference is known to fewer than six "
            "digits: the motion is too sensitive to be followed for longer, or the reference is "
            "of another machine. End the run earlier, or compare less sensitive quantities."
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


def _score(study: WorkPrecision, line: Line) -> tuple[object, ...]:
    """Times, the most digits, and how errors follow tolerances."""
    if line.refused:
        return (*[""] * 6, "refused")
    times = []
    for target in TARGETS:
        best, seconds = best_at(study, target), time_at(line, target)
        reached = best and math.isfinite(seconds)
        times.append(f"{1e3 * seconds:.3g}{'*' if best is line else ' '}" if reached else "")
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


def _work(line: Line) -> Iterator[tuple[str, ...]]:
    """Counters and residuals of the first run with six digits, if there is one."""
    names = ("steps", "rejected", "rhs_evaluations", "newton", "jacobians", "factorizations")
    for point in [point for point in line.done if point.worst <= TARGETS[1]][:1]:
        counts, residuals = point.counts, (point.position_residual, point.velocity_residual)
        newton = counts.get("corrections", 0.0) + counts.get("stage_iterations", 0.0)
        counts = {**dict.fromkeys(names, 0.0), **counts, "newton": newton}
        cells = [f"{point.rtol:.0e}", *(f"{counts[name]:.0f}" for name in names)]
        cells += ["" if x is None else f"{x:.0e}" for x in (*residuals, point.energy)]
        yield line.setting.title, *cells
