"""Reduced runs of random mechanisms against runs in all coordinates: the same end, the same motion.

``python -m tests.random_mechanisms.reduced_runs --first 0 --count 100`` prints a line a mechanism
and ends with status 1 where a run in reduced coordinates ends before the one in all coordinates, or
moves otherwise. Motions are compared as long as two runs in all coordinates, at different
tolerances, agree: a chaotic one cannot be compared for longer by any means.
"""

import argparse
import sys
import tempfile
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from codegen.errors import InputError, LinkwrightError
from runtime import load
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.random_mechanisms import RandomMechanism, Scales, random_mechanism

SAME = 1e-8  # of a coordinate's size, by which motions may differ
KNOWN = 1e-9  # the same between two runs in all coordinates
TIGHT, TIGHTER = 1e-12, 3e-13  # rtol
SAMPLES = 401
MOST_STEPS = 300_000


@dataclass(frozen=True)
class Comparison:
    """What became of one mechanism in both formulations."""

    name: str
    whole: Result
    less: Result
    reached: float  # s, as far as the motions could be compared
    apart: float  # largest difference up to there, in sizes
    changes: int  # of the coordinates, between reduced and all

    @property
    def verdict(self) -> str:
        """``"ok"``, or what is wrong."""
        if self.less.t[-1] < self.whole.t[-1] and self.less.outcome is not self.whole.outcome:
            return f"ENDED {self.less.outcome.name} {self.less.message}"
        return "ok" if self.apart <= SAME else "OTHERWISE"

    def __str__(self) -> str:
        """One line."""
        return (
            f"{self.verdict}: to {self.reached:.2f} of {self.whole.t[-1]:.2f} s within "
            f"{self.apart:.1e}, {self.changes} changes, {self.whole.outcome.name}, steps "
            f"{self.whole.stats['steps']} {self.less.stats['steps']}; {self.name}"
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
    less = machine.simulate(t_end, t, rtol=TIGHT, formulation="reduced", **given)
    whole = machine.simulate(t_end, t, rtol=TIGHT, **given)
    sure = machine.simulate(t_end, t, rtol=TIGHTER, **given)
    common = min(len(whole.t), len(less.t), len(sure.t), SAMPLES)
    known = _first_beyond(_apart(whole, sure, common), KNOWN)
    known = min(known, common)
    apart = float(_apart(whole, less, known).max(initial=0.0))
    reached = float(whole.t[known - 1]) if known else 0.0
    kept = {machine.coordinates.names[k] for k in machine.mechanism.reduced.kept}
    inside = [set(p.independent) <= kept for p in less.partitions]
    changes = sum(a != b for a, b in pairwise(inside))
    return Comparison(name, whole, less, reached, apart, changes)


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
    parser.add_argument("--family")
    parser.add_argument("--folder", type=Path, help="where generated files stay; else nowhere")
    wanted = parser.parse_args()
    wrong, compared, seed = 0, 0, wanted.first
    with tempfile.TemporaryDirectory() as folder:
        while compared < wanted.count:
            mechanism = random_mechanism(seed, wanted.family, scales=Scales())
            seed += 1
            if not mechanism.freedoms:
                continue
            try:
                found = compare(mechanism, wanted.t_end, wanted.folder or Path(folder))
            except InputError as error:
                sys.stdout.write(f"{mechanism.seed:4d} refused: {error}\n")
                continue
            except LinkwrightError as error:
                sys.stdout.write(f"{mechanism.seed:4d} not run: {error}\n")
                continue
            sys.stdout.write(f"{found}\n")
            compared += 1
            wrong += found.verdict != "ok"
    sys.stdout.write(f"{compared} compared, {wrong} wrong\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
