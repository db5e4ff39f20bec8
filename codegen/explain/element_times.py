"""Times of the parts of a scene: of an evaluation of `accelerations`, and of a run.

This is the one place where the compiler uses the runtime: when a run is requested, not when the
module is imported. The import rules name the exception.

Kernels are timed in turns inside one compiled loop, at states about the start or along a run. Other
work on the computer only adds to a time, so the minimum of many rounds is kept, and every kernel
has its turn in each round, so that all see the same conditions. The loop with an empty kernel takes
its turn too, and its time is subtracted; as numba takes about 0.1 ms to pass a function, every turn
has the same number of calls.
"""

import math
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit, types

from codegen.declare.scene import Scene
from codegen.derive.equations import Equations
from codegen.emit.kernel import Arguments
from codegen.emit.module import Origin, assemble_module
from codegen.errors import InputError
from codegen.explain.ledger import Ledger, Part, RunCosts
from codegen.explain.operations_by_part import Stage, timing_stages
from codegen.files.generated_modules import import_generated
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import Lowered
from codegen.lower.poses_near_start import Poses
from codegen.lower.program import Program

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

F8, VECTOR, ROWS = types.float64, types.float64[::1], types.float64[:, ::1]
MODES, MODE_ROWS = types.int64[::1], types.int64[:, ::1]
SIGNATURE = types.int64(F8, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR)
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy"}

TURN = 5e-4  # measured: s; time of the slowest kernel in a round
ROUNDS = 500  # measured: rounds, of which the shortest time of each kernel counts
COUNT = 64  # measured: states at which kernels are timed
SPREAD = 1e-3  # measured: m or rad, and m/s or rad/s; spread of the states about a start
ORIGIN = Origin("linkwright", (), "0" * 64, "python -m codegen explain")
MEASURED = 2  # measured: runs, of which the faster counts; the first may find cold caches


class States(NamedTuple):
    """Instants at which kernels are called: (k,), (k, n), (k, n), (k, s)."""

    t: Floats
    q: Floats
    v: Floats
    modes: Integers


class Timed(NamedTuple):
    """A kernel `accelerations`, its parameters with the constants, and how long λ must be."""

    kernel: Any
    p: Floats
    slots: int


def _loop(
    kernel: Any, t: Any, q: Any, v: Any, modes: Any, p: Any, a: Any, lam: Any, count: int
) -> float:
    total, row = 0.0, 0
    q_now, v_now, modes_now = q[0].copy(), v[0].copy(), modes[0].copy()
    for _ in range(count):
        for k in range(q_now.size):
            q_now[k], v_now[k] = q[row, k], v[row, k]
        for k in range(modes_now.size):
            modes_now[k] = modes[row, k]
        kernel(t[row], q_now, v_now, p, modes_now, a, lam)
        total += a[0]
        row = row + 1 if row + 1 < len(q) else 0
    return total


def _nothing(t: float, q: Any, v: Any, p: Any, modes: Any, a: Any, lam: Any) -> int:
    a[0] = q[0]
    return 0


@cache
def _compiled() -> tuple[Any, Any]:
    function = types.FunctionType(SIGNATURE)
    loop = F8(function, VECTOR, ROWS, ROWS, MODE_ROWS, VECTOR, VECTOR, VECTOR, types.int64)
    return njit(loop, **OPTIONS)(_loop), njit(SIGNATURE, **OPTIONS)(_nothing)


def times(kernels: Sequence[Timed], states: States, rounds: int = ROUNDS) -> list[float]:
    """Nanoseconds a call of each kernel, the loop's own taken off."""
    loop, nothing = _compiled()
    n = states.q.shape[1]
    runs = [
        partial(loop, kernel, *states, p, np.zeros(n), np.zeros(slots))
        for kernel, p, slots in (Timed(nothing, np.zeros(1), 1), *kernels)
    ]
    count = _calls(runs)
    best = np.min([[_seconds(run, count) for run in runs] for _ in range(rounds)], axis=0)
    found: list[float] = (1e9 * (best[1:] - best[0]) / count).tolist()
    return found


def _calls(runs: Sequence[Callable[[int], float]]) -> int:
    """How many calls of the slowest kernel fill a turn."""
    slowest = 0.0
    for run in runs:
        few, many = (min(_seconds(run, count) for _ in range(5)) for count in (100, 1100))
        slowest = max(slowest, (many - few) / 1000)
    return min(max(int(TURN / max(slowest, 1e-9)), 100), 100_000)


def _seconds(run: Callable[[int], float], count: int) -> float:
    started = perf_counter()
    run(count)
    return perf_counter() - started


def parameters(equations: Equations) -> list[float]:
    """The parameters that kernels take, without the constants behind them."""
    return [] if equations.scene.frozen else [p.value for p in equations.parameters]


def about_the_start(lowered: Lowered) -> States:
    """The start that the scene names, its joints closed where they can be, with a little noise."""
    description, poses = lowered.description, Poses(lowered)
    known = {name: value for name, value, _ in description.start}
    closed = poses.start()
    q = poses.guess if closed is None else closed[0]
    v = np.array([known.get(rate, 0.0) for _, rate, _ in description.coordinates])
    noise = np.random.default_rng(1).normal(size=(2, COUNT, len(q)), scale=SPREAD)
    return at(lowered, np.zeros(COUNT), q + noise[0], v + noise[1])


def at(lowered: Lowered, t: Floats, q: Floats, v: Floats) -> States:
    """States with the modes that hold at them; a condition on its edge does not hold."""
    equations = lowered.scene.equations
    modes = np.zeros((len(t), len(equations.switches)), dtype=np.int64)
    p = parameters(equations)
    for k in range(len(t) if equations.switches else 0):
        state = {"t": float(t[k]), "q": q[k].tolist(), "v": v[k].tolist(), "p": p}
        for slot, g in _outputs(lowered, "switching", state).get("g", {}).items():
            modes[k, slot] = g > 0.0
    times, places, rates = (np.ascontiguousarray(array) for array in (t, q, v))
    return States(times, places, rates, modes)


def _outputs(
    lowered: Lowered, name: str, arguments: dict[str, object]
) -> dict[str, dict[int, float]]:
    """Outputs of a kernel; nothing where it has no value, as at a singular position."""
    try:
        return evaluate(lowered.program, name, arguments, math)
    except (ArithmeticError, ValueError):
        return {}


class Measured(NamedTuple):
    """Times of one scene, ns."""

    # Part → time by which an evaluation takes longer with it than with those before it. They add up
    # to the time of the last stage, which is the scene's kernel.
    parts: dict[str, float]
    # Time of the scene's kernel, compiled and timed once more: what the parts should add up to.
    whole: float


def with_times(
    ledger: Ledger, programs: tuple[Lowered, ...], file: Path | None, t_end: float | None,
    progress: Callable[[str], None],
) -> Ledger:  # fmt: skip
    """The ledger with the nanoseconds of its parts and of the whole kernel, and a run's costs.

    `programs` as from `operations_by_part.cumulative_programs`; `t_end`, in s, requests a run of
    the model of a file.
    """
    whole = programs[-1]
    equations, run = whole.scene.equations, None
    events, states = Counter[str](), about_the_start(whole)
    if file is not None and t_end is not None:
        progress(f"{ledger.title}: running")
        run, events, samples = _simulate(file, equations.scene, t_end)
        states = at(whole, *samples[:3])
    progress(f"{ledger.title}: measuring")
    measured = measure(equations, timing_stages(programs), states)

    def priced(part: Part) -> Part:
        """The part with its time: zero where it adds no operation, none where it does not act."""
        if not part.acts or part.role == "fidelity":
            return part
        free = None if part.solving else 0.0
        time = None if measured is None else measured.parts.get(part.name, free)
        if run is None:
            return replace(part, nanoseconds=time)
        retakes = run.retakes * events[part.name] / run.events if run.events else 0.0
        spent = None if time is None else time * 1e-9 * run.evaluations
        return replace(
            part, nanoseconds=time, run_events=events[part.name], run_retakes=retakes,
            run_seconds=spent,
        )  # fmt: skip

    parts, nanoseconds = tuple(map(priced, ledger.parts)), measured and measured.whole
    return replace(ledger, parts=parts, nanoseconds=nanoseconds, run=run)


def measure(
    equations: Equations, stages: Sequence[Stage], states: States, rounds: int = ROUNDS
) -> Measured | None:
    """Compile every stage and time all of them in turns; None where there is no stage."""
    if not stages:
        return None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        kernels = [
            _stage_kernel(equations, stage.program, Path(folder) / f"stage_{k}.py")
            for k, stage in enumerate((*stages, stages[-1]))
        ]
        *cumulative, whole = times(kernels, states, rounds)
    added = np.diff(cumulative, prepend=0.0).tolist()
    return Measured(dict(zip((stage.part for stage in stages), added, strict=True)), whole)


def _stage_kernel(equations: Equations, program: Program, path: Path) -> Timed:
    declared = parameters(equations)
    docstring = ["A stage of a ledger."]
    text = assemble_module(program, ORIGIN, docstring, {}, Arguments(len(declared)))
    path.write_text(text, encoding="utf-8")
    module = import_generated(path)
    p = np.array([*declared, *[0.0] * len(program.constants)])
    module.constants(p)
    slots = 1 + max((out.slot for out in program.kernels[-1].outputs), default=0)
    return Timed(module.accelerations, p, max(slots, len(equations.coordinates)))


def _simulate(model: Path, scene: Scene, t_end: float) -> tuple[RunCosts, Counter[str], Any]:
    """Costs of a scene's run, effect → events, and the states t, q, v; InputError if it fails."""
    from runtime import load

    if scene.analysis != "dynamics":
        raise InputError(
            f"--run: scene '{scene.name}' is for {scene.analysis}, so there is no run under "
            "forces; leave --run out."
        )
    machine = load(model, scene.name)
    instants = np.linspace(0.0, t_end, COUNT)
    results = [machine.simulate(t_end, instants, progress=False) for _ in range(MEASURED)]
    first = results[0]
    if first.failed:
        raise InputError(f"--run: the run does not reach its end; {first.message}")
    events = Counter(event.name.partition(":")[0] for event in first.events)
    seconds = min(result.stats["integration_seconds"] for result in results)
    evaluations, steps, rejected, retakes = (
        int(first.stats[name]) for name in ("rhs_evaluations", "steps", "rejected", "retakes")
    )
    costs = RunCosts(t_end, evaluations, steps, rejected, retakes, events.total(), seconds)
    return costs, events, first.samples
