"""``python -m benchmarks [NAME]...``: tables.

NAME: elements, elements_in_space, kernels, machines, compressor, scenes or accuracy, all of them
without names; peers, with problems after it or all; growth; builds; runs; first; ensemble.
"""

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import geometric_mean
from typing import Annotated

import typer

from benchmarks import (
    accuracy_targets_report,
    builds_at_size,
    compressor,
    contest,
    contest_report,
    elements,
    elements_in_space,
    ensemble_speed,
    first_result,
    growth,
    kernels,
    linkwright_runs,
    machines,
    picture,
    runs_at_size,
    scenes,
    twins,
)
from benchmarks.element_sample import Sample
from benchmarks.problems import PROBLEMS
from benchmarks.report import Report, finish, records, save, verdict

__all__ = ["main", "save"]

RESULTS = Path(__file__).resolve().parent / "results"
SIDES = ("operations", "hand", "weighted", "hand", "ns", "hand", "ratio", "difference")


def cells(row: twins.Row) -> tuple[str, ...]:
    """A pair of twins in the columns `SIDES`."""
    return (
        str(row.operations),
        str(row.hand_operations),
        str(row.cost),
        str(row.hand_cost),
        f"{row.nanoseconds:.1f}",
        f"{row.hand_nanoseconds:.1f}",
        f"{row.ratio:.2f}",
        f"{row.difference:.1e}",
    )


def of_elements(quick: bool) -> list[Report]:
    """Every joint, driver and force of the plane, against its hand-written twin."""
    title = "elements: generated kernels and hand-written twins"
    return [_of_samples("elements", title, elements.PLANAR, quick)]


def of_elements_in_space(quick: bool) -> list[Report]:
    """The same of those in space."""
    title = "elements in space: generated kernels and hand-written twins"
    return [_of_samples("elements_in_space", title, elements_in_space.SAMPLES, quick)]


def _of_samples(name: str, title: str, samples: Sequence[Sample], quick: bool) -> Report:
    with tempfile.TemporaryDirectory() as folder:
        pairs = elements.twins(samples, Path(folder) / "generated")
        rows = twins.measure(pairs, *((5_000, 2) if quick else (4_000, 500)))
    worst = max(rows, key=lambda row: row.ratio)
    most = max(rows, key=lambda row: row.operations - row.hand_operations)
    enough = sum(row.operations <= row.hand_operations for row in rows)
    mean = verdict(
        "A generated kernel, in times of the hand-written one, in the geometric mean:",
        geometric_mean(row.ratio for row in rows),
        elements.MEAN,
    )
    slowest = verdict(f"The most, {worst.kernel} of {worst.subject}:", worst.ratio, elements.MOST)
    counts = (
        f"{enough} of {len(rows)} need no more operations than by hand; the most too many needs "
        f"{most.kernel} of {most.subject}, {most.operations} for {most.hand_operations}."
    )
    table = [(row.subject, row.kernel, *cells(row)) for row in rows]
    headings = ("element", "kernel", *SIDES)
    return Report(name, title, headings, table, (mean, slowest, counts), records(rows), 2)


def of_kernels(quick: bool) -> list[Report]:
    """The slider-crank's kernels, against hand-written twins."""
    rows = kernels.measure(*((20_000, 3) if quick else (1_000_000, 15)))
    table = [
        (
            row.generated,
            row.hand,
            str(row.operations),
            str(row.hand_operations),
            f"{row.nanoseconds:.1f}",
            f"{row.hand_nanoseconds:.1f}",
            f"{row.ratio:.2f}",
            f"{row.difference:.1e}",
        )
        for row in rows
    ]
    times = "All 9 accelerations and 8 multipliers, in times of the hand-derived equation of one"
    sentence = verdict(f"{times} degree of freedom:", rows[-1].ratio, kernels.BAR)
    headings = ("generated", "by hand", "operations", "hand", "ns", "hand", "ratio", "difference")
    title = "slider-crank: generated kernels and hand-written twins"
    found = [{**asdict(row), "ratio": row.ratio} for row in rows]
    return [Report("kernels", title, headings, table, (sentence,), found, 2)]


def of_machines(quick: bool) -> list[Report]:
    """All machines: against equations of one degree of freedom, and per operation."""
    size = (5_000, 2) if quick else (100_000, 150)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "generated"
        pairs = twins.measure(machines.twins(machines.REDUCED, place), *size)
        rows = machines.measure(machines.MACHINES, place, *size)
    reduced = Report(
        "reduced",
        "machines: all accelerations and multipliers, and equations of one degree of freedom",
        ("machine", *SIDES),
        [(row.subject, *cells(row)) for row in pairs],
        [
            verdict(f"{row.subject}, in times of its equation:", row.ratio, machines.BAR)
            for row in pairs
        ],
        records(pairs),
    )
    pace = Report(
        "machines",
        "machines: time of a weighted operation of the accelerations",
        ("machine", "scene", "operations", "weighted", "ns", "ns an operation"),
        [
            (
                row.machine,
                row.scene,
                str(row.operations),
                str(row.cost),
                f"{row.nanoseconds:.1f}",
                f"{row.pace:.3f}",
            )
            for row in rows
        ],
        [verdict(f"{row.machine}, an operation:", row.pace, machines.PACE, " ns") for row in rows],
        records(rows),
        2,
    )
    return [reduced, pace]


def of_compressor(quick: bool) -> list[Report]:
    """One second of motion."""
    rows = compressor.measure(1 if quick else 5)
    table = [
        (
            row.method,
            f"{row.rtol:.0e}",
            f"{row.milliseconds:.2f}",
            f"{row.milliseconds / rows[0].milliseconds:.1f}",
            f"{row.error:.1e}",
            str(row.evaluations),
        )
        for row in rows
    ]
    headings = ("method", "rtol", "ms", "times ours", "error of crank.phi, rad", "evaluations")
    return [
        Report("compressor", "compressor, J = 450 kg m², 1 s", headings, table, (), records(rows))
    ]


def of_scenes(quick: bool) -> list[Report]:
    """Savings of a scene with fewer outputs or effects."""
    size = (5_000, 2) if quick else (200_000, 15)
    with tempfile.TemporaryDirectory() as folder:
        rows = scenes.kernels(Path(folder), *size)
        runs = scenes.springs(Path(folder), 1 if quick else 5)
    alone, struck = runs
    table = [
        (r.question, r.scene, str(r.operations), f"{r.microseconds:.3f}", str(r.events))
        for r in (*rows, *runs)
    ]
    sentence = verdict(
        f"The spring alone ({alone.events} events), in times of that with its striker:",
        alone.microseconds / struck.microseconds,
        1 / scenes.FASTER,
    )
    headings = ("question", "scene", "operations", "µs", "events")
    title = "scenes: savings by leaving things out"
    return [Report("scenes", title, headings, table, (sentence,), records((*rows, *runs)), 2)]


MEASUREMENTS = {
    "elements": of_elements,
    "elements_in_space": of_elements_in_space,
    "kernels": of_kernels,
    "machines": of_machines,
    "compressor": of_compressor,
    "scenes": of_scenes,
    "accuracy": accuracy_targets_report.report,
}
LONG = ("peers", "growth", "builds", "runs", "first", "ensemble")
"""Minutes each, and only by name."""


def chosen(names: Sequence[str] | None) -> tuple[list[str], list[str]]:
    """The requested measurements, and the problems of the contest; short ones without names."""
    requested = list(names or MEASUREMENTS)
    known = (*MEASUREMENTS, *LONG)
    problems = [name for name in requested if name in PROBLEMS and "peers" in requested]
    for name in requested:
        if name not in known and name not in problems:
            raise typer.BadParameter(f"{name!r} is none of {', '.join(known)}")
    return [name for name in requested if name not in problems], problems or list(PROBLEMS)


def of_peers(problems: Sequence[str], quick: bool, python: str, kept: bool, out: Path) -> None:
    """The contest on each problem, with its picture."""
    with tempfile.TemporaryDirectory() as folder:
        for name in problems:
            path = out / f"peers_{name}.points.json"
            before = contest.read(path) if kept and path.is_file() else None
            rounds = 2 if quick else linkwright_runs.ROUNDS
            measured = contest.run_contest(PROBLEMS[name], Path(folder), python, before, rounds)
            measured.write(path)
            finish(contest_report.report(measured), out)
            picture.draw(measured, out / f"peers_{name}.png")


def main(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="elements, elements_in_space, kernels, machines, compressor, scenes, accuracy: "
            "all without a name; peers, with problems after it or all; growth; builds; runs; "
            "first; ensemble."
        ),
    ] = None,
    quick: Annotated[bool, typer.Option(help="Fewer repeats; times are rough.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for the JSON and Markdown files.")] = RESULTS,
    python: Annotated[
        str, typer.Option(help="Interpreter of the environment that holds the peers.")
    ] = sys.executable,
    ours_only: Annotated[
        bool, typer.Option("--ours", help="Take the peers' part from the results that exist.")
    ] = False,
) -> None:
    """Measure, print, and write down."""
    measurements, problems = chosen(names)
    for name in measurements:
        if name == "peers":
            of_peers(problems, quick, python, ours_only, out)
        elif name == "growth":
            for report in growth.reports(quick, out):
                finish(report, out)
        elif name == "builds":
            for report in builds_at_size.reports(quick):
                finish(report, out)
        elif name == "runs":
            finish(runs_at_size.report(quick), out)
        elif name == "first":
            for report in first_result.report(quick):
                finish(report, out)
        elif name == "ensemble":
            for report in ensemble_speed.report(quick):
                finish(report, out)
        else:
            for report in MEASUREMENTS[name](quick):
                finish(report, out)


if __name__ == "__main__":
    typer.run(main)
