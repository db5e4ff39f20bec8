"""Accuracy targets on random mechanisms: whether they are met, and what they cost.

``python -m tests.random_mechanisms.accuracy_runs --first 0 --count 50`` prints a line a target.
The true error is that from a reference, which another method confirms; the cost is the right-hand
sides of all runs of the search, over those of the cheapest single run that is as accurate: of every
method, at half decades of tolerance, in the formulations that are built. Where the reference is not
known to three tenths of the target, as in a chaotic motion, the target is not judged.
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from codegen.errors import LinkwrightError
from runtime import Machine, Outcome, load
from runtime.accuracy_target.run_comparison import difference
from runtime.accuracy_target.runs import Quantities, quantities_of
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.results.result import Result
from tests.random_mechanisms import Scales, random_mechanism

TARGETS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
KNOWN = 0.3  # of a target, by which the reference may be wrong
METHODS = ("dop853", "dopri5", "radau5", "bdf")
GRID = tuple(10.0 ** (-0.5 * k) for k in range(3, 24))
LEAST = 100  # right-hand sides; what needs fewer, at any tolerance, is counted as these
SAMPLES, MOST_STEPS = 201, 100_000


@dataclass(frozen=True)
class Judged:
    """One target of one mechanism."""

    target: float
    result: Result
    error: float  # the true one
    cheapest: float  # right-hand sides of the cheapest single run; infinite where none is
    setting: str  # of that run

    @property
    def met(self) -> bool:
        """Whether the result is whole and right."""
        return self.result.outcome is Outcome.OK and self.error <= self.target

    @property
    def cost(self) -> float:
        """Right-hand sides of all runs, over those of the cheapest."""
        return sum(run.evaluations for run in self.result.accuracy.runs) / max(LEAST, self.cheapest)

    def __str__(self) -> str:
        """One line."""
        runs = ", ".join(
            f"{run.method} {run.formulation} {run.rtol:.0e} {run.evaluations} {run.outcome}"
            for run in self.result.accuracy.runs
        )
        return (
            f"{self.target:.0e} {'met' if self.met else 'MISSED'}: {self.result.outcome.name}, "
            f"error {self.error:.1e}, estimated {self.result.accuracy.estimated:.1e}, cost "
            f"{self.cost:.2f}; {runs}; cheapest {self.setting} {self.cheapest:.0f}"
        )


def judge(
    machine: Machine, t_end: float, targets: Sequence[float], formulations: Sequence[str]
) -> Iterator[Judged]:
    """Every target whose reference is known well enough."""
    t = np.linspace(0.0, t_end, SAMPLES)
    ready = PreparedSimulation(
        machine.mechanism, t_end, t_start=0.0, parameters=None, guess=None, start=None
    )
    quantities = quantities_of(machine.description, None, ready.sizes)
    given = {"progress": False, "max_steps": MOST_STEPS}
    exact = machine.simulate(t_end, t, rtol=3e-14, correction="stage", **given)
    other = machine.simulate(t_end, t, rtol=1e-13, method="dopri5", **given)
    if exact.failed or other.failed:
        return
    floor, single = _error(exact, other, quantities), []
    for formulation in formulations:
        for method in METHODS:
            for rtol in GRID:
                try:
                    run = machine.simulate(
                        t_end, t, rtol=rtol, method=method, formulation=formulation, **given
                    )
                except LinkwrightError:
                    break
                if not run.failed:
                    error, count = _error(exact, run, quantities), run.stats["rhs_evaluations"]
                    single.append((count, error, f"{method} {formulation} {rtol:.0e}"))
    for target in targets:
        if floor <= KNOWN * target:
            enough = [(count, name) for count, error, name in single if error <= target]
            cheapest, name = min(enough, default=(np.inf, "none"))
            found = machine.simulate(t_end, t, accuracy=target, **given)
            yield Judged(target, found, _error(exact, found, quantities), cheapest, name)


def _error(exact: Result, run: Result, quantities: Quantities) -> float:
    """The largest |y - r| / (s + |r|), at the instants that both have."""
    count = min(len(exact.t), len(run.t))
    values = quantities.of_result(run), quantities.of_result(exact)
    return difference(exact.t[:count], *values, quantities).largest


def main() -> int:
    """The command; its exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--reduced", action="store_true", help="with reduced equations built")
    wanted = parser.parse_args()
    judged: list[Judged] = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(wanted.first, wanted.first + wanted.count):
            mechanism = random_mechanism(seed, scales=Scales())
            if not mechanism.freedoms:
                continue
            try:
                machine = load(mechanism.model(), mechanism.scene, folder=Path(folder))
                forms = ["cartesian"]
                if wanted.reduced:
                    assert machine.mechanism.reduced.kept.size
                    forms.append("reduced")
                for found in judge(machine, 2.0 * mechanism.horizon, TARGETS, forms):
                    judged.append(found)
                    sys.stdout.write(f"{seed:4d} {found}\n")
            except LinkwrightError as error:
                sys.stdout.write(f"{seed:4d} not run: {error}\n")
            sys.stdout.flush()
    costs = [one.cost for one in judged if np.isfinite(one.cheapest)]
    met = sum(one.met for one in judged)
    sys.stdout.write(f"{met} of {len(judged)} met; ")
    sys.stdout.write(f"cost {median(costs):.2f} in the median, {max(costs):.2f} at most\n")
    return 0 if met >= 0.99 * len(judged) else 1


if __name__ == "__main__":
    sys.exit(main())
