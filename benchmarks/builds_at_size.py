"""Builds of large machines: their text, seconds by stage, memory, and the time of their kernels.

Each build is a process of its own (`benchmarks.one_build`). The seconds of its stages are processor
time, those of the whole what a person waits for. The kernels take turns in this process.
"""

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import log
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.kernel_timing import TIME, interleaved, many_solutions, no_solution
from benchmarks.one_build import FAMILIES, STAGES, arrays, start_of
from benchmarks.report import Report, records, verdict
from codegen.files.generated_modules import import_generated

SIZES = (10, 40, 100, 400, 1000)
STRAIGHT = (10, 40)
"""Sizes that are built as straight code as well."""
SECONDS = {"chain": 10.0, "n_four_bar": 20.0}
"""Bars of a whole build of the largest size, imports and the first call included, s."""
EXPONENT = 1.1
MEMORY = 2048.0  # MB
SPREAD = 1.2
"""Bar of the slowest size, in times of the fastest, ns a body."""
ROLLED = 1.5
"""Bar of loops at the smallest size, in times of straight code."""
STATES = 4  # of which the calls take turns; the second cache holds no more
BODIES = 200_000  # for which the calls of a round solve
ROUNDS = 100
COLUMNS = {
    "import": ("import",),
    "declare": ("declare", "check"),
    "lower": ("derive", "lower", "examine"),
    "emit": ("emit",),
    "compile": ("compile",),
}
"""Columns of the table → stages."""


@dataclass(frozen=True)
class Row:
    """A build.

    Attributes
    ----------
    family, size, code
        Of the machine, and "loops" or "straight".
    lines, table_bytes
        Lines of the functions of the module, and bytes of the tables before them.
    seconds
        Processor time by stage.
    whole
        Processor time from the first import to the first call, s.
    wall
        What a person waits for it, Python's start included, s.
    megabytes
        The most memory of the process.
    nanoseconds
        A body, of a call of `accelerations` with all multipliers.
    """

    family: str
    size: int
    code: str
    lines: int
    table_bytes: int
    seconds: dict[str, float]
    whole: float
    wall: float
    megabytes: float
    nanoseconds: float

    @property
    def growing(self) -> float:
        """Seconds of the stages that grow with the machine."""
        return sum(self.seconds[stage] for stage in STAGES if stage != "compile")


@dataclass(frozen=True)
class Build:
    """What a process built, and its answer."""

    family: str
    size: int
    code: str
    answer: dict[str, Any]
    wall: float  # s

    @property
    def path(self) -> Path:
        """The module."""
        return Path(self.answer["path"])

    def runs(self) -> tuple[int, dict[str, Any]]:
        """Bodies for which a round solves, and rounds of the kernel and of an empty one."""
        declare, scene = FAMILIES[self.family]
        model, module = declare(self.size), import_generated(self.path)
        q, random = start_of(model, scene), np.random.default_rng(1)
        places = q + 1e-3 * random.normal(size=(STATES, len(q)))
        rates = 1e-3 * random.normal(size=places.shape)
        p, a, lam = arrays(module)
        modes = np.zeros((STATES, 0), dtype=np.int64)
        if row := module.accelerations(TIME, places[0], rates[0], p, modes[0], a, lam):
            raise ArithmeticError(f"the pivot of row {row} is weak at the start")
        calls = max(1, BODIES // len(model.bodies))

        def run(kernel: Any, rounds: int) -> None:
            many_solutions(kernel, rounds * calls, places, rates, p, modes, a, lam)

        kernels = {"kernel": module.accelerations, "loop": no_solution}
        found = {name: partial(run, kernel) for name, kernel in kernels.items()}
        return calls * len(model.bodies), found

    def row(self, nanoseconds: float) -> Row:
        """The measurement, with the time of a body that was measured."""
        head, first, functions = self.path.read_text(encoding="utf-8").partition("@numba.njit")
        lines, tables = (first + functions).count("\n"), len(head.encode())
        seconds, whole, size = (self.answer[word] for word in ("seconds", "whole", "megabytes"))
        about = self.family, self.size, self.code
        return Row(*about, lines, tables, seconds, whole, self.wall, size, nanoseconds)


def rows_of(found: Sequence[Build], rounds: int) -> list[Row]:
    """The builds of a family, whose kernels take turns."""
    prepared = [build.runs() for build in found]
    runs = {(k, name): run for k, (_, both) in enumerate(prepared) for name, run in both.items()}
    best = interleaved({f"{k} {name}": run for (k, name), run in runs.items()}, 1, rounds)
    return [
        build.row((best[f"{k} kernel"] - best[f"{k} loop"]) / bodies)
        for k, (build, (bodies, _)) in enumerate(zip(found, prepared, strict=True))
    ]


def builds(family: str, sizes: Sequence[int], folder: Path) -> Iterator[Build]:
    """All sizes in loops, the small ones as straight code too."""
    for code, unroll in (("loops", "never"), ("straight", "always")):
        for size in sizes if code == "loops" else (s for s in STRAIGHT if s in sizes):
            place = folder / f"{family}_{size}_{code}"
            words = [sys.executable, "-m", "benchmarks.one_build", family, str(size), unroll]
            began = perf_counter()
            text = subprocess.run([*words, str(place)], capture_output=True, text=True, check=True)
            yield Build(family, size, code, json.loads(text.stdout), perf_counter() - began)


def reports(quick: bool) -> list[Report]:
    """Both families at all sizes; without the largest where it is to be quick."""
    sizes = SIZES[:3] if quick else SIZES
    with TemporaryDirectory() as folder:
        # All builds come first: a process begins with the memory of the one that starts it.
        found = {family: [*builds(family, sizes, Path(folder))] for family in FAMILIES}
        rows = [row for one in found.values() for row in rows_of(one, 5 if quick else ROUNDS)]
    cells = [
        (
            row.family, row.code, str(row.size), str(row.lines), f"{row.table_bytes / 1e3:.0f}",
            *(f"{sum(row.seconds[s] for s in stages):.2f}" for stages in COLUMNS.values()),
            f"{row.whole:.1f}", f"{row.wall:.1f}", f"{row.megabytes:.0f}", f"{row.nanoseconds:.1f}",
        )
        for row in rows
    ]  # fmt: skip
    sizes_of_text = ("machine", "code", "size", "lines", "tables, kB")
    headings = (*sizes_of_text, *COLUMNS, "whole", "wall", "MB", "ns a body")
    title = "builds at size: a chain of bars, and parallel four-bars in a row"
    sentences = ["Stages, and the whole from import to the first call: s of processor time, of all"]
    sentences[0] += " processes together. wall: s that a person waits for the whole."
    sentences += [sentence for family in FAMILIES for sentence in verdicts(rows, family)]
    return [Report("builds", title, headings, cells, sentences, records(rows), 2)]


def verdicts(rows: Sequence[Row], family: str) -> Iterator[str]:
    """The bars of a family."""
    loops = [r for r in rows if (r.family, r.code) == (family, "loops")]
    straight = next(r for r in rows if (r.family, r.code) == (family, "straight"))
    middle, last = next(r for r in loops if r.size >= 100), loops[-1]
    if last.size == SIZES[-1]:
        what = f"{family}, the whole build at size {last.size}:"
        yield verdict(what, last.wall, SECONDS[family], " s")
        yield verdict(f"{family}, its memory:", last.megabytes, MEMORY, " MB")
        power = log(last.growing / middle.growing) / log(last.size / middle.size)
        what = f"{family}, the power with which it grows from {middle.size}, without `compile`:"
        yield verdict(what, power, EXPONENT)
    costs = [r.nanoseconds for r in loops]
    yield verdict(f"{family}, slowest over fastest size in loops:", max(costs) / min(costs), SPREAD)
    what = f"{family}, loops over straight code at size {loops[0].size}:"
    yield verdict(what, loops[0].nanoseconds / straight.nanoseconds, ROLLED)
