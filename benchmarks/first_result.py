"""Time to the first result: from nothing, of a new scene, and in a new process.

Each row is one process that loads a machine and simulates a second. Seconds are processor time of
that process, which others on the machine take no part in; `all processes` is this and the time of
those that build and compile beside it. `wall` is what a person waits for the result, from the start
of a process that nobody looks into, and `ended` is when that process has ended as well.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from benchmarks.report import Report, records, verdict

BARS = {"from nothing": 20.0, "new scene": 1.5, "new process": 0.8}  # s
MACHINES = (("four_bar", "constant_torque"), ("slider_crank", "compressor"))
_MODELS = Path(__file__).resolve().parents[1] / "models"
_PROGRAM = """
import json, sys, time
from linkwright import load
from codegen.machine_code import compiled_functions, kernels
class Clock:
    depth = count = 0
    began = spent = 0.0
    def begin(self, *about):
        self.depth, self.count = self.depth + 1, self.count + 1
        self.began = time.process_time() if self.depth == 1 else self.began
    def end(self):
        self.depth -= 1
        self.spent += 0.0 if self.depth else time.process_time() - self.began
clock, execute = Clock(), kernels.execute
def timed(*given):
    clock.begin()
    execute(*given)
    clock.end()
kernels.execute = timed
watched = compiled_functions.watched_compilation(clock.begin, clock.end)
watched.__enter__()
imported = time.process_time()
machine = load(sys.argv[1], scene=sys.argv[2])
loaded, kernels = time.process_time(), clock.spent
machine.simulate(1.0)
print(json.dumps([imported, loaded - imported - kernels, kernels,
    clock.spent - kernels, time.process_time() - loaded - (clock.spent - kernels),
    clock.count, time.process_time()]), flush=True)
"""
_PLAIN = """
import sys
from linkwright import load
load(sys.argv[1], scene=sys.argv[2]).simulate(1.0)
print("[]", flush=True)
"""


@dataclass(frozen=True)
class Row:
    """One first result; all but `functions` in s."""

    result: str
    machine: str
    imports: float
    translation: float  # of the model into a module, or what is done while another process does so
    kernels: float  # compiled
    loop: float  # compiled
    run: float  # loads compiled functions from the cache, assembles, simulates
    functions: int  # that this process compiled
    total: float
    processes: float  # with the one that compiles beside it, and with the ends of both
    wall: float  # until the result
    ended: float  # by the wall clock


class Answer(NamedTuple):
    """What a process printed, and what it took."""

    printed: list[float]
    processes: float  # processor time of all, s
    wall: float  # until it was printed, s
    ended: float  # s


def measure() -> list[Row]:
    """Three first results of each machine, each after those that it stands on."""
    rows = []
    for machine, scene in MACHINES:
        spent, waited = _answers(_PROGRAM, machine, scene), _answers(_PLAIN, machine, scene)
        for result, parts, wait in zip(BARS, spent, waited, strict=True):
            imports, translation, kernels, loop, run, functions, total = parts.printed
            rows.append(
                Row(result, machine, imports, translation, kernels, loop, run, int(functions),
                    total, parts.processes, wait.wall, wait.ended)
            )  # fmt: skip
    return rows


def _answers(program: str, machine: str, scene: str) -> list[Answer]:
    """For each of BARS."""
    with tempfile.TemporaryDirectory() as folder:
        cache, found = Path(folder) / "cache", []
        for result in BARS:
            place = Path(folder) / ("first" if result == "from nothing" else "second")
            (place / "models").mkdir(parents=True, exist_ok=True)
            text = (_MODELS / f"{machine}.py").read_text()
            (place / "models" / f"{machine}.py").write_text(f"{text}\n# {place.name}\n")
            found.append(_answer([program, machine, scene], place, cache))
    return found


def _answer(program: list[str], place: Path, cache: Path) -> Answer:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    began, spent = perf_counter(), _spent_by_children()
    with subprocess.Popen(
        [sys.executable, "-c", *program],
        cwd=place, env=environment, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        printed = json.loads(process.stdout.readline())
        wall = perf_counter() - began
    return Answer(printed, _spent_by_children() - spent, wall, perf_counter() - began)


def _spent_by_children() -> float:
    """Processor time of all processes that have ended, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def report(quick: bool) -> list[Report]:
    """What the first results are made of; there is no rough measurement."""
    rows = measure()
    numbers = [(r.imports, r.translation, r.kernels, r.loop, r.run) for r in rows]
    table = [
        (r.result, r.machine, *(f"{s:.2f}" for s in parts), str(r.functions), f"{r.total:.2f}",
         f"{r.processes:.2f}", f"{r.wall:.2f}", f"{r.ended:.2f}")
        for r, parts in zip(rows, numbers, strict=True)
    ]  # fmt: skip
    headings = (
        "result", "machine", "imports", "translation", "kernels", "loop", "run", "functions",
        "processor, s", "all processes, s", "wall, s", "ended, s",
    )  # fmt: skip
    sentences = [verdict(f"{r.machine}, {r.result}:", r.wall, BARS[r.result], " s") for r in rows]
    title = "first result: processor time of its parts, in s, and what a person waits"
    return [Report("first_result", title, headings, table, sentences, records(rows), 2)]
