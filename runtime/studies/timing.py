"""Processor times of runs that are compared, on a machine that others use as well; its facts.

Processor time is measured, not wall-clock time: the scheduler interrupts a run longer than its time
slice nearly every time where processors are busy, a short run hardly ever, so that wall-clock time
would overstate the longer run. Other processes only ever lengthen a run, through the caches, and
for a while at a time: runs are therefore repeated in turns, and the least time counts.
"""

import math
import platform
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter, process_time
from typing import TypeVar

from codegen import __version__

LIBRARIES = ("numba", "llvmlite", "numpy", "scipy", "sympy")
MOST = 30  # safety: runs by which a time is taken, however short
Answer = TypeVar("Answer")


def processor_time(run: Callable[[], Answer]) -> tuple[Answer, float]:
    """The answer of a run, and its processor time in s."""
    started = process_time()
    answer = run()
    return answer, process_time() - started


class TimeLimit:
    """Progress callback that interrupts a run which takes too long; compilation does not count."""

    def __init__(self, limit: float) -> None:
        self.limit, self.exceeded = limit, False
        self.started: float | None = None

    def __call__(self, fraction: float) -> None:
        """Note the first sign of life; interrupt once the limit has passed since."""
        if self.started is None:
            self.started = perf_counter()
        elif perf_counter() - self.started > self.limit:
            self.exceeded = True
            raise KeyboardInterrupt  # ends the run with the part that it has computed


def time_runs(
    runs: Iterable[Callable[[], float | None]], first: Sequence[float], rounds: int, least: float
) -> list[list[float]]:
    """Processor times of runs, s, which take turns until each is done or, None, is cut short.

    Each is run `rounds` times and for `least` s, or `MOST` times; of one that takes `least` alone
    two times are enough. That of a `first` run counts only if it was long: a short one met cold
    caches.
    """
    times = [[seconds] if seconds >= least else [] for seconds in first]
    waiting = dict(enumerate(runs))
    while waiting:
        for k, run in [*waiting.items()]:
            seconds, found = run(), times[k]
            found += [] if seconds is None else [seconds]
            enough = rounds if sum(found) >= least else MOST
            if seconds is None or len(found) >= (2 if min(found) >= least > 0.0 else enough):
                del waiting[k]
    return [found or [seconds] for found, seconds in zip(times, first, strict=True)]


def time_to_error(points: Iterable[tuple[float, float]], error: float) -> float | None:
    """Time in which runs, from the loosest to the tightest, first reach an error.

    Interpolated between the (error, time) of the run that reaches it and of the run before,
    logarithm over logarithm; the time of the first run if that reaches it; None if no run does.
    """
    loose: tuple[float, float] | None = None
    for worst, seconds in points:
        if worst <= error:
            if loose is None or math.isinf(loose[0]):
                return seconds
            far, near = math.log(loose[0]), math.log(max(worst, 1e-17))
            share = (far - math.log(error)) / (far - near)
            fast, slow = math.log(loose[1]), math.log(seconds)
            return math.exp(fast + share * (slow - fast))
        loose = worst, seconds
    return None


def environment() -> dict[str, str]:
    """Processor, operating system and versions: name → text."""
    facts = {
        "machine": processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "linkwright": __version__,
    }
    for name in LIBRARIES:
        with suppress(PackageNotFoundError):  # a library in a bundle may come without metadata
            facts[name] = version(name)
    return facts


def processor() -> str:
    """Name of the processor."""
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
