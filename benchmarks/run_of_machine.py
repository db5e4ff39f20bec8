"""One run of a machine of many parts, in a process of its own: ``... FAMILY SIZE FOLDER``.

Prints a `Run` as JSON. The machine's module lies in the folder, or is built there.
"""

import json
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.chain import SCENE
from benchmarks.growth import hanging
from benchmarks.net_reference import free_knots, knots_of_net
from benchmarks.problems import crank_of_loops
from models.hard.roller_chain import teeth
from runtime import Machine, Outcome, Result, load

RTOL, TIGHT, TARGET = 1e-6, 1e-9, 1e-6
LARGEST_DENSE = 100
"""Links of a chain whose dense equations are solved for comparison."""


@dataclass(frozen=True)
class Run:
    """A run at `RTOL`.

    Attributes
    ----------
    family, size, seconds
        Of the machine, and the length of its motion.
    outcome
        How it ended.
    coordinates, steps, evaluations, events, crossings
        Counts.
    cpu
        Processor time of `simulate`, s; of it, `integration`, s.
    error, against
        Largest difference, m or rad, and what from.
    energy
        Largest departure from the balance of energy, over the largest kinetic energy; NaN where
        forces have no potential.
    energy_at_target, cpu_at_target
        That of a run with `accuracy=` in place of a tolerance, and the processor time of all the
        runs that this takes, s.
    memory
        Largest of the process, with Python, the compiled runtime and the result, MB.
    """

    family: str
    size: int
    seconds: float
    outcome: str
    coordinates: int
    steps: int
    evaluations: int
    events: int
    crossings: int
    cpu: float
    integration: float
    error: float
    against: str
    energy: float
    energy_at_target: float
    cpu_at_target: float
    memory: float


@dataclass(frozen=True)
class Family:
    """A machine of any size: its declaration, the run, and the run's error.

    Attributes
    ----------
    declaration
        Text of the model file, with `{size}`.
    scene, seconds
        What is run, and for how long.
    error
        (machine, run, size) → largest error and what from.
    conservative
        Whether energy is kept.
    """

    declaration: str
    scene: str
    seconds: float
    error: Callable[[Machine, Result, int], tuple[float, str]]
    conservative: bool = True


def _tighter(machine: Machine, run: Result) -> Result:
    return machine.simulate(run.t[-1], run.t, rtol=TIGHT, progress=False)


def of_chain(machine: Machine, run: Result, links: int) -> tuple[float, str]:
    """Of the angles of all links at the end."""
    names = [f"link_{k}.phi" for k in range(links)]
    last = np.array([run.q(name)[-1] for name in names])
    if links <= LARGEST_DENSE:
        return float(np.abs(last - hanging(links, float(run.t[-1]))).max()), "SciPy"
    other = _tighter(machine, run)
    return float(max(np.abs(run.q(n) - other.q(n)).max() for n in names)), f"rtol {TIGHT:.0e}"


def of_loops(machine: Machine, run: Result, loops: int) -> tuple[float, str]:
    """Of the angles of all cranks and couplers at all instants; couplers stay level."""
    exact = np.pi / 2 - np.array([crank_of_loops(loops, t) for t in run.t])
    cranks = max(np.abs(run.q(f"crank_{k}.phi") - exact).max() for k in range(loops + 1))
    couplers = max(np.abs(run.q(f"coupler_{k}.phi")).max() for k in range(1, loops + 1))
    return float(max(cranks, couplers)), "closed form"


def of_net(machine: Machine, run: Result, side: int) -> tuple[float, str]:
    """Of the places of all knots at the end."""
    exact = knots_of_net(side, float(run.t[-1]))
    names = [f"knot_{i}_{j}" for i, j in free_knots(side)]
    found = np.array([[run.q(f"{name}.x")[-1], run.q(f"{name}.y")[-1]] for name in names])
    return float(np.abs(found - exact).max()), "SciPy"


def of_roller_chain(machine: Machine, run: Result, rollers: int) -> tuple[float, str]:
    """Of the driven sprocket's angle; a tooth that is jumped would miss by much more."""
    driving, driven = teeth(rollers)
    off = run.q("driven.phi")[-1] - run.q("driving.phi")[-1] * driving / driven
    assert abs(off) < np.pi / driven, f"the chain has jumped a tooth: {off} rad"
    other = _tighter(machine, run)
    return float(np.abs(run.q("driven.phi") - other.q("driven.phi")).max()), f"rtol {TIGHT:.0e}"


FAMILIES = {
    "chain": Family(
        "from benchmarks.chain import chain\nmodel = chain({size})\n", SCENE, 1.0, of_chain
    ),
    "n_four_bar": Family(
        "from models.hard.n_four_bar import n_four_bar\nmodel = n_four_bar({size})\n",
        "fall", 10.0, of_loops,
    ),
    "net": Family(
        "from models.hard.net import net\nmodel = net({size})\n", "fall", 1.0, of_net
    ),
    "roller_chain": Family(
        "from models.hard.roller_chain import roller_chain\nmodel = roller_chain({size})\n",
        "drive", 1.0, of_roller_chain, conservative=False,
    ),
}  # fmt: skip


def machine_of(name: str, size: int, folder: Path) -> Machine:
    """The machine, whose module and machine code stay in the folder."""
    family, path = FAMILIES[name], folder / f"{name}_{size}.py"
    text = family.declaration.format(size=size)
    if not path.is_file() or path.read_text() != text:
        path.write_text(text)
    return load(path, family.scene, folder=folder)


def run(name: str, size: int, folder: Path) -> Run:
    """Build what is missing, and run once for the machine code and once for the clock."""
    family, machine = FAMILIES[name], machine_of(name, size, folder)
    machine.simulate(family.seconds, rtol=RTOL, progress=False)
    began = time.process_time()
    result = machine.simulate(family.seconds, rtol=RTOL, progress=False)
    cpu = time.process_time() - began
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    stats = result.stats
    energy = energy_at_target = cpu_at_target = np.nan
    if family.conservative:
        energy, began = _drift(result), time.process_time()
        aimed = machine.simulate(family.seconds, accuracy=TARGET, progress=False)
        cpu_at_target = time.process_time() - began
        energy_at_target = _drift(aimed) if aimed.outcome is Outcome.OK else np.inf
    finished = result.outcome is Outcome.OK
    error, against = family.error(machine, result, size) if finished else (np.inf, "")
    return Run(
        name, size, family.seconds, result.outcome.name, len(machine.coordinates),
        int(stats["steps"] + stats["rejected"]), int(stats["rhs_evaluations"]),
        int(stats["events"]), int(stats["singular_crossings"]), cpu,
        float(stats["integration_seconds"]), error, against,
        energy, energy_at_target, cpu_at_target, memory,
    )  # fmt: skip


def _drift(result: Result) -> float:
    """Largest departure from the balance of energy, over the largest kinetic energy."""
    total = result.energy()
    return float(np.abs(total - total[0]).max() / np.abs(result.energy("kinetic")).max())


if __name__ == "__main__":
    _, chosen, parts, place = sys.argv
    print(json.dumps(asdict(run(chosen, int(parts), Path(place)))))
