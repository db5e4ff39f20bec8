"""Tables of the studies on a terminal: an effect ranking, a work-precision study."""

import math

from rich.table import Table

from runtime.show.table_formatting import new_table
from runtime.studies.effect_ranking.ranking import Costs, Matters, Row, Verdict, percent
from runtime.studies.work_precision import interpretation
from runtime.studies.work_precision.diagram import Choice, Line, Point, WorkPrecision
from runtime.studies.work_precision.interpretation import TARGETS, digits

COMPARED = 1e-6  # scaled error at which the work of runs is compared
_COUNTS = (
    ("steps",), ("rejected",), ("rhs_evaluations",), ("corrections", "stage_iterations"),
    ("jacobians",), ("factorizations",),
)  # fmt: skip


def ranking_table(ranking: Matters) -> Table:
    """The full scene, then the change and the saving without each effect."""
    full = ranking.costs
    caption = (
        "acc., all: operations of the kernel accelerations and of all kernels; the first row is "
        "the full scene, the others the saving"
    )
    columns = ("change", "relative", "acc.", "all", "time", "steps", "events")
    rows = new_table(ranking.title, caption, "without", columns, 9)
    rows.add_column("verdict", no_wrap=True)
    accelerations, operations, steps, events = map(str, _counts(full))
    time = f"{1e3 * full.seconds:.3g} ms"
    rows.add_row("nothing", "", "", accelerations, operations, time, steps, events, "")
    rows.add_section()
    for row in ranking.rows:
        savings = _savings(full, row.costs, row.time_share)
        rows.add_row(row.title, *_change_cells(row), *savings, str(row.verdict))
    proposal = ranking.proposal
    if proposal is not None and proposal.left_out:
        rows.add_section()
        change = f"{proposal.value - ranking.value:+.3g}"
        savings = _savings(full, proposal.costs, proposal.time_share)
        rows.add_row("proposed", change, percent(proposal.relative), *savings, "within error")
    return rows


def _change_cells(row: Row) -> tuple[str, str]:
    if row.change is None:
        return "", ""
    if row.verdict is Verdict.NONE_SEEN:
        return f"< {row.doubt:.1g}", ""
    return f"{row.change:+.3g}", percent(row.relative)


def _counts(costs: Costs) -> tuple[int, int, int, int]:
    return costs.accelerations, costs.operations, costs.steps, costs.events


def _savings(full: Costs, costs: Costs | None, share: float | None) -> tuple[str, ...]:
    if costs is None:
        return ("",) * 5
    saved = [str(all_ - rest) for all_, rest in zip(_counts(full), _counts(costs), strict=True)]
    return (*saved[:2], "" if share is None else f"{share:.0%}", *saved[2:])


def score(study: WorkPrecision) -> Table:
    """Times at three, six and nine digits, blank where these are not reached; the best marked."""
    title = f"{study.model}/{study.scene}, {study.t_end:g} s: time in ms for this many digits"
    caption = "*: the fastest; slope of error over tolerance; error over tolerance, median"
    columns = [*(f"{digits(target)} digits" for target in TARGETS), "most", "slope", "E/rtol"]
    table = new_table(title, caption, "setting", [*columns, "failed"], 14)
    best = [interpretation.best_at(study, target) for target in TARGETS]
    for line in study.lines:
        if line.refused:
            table.add_row(line.setting.title, *[""] * 6, "refused")
            continue
        cells = []
        for target, fastest in zip(TARGETS, best, strict=True):
            seconds = interpretation.time_at(line, target) if fastest else None
            mark = "*" if fastest and fastest.line is line else " "
            cells.append("" if seconds is None else f"{1e3 * seconds:.3g}{mark}")
        table.add_row(line.setting.title, *cells, *_summary_cells(study, line))
    if study.choices:
        table.add_section()
    for choice in study.choices:
        table.add_row(choice.title, *_choice_cells(choice))
    return table


def work(study: WorkPrecision) -> Table:
    """Counters and residuals of the first run of each setting with six digits."""
    against = " (against the reference)" if study.energy == "reference" else ""
    caption = (
        "largest |Φ| over the machine's size, |Φ_q q̇ - ν| over the largest speed, energy "
        f"error over the energy{against}"
    )
    columns = ("rtol", "steps", "rej.", "rhs", "Newton", "J", "LU", "|Φ|", "|Φ̇|", "energy")
    title = f"the loosest run with {digits(COMPARED)} digits"
    table = new_table(title, caption, "setting", columns, 14)
    for line in study.lines:
        point = next((p for p in line.done if p.worst <= COMPARED), None)
        if point is not None:
            table.add_row(line.setting.title, *_work_cells(point))
    return table


def _work_cells(point: Point) -> tuple[str, ...]:
    counts = [f"{sum(point.counts.get(name, 0.0) for name in names):.0f}" for names in _COUNTS]
    residuals = f"{point.position_residual:.0e}", f"{point.velocity_residual:.0e}"
    energy = "" if point.energy is None else f"{point.energy:.0e}"
    return f"{point.rtol:.0e}", *counts, *residuals, energy


def _summary_cells(study: WorkPrecision, line: Line) -> tuple[str, ...]:
    if any(point.beyond for point in line.done):
        most = f">{-math.log10(study.reference.floor):.1f}"
    else:
        most = f"{max(point.digits for point in line.known):.1f}" if line.known else ""
    steep, ratio = interpretation.slope(line), interpretation.effectivity(line)
    slope, factor = "" if steep is None else f"{steep:.2f}", "" if ratio is None else f"{ratio:.2g}"
    return most, slope, factor, str(len(line.failed) or "")


def _choice_cells(choice: Choice) -> list[str]:
    point = choice.point
    if point is None:
        return [*[""] * 6, "not run"]
    time = f"{1e3 * point.seconds:.3g} "
    reached = [time if point.worst <= target else "" for target in TARGETS]
    return [*reached, f"{point.digits:.1f}", "", "", ""]
