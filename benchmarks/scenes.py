"""Savings by leaving out outputs and effects: scenes of one machine, operations and times."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kernel_timing import interleaved, many_solutions, no_solution
from codegen.reading.model_file import read_model
from models.coil_spring import machine as spring
from runtime import Machine, load

STATES = 64
MASSES = 50
FASTER = 1.3
"""A run of the coil spring alone, against the run with its striker: at least so many times."""


@dataclass(frozen=True)
class Row:
    """A question, a scene that answers it, and its cost."""

    question: str
    scene: str
    operations: int
    microseconds: float
    events: int


def kernels(folder: Path, count: int, repeats: int) -> tuple[Row, ...]:
    """Accelerations of quick return and compressor, in scenes with fewer outputs or effects."""
    crank = read_model("slider_crank").model
    compressor = crank.scene("compressor")
    machines = [
        ("quick return", load("quick_return", "shaper")),
        ("quick return", load("quick_return", "kinematics")),
        ("compressor", load(crank, compressor, folder=folder)),
        ("compressor", load(crank, compressor.with_(outputs=["energy"]), folder=folder)),
        ("compressor", load(crank, compressor.without("gas"), folder=folder)),
    ]
    runs = {"none": _solutions(machines[0][1], no_solution)}
    for _, machine in machines:
        runs[machine.scene] = _solutions(machine, machine.kernels.accelerations)
    found = interleaved(runs, count, repeats)
    return tuple(
        Row(
            f"accelerations, {question}",
            machine.scene,
            dict(machine.description.operations)["accelerations"],
            (found[machine.scene] - found["none"]) / 1e3,
            0,
        )
        for question, machine in machines
    )


def _solutions(machine: Machine, kernel: Any) -> Any:  # numba's dispatcher
    start, random = machine.assemble(), np.random.default_rng(1)
    states = start.q + 1e-3 * random.normal(size=(STATES, len(start.q)))
    rates = start.v + 1e-3 * random.normal(size=states.shape)
    modes = np.zeros((STATES, len(machine.description.switches)), dtype=np.int64)
    p, lam = machine.parameter_values(), np.zeros(len(machine.constraints))
    a = np.zeros(len(start.q))
    return lambda count: many_solutions(kernel, count, states, rates, p, modes, a, lam)


def springs(folder: Path, repeats: int, masses: int = MASSES) -> tuple[Row, ...]:
    """A minute of a long spring, struck, and with the striker that may come back.

    The time is that of the integration: putting a hundred and fifty coordinates together at the
    start, and evaluating what is reported, is the same for both.
    """
    model = spring(masses)
    rows = []
    for scene in ("surge", "impact"):
        machine = load(model, scene, folder=folder)
        machine.simulate(0.1, progress=False)
        best = np.inf
        for _ in range(repeats):
            run = machine.simulate(60.0, [0.0, 60.0], parameters={"k": 200.0}, progress=False)
            best = min(best, run.stats["integration_seconds"])
        counted = dict(machine.description.operations)["accelerations"]
        question = f"60 s of {masses} masses"
        rows.append(Row(question, scene, counted, best * 1e6, int(run.stats["events"])))
    return tuple(rows)
