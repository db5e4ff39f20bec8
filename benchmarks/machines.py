"""All machines of the library: the accelerations' time an operation, and beside hand-derived ones.

The kernel `accelerations` answers all accelerations and all multipliers. Its bar is a hand-derived
equation in the one coordinate that is left of the machine, and on a machine without one, the time
that a weighted operation takes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import kernel_timing
from benchmarks.hand import linkages, quick_return, slider_crank
from benchmarks.twins import Array, Generated, States, Twin, generate, run_of
from runtime import load

STATES = 256
BAR = 3.0
"""Accelerations and multipliers may take this many times the hand-derived acceleration alone."""
PACE = 0.5
"""Nanoseconds that a weighted operation may take."""
KERNEL = "accelerations"


@dataclass(frozen=True)
class Machine:
    """A machine as it is measured.

    Attributes
    ----------
    name, scene
        Model and scene.
    duration
        Of the run from which the states are, s: a turn or so, as steps of an integration follow one
        another closely.
    crank
        Coordinate of the hand-derived equation, and of its acceleration among the outputs.
    hand
        The equation, if there is one.
    prepare
        The machine's parameters → what the equation takes.
    """

    name: str
    scene: str
    duration: float
    crank: int = 2
    hand: Any = None
    prepare: Callable[[Array], Array] = np.copy


MACHINES = (
    Machine("slider_crank", "compressor", 0.25, hand=slider_crank.crank_acceleration),
    Machine("quick_return", "shaper", 0.5, 5, quick_return.quick_return),
    Machine(
        "four_bar",
        "constant_torque",
        1.0,
        hand=linkages.four_bar,
        prepare=linkages.four_bar_parameters,
    ),
    Machine("web_cutter", "running", 1.0, hand=linkages.web_cutter),
    Machine("film_follower", "motor", 2.0),
    Machine("gear_slider", "train_running", 2.0),
    Machine("rack_and_pinion", "running", 1.0),
    Machine("coil_spring", "impact", 2.0),
    Machine("valve_lifter", "free_follower", 0.02),
)
REDUCED = tuple(machine for machine in MACHINES if machine.hand is not None)


@dataclass(frozen=True)
class Row:
    """What the accelerations of a machine cost, in operations and nanoseconds a call."""

    machine: str
    scene: str
    operations: int
    cost: int
    nanoseconds: float
    pace: float


def generated(machine: Machine, folder: Path) -> Generated:
    """The machine's accelerations, and the conditions that they depend on."""
    return generate(machine.name, machine.scene, (KERNEL, "switching"), folder)


def states(machine: Machine, made: Generated, changed: Mapping[str, float] | None = None) -> States:
    """States through which a run goes, at equal distances of time, with some parameters changed."""
    instants = np.linspace(0.0, machine.duration, STATES)
    run = load(machine.name, scene=machine.scene).simulate(
        machine.duration, instants, rtol=1e-10, parameters=changed, progress=False
    )
    q, v = (np.ascontiguousarray(run.data[name].values) for name in "qv")
    count, p = len(made.module.SWITCHES), made.values(changed or {})
    modes = np.zeros((len(q), count), dtype=np.int64)
    for k, g in enumerate(np.zeros((len(q), count))):
        if count:
            made.module.switching(instants[k], q[k], v[k], p, g)
        modes[k] = g > 0
    return States(q, v, modes)


def twins(
    machines: Sequence[Machine], folder: Path, changed: Mapping[str, float] | None = None
) -> list[Twin]:
    """The machines with an equation of one degree of freedom, beside it."""
    found = []
    for machine in machines:
        made = generated(machine, folder)
        where, p = states(machine, made, changed), made.values(changed or {})
        slots = (machine.crank,)
        hand_p = machine.prepare(p)
        found.append(Twin(machine.name, KERNEL, made, machine.hand, where, slots, p, hand_p))
    return found


def measure(machines: Sequence[Machine], folder: Path, count: int, repeats: int) -> tuple[Row, ...]:
    """All machines, timed in one run, in turns."""
    made = {machine: generated(machine, folder) for machine in machines}
    runs = {}
    for machine, one in made.items():
        where = states(machine, one)
        runs[machine.name] = run_of(KERNEL, one.module.accelerations, where, one.p)
        runs[f"{machine.name} loop"] = run_of(KERNEL, kernel_timing.no_solution, where, one.p)
    best = kernel_timing.interleaved(runs, count, repeats)
    rows = []
    for machine, one in made.items():
        number, weighted = one.counts[KERNEL]
        net = best[machine.name] - best[f"{machine.name} loop"]
        rows.append(Row(machine.name, machine.scene, number, weighted, net, net / weighted))
    return tuple(rows)
