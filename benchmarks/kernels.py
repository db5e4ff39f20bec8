"""The generated slider-crank against its hand-written twins: same numbers, and how fast."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import numpy.typing as npt

from benchmarks.hand import slider_crank as hand
from benchmarks.kernel_timing import (
    interleaved,
    many_positions,
    many_solutions,
    many_velocities,
    no_position,
    no_solution,
    no_velocity,
)
from benchmarks.operation_counts import operations
from benchmarks.states import turn_of_the_crank
from codegen import build
from codegen.files.generated_modules import import_generated

STATES = 256
BAR = 2.0
"""The accelerations and multipliers may take this many times the hand-derived φ̈₁ alone."""


@dataclass(frozen=True)
class Row:
    """One generated kernel beside the hand-written one."""

    generated: str
    hand: str
    operations: int
    hand_operations: int
    nanoseconds: float
    hand_nanoseconds: float
    difference: float

    @property
    def ratio(self) -> float:
        """Time of the generated kernel in times of the hand-written one."""
        return self.nanoseconds / self.hand_nanoseconds


def generated(folder: Path | None = None) -> ModuleType:
    """The library's compressor, in machine code."""
    return import_generated(build("slider_crank", scene="compressor", out=folder).paths[0])


def parameters(module: ModuleType) -> npt.NDArray[np.float64]:
    """Defaults, and what follows from them."""
    values = [default for _, default, _, _ in module.PARAMETERS]
    p = np.array([*values, *[0.0] * len(module.CONSTANTS)])
    module.constants(p)
    return p


def differences(module: ModuleType) -> dict[str, float]:
    """Largest difference between the twins over a turn, in parts of the largest value."""
    p = parameters(module)
    q, v, modes = turn_of_the_crank(STATES, p[1])
    pairs: dict[str, list[tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]] = {
        name: [] for name in ("jacobian", "acceleration_rhs", "accelerations")
    }
    for k in range(STATES):
        one, two = np.zeros(18), np.zeros(18)
        module.jacobian(0.0, q[k], p, one)
        hand.jacobian(0.0, q[k], p, two)
        pairs["jacobian"].append((one, two))
        one, two = np.zeros(8), np.zeros(8)
        module.acceleration_rhs(0.0, q[k], v[k], p, one)
        hand.acceleration_rhs(0.0, q[k], v[k], p, two)
        pairs["acceleration_rhs"].append((one, two))
        one, two, lam = np.zeros(9), np.zeros(9), np.zeros(8)
        if module.accelerations(0.0, q[k], v[k], p, modes[k], one, lam):
            raise ArithmeticError(f"a weak pivot at crank angle {q[k, 2]}")
        hand.crank_acceleration(0.0, q[k], v[k], p, modes[k], two, lam)
        pairs["accelerations"].append((one[2:3], two[2:3]))
    found = {}
    for name, twins in pairs.items():
        ours, theirs = (np.array(side) for side in zip(*twins, strict=True))
        found[name] = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
    return found


def measure(count: int, repeats: int) -> tuple[Row, ...]:
    """All twins, timed in one run."""
    with tempfile.TemporaryDirectory() as folder:
        return measure_twins(generated(Path(folder) / "generated"), count, repeats)


def measure_twins(module: ModuleType, count: int, repeats: int) -> tuple[Row, ...]:
    p = parameters(module)
    q, v, modes = turn_of_the_crank(STATES, p[1])
    out, a, lam = np.zeros(32), np.zeros(9), np.zeros(8)
    runs: dict[str, Callable[[int], float]] = {}
    sides = {
        "generated": (module.jacobian, module.acceleration_rhs, module.accelerations),
        "hand": (hand.jacobian, hand.acceleration_rhs, hand.crank_acceleration),
        "loop": (no_position, no_velocity, no_solution),
    }
    for side, (first, second, third) in sides.items():
        runs[f"{side} jacobian"] = lambda n, f=first: many_positions(f, n, q, p, out)
        runs[f"{side} acceleration_rhs"] = lambda n, f=second: many_velocities(f, n, q, v, p, out)
        runs[f"{side} accelerations"] = lambda n, f=third: many_solutions(
            f, n, q, v, p, modes, a, lam
        )
    times = interleaved(runs, count, repeats)

    def net(side: str, name: str) -> float:
        return times[f"{side} {name}"] - times[f"loop {name}"]

    counts, gaps = dict(module.OPERATIONS), differences(module)
    return tuple(
        Row(
            name,
            twin,
            counts[name],
            operations(getattr(hand, twin)),
            net("generated", name),
            net("hand", name),
            gaps[name],
        )
        for name, twin in (
            ("jacobian", "jacobian"),
            ("acceleration_rhs", "acceleration_rhs"),
            ("accelerations", "crank_acceleration"),
        )
    )
