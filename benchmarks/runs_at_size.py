"""Machines of many parts: what a run takes by size, and how right it is.

Every run has a process of its own, which takes the module that another has built: its memory is
that of the run.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.contest import ROOT, THREADS
from benchmarks.report import Report, records, verdict
from benchmarks.run_of_machine import RTOL, TARGET, Run

SIZES = {
    "chain": (100, 1000),
    "n_four_bar": (40, 100, 400),
    "net": (10, 20, 30),
    "roller_chain": (50, 100, 200),
}
QUICK = {"chain": (20, 50), "n_four_bar": (5, 10), "net": (4, 6), "roller_chain": (20, 30)}
LINEAR = {"chain": 1.5, "roller_chain": 2.0}
"""Bars: time of an evaluation and part of the largest machine, over that of the smallest."""
LOOPS = 1.5
"""Bar: time of a run and loop, with its singular crossings, over that of the smallest machine."""
DRIFT = 1e-6
"""Bar: departure from the balance of energy over the largest kinetic energy, at that accuracy."""


def one(family: str, size: int, folder: Path) -> Run:
    """A run in a process of its own, after one that has built what it needs."""
    command = [sys.executable, "-m", "benchmarks.run_of_machine", family, str(size), str(folder)]
    env = {**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONPATH": str(ROOT)}
    for _ in range(2):
        done = subprocess.run(command, cwd=ROOT, env=env, stdout=subprocess.PIPE, check=True)
    return Run(**json.loads(done.stdout.splitlines()[-1]))


def parts(run: Run) -> int:
    """Number of a machine's parts that its cost is measured by: bodies or knots."""
    return run.size**2 if run.family == "net" else run.size


def pace(run: Run) -> float:
    """µs of the integration, an evaluation of the equations and a part of the machine."""
    return run.integration / run.evaluations / parts(run) * 1e6


def verdicts(runs: Sequence[Run]) -> Iterator[str]:
    """Whether the bars hold."""
    for family, bar in LINEAR.items():
        small, *_, large = (run for run in runs if run.family == family)
        what = (
            f"{family}, an evaluation and part with {large.size}, in times of that with "
            f"{small.size}:"
        )
        yield verdict(what, pace(large) / pace(small), bar)
    first, *others = (run for run in runs if run.family == "n_four_bar")
    for run in others:
        what = f"n_four_bar, a run and loop with {run.size}, in times of that with {first.size}:"
        yield verdict(what, run.cpu / run.size / (first.cpu / first.size), LOOPS)
    for run in runs:
        if run.outcome != "OK":
            yield f"{run.family} with {run.size} ended with {run.outcome}."
        elif run.energy_at_target == run.energy_at_target:  # a number
            answer = "holds" if run.energy_at_target <= DRIFT else "is missed"
            yield (
                f"{run.family} with {run.size}, energy at accuracy {TARGET:g}: "
                f"{run.energy_at_target:.1e}; the bar of {DRIFT:g} {answer}."
            )
    yield (
        "The net grows in both directions: eliminated in the best order its equations fill in with "
        "the third power of a side, so that the time of a part grows with the side."
    )


def report(quick: bool) -> Report:
    """All families at all sizes."""
    sizes = QUICK if quick else SIZES
    with TemporaryDirectory() as folder:
        runs = [one(family, size, Path(folder)) for family, few in sizes.items() for size in few]
    cells = [
        (
            run.family,
            str(run.size),
            str(run.coordinates),
            f"{run.seconds:g}",
            str(run.steps),
            str(run.evaluations),
            str(run.events or run.crossings),
            f"{run.cpu:.3f}",
            f"{run.integration:.3f}",
            f"{pace(run):.3f}",
            f"{run.error:.1e}",
            run.against,
            f"{run.energy:.1e}",
            f"{run.energy_at_target:.1e}",
            f"{run.cpu_at_target:.3f}",
            f"{run.memory:.0f}",
        )
        for run in runs
    ]
    headings = (
        "machine", "size", "coordinates", "s", "steps", "evaluations", "events or crossings",
        "cpu, s", "integration, s", "µs a part", "error", "against", "energy",
        f"energy, accuracy {TARGET:g}", "cpu of that, s", "MB",
    )  # fmt: skip
    title = f"runs of machines of many parts, rtol {RTOL:.0e}"
    return Report("runs", title, headings, cells, list(verdicts(runs)), records(runs))
