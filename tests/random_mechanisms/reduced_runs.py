"""Reduced runs of random mechanisms against runs in all coordinates: the same end, the same motion.

``python -m tests.random_mechanisms.reduced_runs --first 0 --count 100`` prints a line a mechanism
and ends with status 1 where a run in reduced coordinates ends before the one in all coordinates, or
moves otherwise. The kinds of mechanisms take turns, free and partly driven. Motions are compared as
long as two runs in all coordinates, at different tolerances, agree: a chaotic one cannot be
compared for longer by any means. A run that never was in reduced coordinates shows nothing and does
not count.
"""

import argparse
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar
from unittest import mock

import numpy as np

from codegen.errors import InputError, LinkwrightError
from runtime import load
from runtime.dynamics.changes_of_coordinates import Changes
from runtime.integrate.problem import Trajectory
from runtime.integrate.run import Run
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.random_mechanisms import FAMILIES, PLAIN, RandomMechanism, Scales, random_mechanism

SAME = 1e-8  # of a coordinate's size, by which motions may differ
KNOWN = 3e-9  # the same between two runs in all coordinates, a decade of tolerance apart
SOON = 1e-6  # of a run that ends in a singular position: by how much the other may end before it
LOOSE, TIGHT = 1e-12, 1e-13  # rtol
SAMPLES = 401
MOST_STEPS = 300_000
KINDS = (*FAMILIES, *PLAIN)
COMPARED = ("ok", "ENDED", "OTHERWISE")


@dataclass(frozen=True)
class Comparison:
    """What became of one mechanism in both formulations."""

    name: str
    whole: Result
    less: Result
    reached: float  # s, as far as the motions could be compared
    apart: float  # largest difference up to there, in sizes
    changes: int  # of the coordinates, between reduced and all
    share: float  # of the time, in reduced coordinates

    @property
    def verdict(self) -> str:
        """``"ok"``, or what is wrong."""
        early = self.whole.t[-1] - self.less.t[-1]
        if early > SOON * self.whole.t[-1] or (self.less.failed and not self.whole.failed):
            return f"ENDED {self.less.outcome.name} {self.less.message}"
        if self.apart > SAME:
            return "OTHERWISE"
        return "ok" if self.share > 0.0 else "never_reduced"

    def __str__(self) -> str:
        """One line."""
        steps = f"steps {self.whole.stats['steps']} {self.less.stats['steps']}"
        return (
            f"{self.verdict}: to {self.reached:.2f} of {self.whole.t[-1]:.2f} s within "
            f"{self.apart:.1e}, {self.changes} changes, {self.share:.0%} reduced, "
            f"{self.whole.outcome.name}, {steps}; {self.name}"
        )


def compare(mechanism: RandomMechanism, t_end: float, folder: Path) -> Comparison:
    """Run a mechanism in both formulations; InputError where it has no reduced equations."""
    machine = load(mechanism.model(), mechanism.scene, folder=folder)
    name = f"seed {mechanism.seed}, {mechanism.freedoms} free, {mechanism.kind}"
    return compare_runs(machine, name, t_end)


def compare_runs(
    machine: Machine, name: str, t_end: float, parameters: dict[str, float] | None = None
) -> Comparison:
    """Run a machine in both formulations."""
    t = np.linspace(0.0, t_end, SAMPLES)
    given = {"progress": False, "max_steps": MOST_STEPS, "parameters": parameters}
    _Watched.seen = legs = []
    with mock.patch("runtime.dynamics.formulations.Changes", _Watched):
        less = machine.simulate(t_end, t, rtol=TIGHT, formulation="reduced", **given)
    whole = machine.simulate(t_end, t, rtol=TIGHT, **given)
    sure = machine.simulate(t_end, t, rtol=LOOSE, **given)
    common = min(len(whole.t), len(less.t), len(sure.t), SAMPLES)
    known = _first_beyond(_apart(whole, sure, common), KNOWN)
    known = min(known, common)
    apart = float(_apart(whole, less, known).max(initial=0.0))
    reached = float(whole.t[known - 1]) if known else 0.0
    within = sum(end - begin for reduced, begin, end in legs if reduced)
    share = within / max(float(less.t[-1]), 1e-300)
    return Comparison(name, whole, less, reached, apart, len(legs) - 1, share)


class _Watched(Changes):
    """A reduced run that records its legs: whether reduced, begin and end in s."""

    seen: ClassVar[list[tuple[bool, float, float]]] = []

    def _finish(self, run: Run, path: Trajectory) -> Trajectory:
        self.seen.append((run is self.less, self.start[0], path.final_t))
        return super()._finish(run, path)


def _apart(one: Result, other: Result, count: int) -> np.ndarray:
    """Largest difference at each of the first samples, in the sizes of coordinates."""
    differences = []
    for a, b in ((one.samples.q, other.samples.q), (one.samples.v, other.samples.v)):
        size = 1.0 + np.maximum.accumulate(np.abs(a[:count]), axis=0)
        differences.append(np.abs(a[:count] - b[:count]) / size)
    return np.max(np.concatenate(differences, axis=1), axis=1, initial=0.0)


def _first_beyond(differences: np.ndarray, limit: float) -> int:
    beyond = np.flatnonzero(~(differences <= limit))
    return int(beyond[0]) if len(beyond) else len(differences)


def main() -> int:
    """The command; its exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--t-end", type=float, default=10.0)
    parser.add_argument("--family", choices=KINDS, help="of all mechanisms; else all take turns")
    parser.add_argument("--folder", type=Path, help="where generated files stay; else nowhere")
    wanted = parser.parse_args()
    seen: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(wanted.first, wanted.first + 10 * wanted.count):
            mechanism = of_turn(seed, wanted.family)
            try:
                found = compare(mechanism, wanted.t_end, wanted.folder or Path(folder))
                word, line = found.verdict.split(" ")[0], str(found)
            except LinkwrightError as error:
                word = "refused" if isinstance(error, InputError) else "not run"
                line = f"{word}: {error}; {mechanism.kind}"
            seen[word] += 1
            sys.stdout.write(f"{seed:4d} {line}\n")
            sys.stdout.flush()
            if sum(seen[word] for word in COMPARED) >= wanted.count:
                break
    sys.stdout.write(f"{dict(seen)}\n")
    return 1 if seen["ENDED"] or seen["OTHERWISE"] else 0


def of_turn(seed: int, family: str | None = None) -> RandomMechanism:
    """The mechanism of a seed: the kinds take turns, first free, then partly driven."""
    lap, kind = divmod(seed, len(KINDS))
    driven = ("free", "partly")[lap % 2 if family is None else seed % 2]
    return random_mechanism(seed, family or KINDS[kind], driven, scales=Scales())


if __name__ == "__main__":
    sys.exit(main())
