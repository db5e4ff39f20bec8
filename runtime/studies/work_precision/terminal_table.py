"""What accuracy costs, on a terminal: a row a setting, no wider than a person reads."""

import math

from rich.table import Table

from runtime.show.terminal_table import padding
from runtime.studies.work_precision.diagram import Line, Point, WorkPrecision
from runtime.studies.work_precision.interpretation import (
    TARGETS,
    best_at,
    digits,
    effectivity,
    slope,
    time_at,
)

COMPARED = 1e-6
"""Scaled error at which the work of runs is told."""


def score(told: WorkPrecision) -> Table:
    """Times at three, six and nine digits, blank where they are not reached; the best marked."""
    made = Table(
        title=f"{told.model}/{told.scene}, {told.t_end:g} s: milliseconds for so many digits",
        caption="*: the fastest; slope of error over tolerance; error over tolerance, the median",
        padding=padding(),
    )
    made.add_column("setting", overflow="fold", ratio=1, min_width=14)
    for target in TARGETS:
        made.add_column(f"{digits(target)} digits", justify="right", no_wrap=True)
    for name in ("most", "slope", "E/rtol", "failed"):
        made.add_column(name, justify="right", no_wrap=True)
    best = {target: best_at(told, target) for target in TARGETS}
    for line in told.lines:
        if line.refused:
            made.add_row(line.setting.title, "", "", "", "", "", "", "refused")
            continue
        cells = []
        for target in TARGETS:
            seconds = time_at(line, target) if target >= told.reference.floor else None
            fastest = (found := best[target]) is not None and found.line is line
            cells.append("" if seconds is None else f"{_ms(seconds)}{'*' if fastest else ' '}")
        made.add_row(line.setting.title, *cells, *_summary(told, line))
    if told.choices:
        made.add_section()
    for choice in told.choices:
        if choice.point is None:
            made.add_row(choice.title, *[""] * 6, "not run")
            continue
        reached = [
            f"{_ms(choice.point.seconds)} "
            if choice.point.errors and choice.point.errors.worst <= target
            else ""
            for target in TARGETS
        ]
        most = f"{choice.point.digits:.1f}"
        made.add_row(choice.title, *reached, most, "", "", "")
    return made


def work(told: WorkPrecision) -> Table:
    """What the first run of each setting with six digits did, and how well it kept the laws."""
    made = Table(
        title=f"the loosest run with {digits(COMPARED)} digits",
        caption="largest |Φ| over the machine's size, |Φ_q q̇ - ν| over the largest speed, energy "
        f"error over the energy{' (against the reference)' if told.energy == 'reference' else ''}",
        padding=padding(),
    )
    made.add_column("setting", overflow="fold", ratio=1, min_width=14)
    for name in ("rtol", "steps", "rej.", "rhs", "Newton", "J", "LU", "|Φ|", "|Φ̇|", "energy"):
        made.add_column(name, justify="right", no_wrap=True)
    for line in told.lines:
        point = next((p for p in line.done if p.errors and p.errors.worst <= COMPARED), None)
        if point is not None:
            made.add_row(line.setting.title, *_work(point))
    return made


def _work(point: Point) -> tuple[str, ...]:
    counts = point.counts
    newton = counts.get("newton_iterations", 0.0) + counts.get("stage_iterations", 0.0)
    told = ("steps", "rejected", "rhs_evaluations")
    rest = ("jacobians", "factorizations")
    return (
        f"{point.rtol:.0e}",
        *(f"{counts.get(name, 0.0):.0f}" for name in told),
        f"{newton:.0f}",
        *(f"{counts.get(name, 0.0):.0f}" for name in rest),
        f"{point.position_residual:.0e}",
        f"{point.velocity_residual:.0e}",
        "" if point.energy is None else f"{point.energy:.0e}",
    )


def _summary(told: WorkPrecision, line: Line) -> tuple[str, ...]:
    most = max((point.digits for point in line.known), default=None)
    over = any(point.beyond for point in line.done)
    known = (
        f">{-math.log10(told.reference.floor):.1f}"
        if over
        else ""
        if most is None
        else f"{most:.1f}"
    )
    steep, ratio = slope(line), effectivity(line)
    return (
        known,
        "" if steep is None else f"{steep:.2f}",
        "" if ratio is None else f"{ratio:.2g}",
        str(len(line.failed) or ""),
    )


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.3g}"
