"""Generated kernels beside hand-written ones: the same numbers, what they cost, their times."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks import kernel_timing
from benchmarks.operation_counts import cost, operations
from codegen import Model
from codegen.driver import GENERATOR, translate
from codegen.emit.module import module_text
from codegen.files.generated_modules import import_generated
from codegen.generated_files.generated_file import Clock, write_if_changed
from codegen.generated_files.provenance import origin
from codegen.lower import operation_count as ledger
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes

Array = npt.NDArray[np.float64]
Modes = npt.NDArray[np.int64]
RESOLUTION = 1.0
"""Nanoseconds below which a net time is the loop's noise; shorter ones count as this in a ratio."""
OUTPUTS = 96
"""Room for what any kernel here writes."""
LAMBDA = np.random.default_rng(3).uniform(-2.0, 2.0, OUTPUTS)
"""The multipliers that kernels take."""
LOOPS: dict[str, tuple[Any, Any]] = {
    "jacobian": (kernel_timing.many_positions, kernel_timing.no_position),
    "acceleration_rhs": (kernel_timing.many_velocities, kernel_timing.no_velocity),
    "applied_forces": (kernel_timing.many_forces, kernel_timing.no_force),
    "accelerations": (kernel_timing.many_solutions, kernel_timing.no_solution),
    "powers": (kernel_timing.many_powers, kernel_timing.no_power),
}


@dataclass(frozen=True)
class States:
    """Where kernels are called: q and v, each (k, n), and the modes, (k, s)."""

    q: Array
    v: Array
    modes: Modes


@dataclass(frozen=True)
class Generated:
    """A scene's kernels in machine code, and what each costs: (operations, weighted)."""

    module: ModuleType
    counts: dict[str, tuple[int, int]]

    @property
    def p(self) -> Array:
        """Defaults, and what follows from them."""
        return self.values({})

    def values(self, changed: Mapping[str, float]) -> Array:
        """Parameters, some of them changed, and what follows from them."""
        values = [changed.get(name, default) for name, default, _, _ in self.module.PARAMETERS]
        p = np.array([*values, *[0.0] * len(self.module.CONSTANTS)])
        self.module.constants(p)
        return p


@dataclass(frozen=True)
class Twin:
    """A generated kernel and its twin, which may take parameters of its own.

    Attributes
    ----------
    subject, kernel
        What is measured, and the generated kernel's name.
    hand
        The compiled function.
    outputs
        Slots of the output that both fill.
    p, hand_p
        Parameters of either.
    """

    subject: str
    kernel: str
    generated: Generated
    hand: Any
    states: States
    outputs: Sequence[int]
    p: Array
    hand_p: Array


@dataclass(frozen=True)
class Row:
    """What was found of a pair of twins; nanoseconds a call."""

    subject: str
    kernel: str
    operations: int
    hand_operations: int
    cost: int
    hand_cost: int
    nanoseconds: float
    hand_nanoseconds: float
    ratio: float
    difference: float


def generate(model: Model | str, scene: str, kernels: Sequence[str], folder: Path) -> Generated:
    """The named kernels alone, so that nothing is compiled that is not measured."""
    file = read_model(model)
    chosen = valid_scenes(file.model, scene)[0]
    equations, lowered, _ = translate(file.model, chosen, Clock({}, lambda message: None, ""))
    program = lowered.program
    measured = tuple(k for k in program.kernels if k.name in ("constants", *kernels))
    path = folder / f"{file.model.name}__{scene}__measured.py"
    text = module_text(
        replace(lowered, program=replace(program, kernels=measured)),
        origin(GENERATOR, file, equations, path, {}),
    )
    write_if_changed(path, text)
    counts = {
        k.name: (ledger.operations(program, k), ledger.weighted_operations(program, k))
        for k in measured
    }
    return Generated(import_generated(path), counts)


def call(name: str, kernel: Any, states: States, k: int, p: Array) -> Array:
    """What a kernel of this name writes at state `k`: its outputs, one after the other."""
    out, lam = np.zeros(OUTPUTS), np.zeros(OUTPUTS)
    q, v, modes = states.q[k], states.v[k], states.modes[k]
    if name == "jacobian":
        kernel(kernel_timing.TIME, q, p, out)
    elif name == "acceleration_rhs":
        kernel(kernel_timing.TIME, q, v, p, out)
    elif name == "applied_forces":
        kernel(kernel_timing.TIME, q, v, p, modes, out)
    elif name == "powers":
        kernel(kernel_timing.TIME, q, v, p, modes, LAMBDA, out)
    elif weak := kernel(kernel_timing.TIME, q, v, p, modes, out, lam):
        raise ArithmeticError(f"{name}: pivot {weak} is weak at q = {q}")
    return out


def difference(twin: Twin) -> float:
    """Largest difference between the twins over all states, in parts of the largest value."""
    module, outputs = twin.generated.module, list(twin.outputs)
    kernel, count = getattr(module, twin.kernel), len(twin.states.q)
    ours = np.array([call(twin.kernel, kernel, twin.states, k, twin.p) for k in range(count)])
    theirs = np.array(
        [call(twin.kernel, twin.hand, twin.states, k, twin.hand_p) for k in range(count)]
    )
    ours, theirs = ours[:, outputs], theirs[:, outputs]
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


def measure(twins: Sequence[Twin], count: int, repeats: int) -> tuple[Row, ...]:
    """Each pair and its empty loop, in turns; `count` calls a turn, `repeats` turns."""
    rows = []
    for twin in twins:
        ours = getattr(twin.generated.module, twin.kernel)
        sides = (
            ("generated", ours, twin.p),
            ("hand", twin.hand, twin.hand_p),
            ("loop", LOOPS[twin.kernel][1], twin.p),
        )
        runs = {side: run_of(twin.kernel, kernel, twin.states, p) for side, kernel, p in sides}
        best = kernel_timing.interleaved(runs, count, repeats)
        net = {name: best[name] - best["loop"] for name in ("generated", "hand")}
        number, weighted = twin.generated.counts[twin.kernel]
        rows.append(
            Row(
                twin.subject,
                twin.kernel,
                number,
                operations(twin.hand),
                weighted,
                cost(twin.hand),
                net["generated"],
                net["hand"],
                max(net["generated"], RESOLUTION) / max(net["hand"], RESOLUTION),
                difference(twin),
            )
        )
    return tuple(rows)


def run_of(name: str, kernel: Any, states: States, p: Array) -> Callable[[int], float]:
    """A loop that calls a kernel of this name so many times, in machine code."""
    loop, _ = LOOPS[name]
    out, lam = np.zeros(OUTPUTS), np.zeros(OUTPUTS)
    arguments: dict[str, tuple[Any, ...]] = {
        "jacobian": (states.q, p, out),
        "acceleration_rhs": (states.q, states.v, p, out),
        "applied_forces": (states.q, states.v, p, states.modes, out),
        "accelerations": (states.q, states.v, p, states.modes, out, lam),
        "powers": (states.q, states.v, p, states.modes, LAMBDA, out),
    }
    rest = arguments[name]
    return lambda count: loop(kernel, count, *rest)
