"""Many cases of one generator over several processes, each case with a limit of processor time."""

import argparse
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing import get_context
from random import Random
from typing import NamedTuple

_SHARDS = 8  # that a process takes
PATIENCE = 10.0  # by the clock, for each second of the processor that a case may take
SHOWN = 40  # findings that a report lists


class Finding(NamedTuple):
    """A case that did not end as it should."""

    number: int
    text: str


@dataclass
class Campaign:
    """The outcome of many cases."""

    generator: str
    seed: int
    cases: int
    seconds: float
    slowest: tuple[float, int]  # (seconds, number) of the case that took longest
    findings: list[Finding] = field(default_factory=list)

    def report(self) -> str:
        """A line of sums, then the findings, alike ones together."""
        head = f"{self.generator}, seed {self.seed}: {self.cases} cases in {self.seconds:.0f} s"
        slowest = f"the slowest case, number {self.slowest[1]}, took {self.slowest[0]:.1f} s"
        lines = [f"{head}, {len(self.findings)} findings; {slowest}"]
        kinds: dict[str, list[Finding]] = {}
        for finding in self.findings:
            kinds.setdefault(finding.text.partition("\n")[0][:90], []).append(finding)
        ordered = sorted(kinds.values(), key=len, reverse=True)
        for alike in ordered[:SHOWN]:
            first = alike[0]
            lines.append(f"\n{len(alike)} like case {first.number}: {first.text}")
        return "\n".join(lines) + "\n"


class OverTimeError(KeyboardInterrupt):
    """A case takes longer than it may; nothing that is fuzzed catches the wish to stop."""


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise `OverTimeError` in a block that takes more seconds of the processor.

    Those of the processes that it starts and waits for count as well. They do not depend on what
    else the machine does, as a case that compiles, for seconds of its own, would show. A block that
    waits for something uses none: it may take `PATIENCE` times as long by the clock.
    """
    used, started = _processor_seconds(), time.perf_counter()

    def over() -> bool:
        waited = time.perf_counter() - started
        return _processor_seconds() - used > seconds or waited > PATIENCE * seconds

    def look(*_: object) -> None:
        if over():
            raise OverTimeError

    before = signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, *[min(0.25, seconds / 4)] * 2)
    try:
        yield
        look()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _processor_seconds() -> float:
    """Seconds of the processor that this process and its ended children have used."""
    return sum(os.times()[:4])


def case(generator: str, seed: int, number: int, limit: float) -> str | None:
    """What is wrong about one case; None: nothing."""
    judge = import_module(f"tests.fuzz.{generator}").judge
    try:
        with limited(limit):
            found: str | None = judge(Random(f"{generator} {seed} {number}"))
            return found
    except OverTimeError:
        where = traceback.format_exc(limit=-6)
        return f"hangs: more than {limit:g} s of the processor, or it waits\n{where}"


def shard(generator: str, seed: int, numbers: Sequence[int], limit: float) -> Campaign:
    """The cases of some numbers, one after the other."""
    found = Campaign(generator, seed, len(numbers), 0.0, (0.0, 0))
    getattr(import_module(f"tests.fuzz.{generator}"), "prepare", bool)()  # imports, compiles
    started = time.perf_counter()
    for number in numbers:
        before = time.perf_counter()
        if text := case(generator, seed, number, limit):
            found.findings.append(Finding(number, text))
        found.slowest = max(found.slowest, (time.perf_counter() - before, number))
    found.seconds = time.perf_counter() - started
    return found


def silent(_: str) -> object:
    """Say nothing of a campaign under way."""
    return None


def run(
    generator: str,
    seed: int,
    numbers: Sequence[int],
    limit: float = 20.0,
    workers: int = 1,
    say: Callable[[str], object] = silent,
) -> Campaign:
    """The cases of some numbers, shared among processes; `say` gets the report of each shard."""
    started = time.perf_counter()
    size = max(1, min(500, len(numbers) // workers))
    parts = [numbers[k : k + size] for k in range(0, len(numbers), size)]
    whole = Campaign(generator, seed, len(numbers), 0.0, (0.0, 0))

    def add(found: Campaign) -> None:
        say(found.report())
        whole.findings += found.findings
        whole.slowest = max(whole.slowest, found.slowest)

    for part in parts if workers == 1 else ():
        add(shard(generator, seed, part, limit))
    # New processes after some shards: caches of expressions grow. (A pool that replaces its workers
    # itself, by `max_tasks_per_child`, waits for ever when all have done their tasks.)
    for k in range(0, len(parts) if workers > 1 else 0, _SHARDS * workers):
        with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
            some = parts[k : k + _SHARDS * workers]
            futures = [pool.submit(shard, generator, seed, part, limit) for part in some]
            for future in futures:
                add(future.result())
    whole.seconds = time.perf_counter() - started
    return whole


def main(generator: str) -> int:
    """The command of a generator; exit status 1 where there are findings."""
    parser = argparse.ArgumentParser(prog=f"python -m tests.fuzz {generator}")
    parser.add_argument("--count", type=int, default=1000, help="cases")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--limit", type=float, default=20.0, help="processor seconds of a case")
    words = parser.parse_args()
    numbers = range(words.first, words.first + words.count)
    found = run(generator, words.seed, numbers, words.limit, words.workers, _print)
    _print(found.report())
    return 1 if found.findings else 0


def _print(report: str) -> None:
    """Show a report at once, so that an interruption loses nothing."""
    sys.stdout.write(report)
    sys.stdout.flush()
