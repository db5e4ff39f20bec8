"""States at which a scene's kernels are timed: about its start, or along a run."""

import math

import numpy as np

from codegen.derive.equations import Equations
from codegen.explain.kernel_timer import Floats, States
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.scene_kernels import Lowered

COUNT = 64  # measured: states at which kernels are timed
SPREAD = 1e-3  # measured: m or rad, and m/s or rad/s, by which states about a start differ
NEWTON = 30  # safety: iterations that bring a sampled state onto the constraints
_CONVERGED = 1e-12  # accuracy: largest change, m or rad, of the last of these iterations


def parameters(equations: Equations) -> list[float]:
    """The parameters that kernels take, without the constants behind them."""
    return [] if equations.scene.frozen else [p.value for p in equations.parameters]


def about_the_start(lowered: Lowered) -> States:
    """The start that the scene names, put together by Newton's method, with a little noise."""
    equations = lowered.scene.equations
    fixed = {name.replace(".", "_"): x for name, x in equations.scene.start}
    start = {name.replace(".", "_"): x for name, x in equations.scene.guess} | fixed
    q = [start.get(c.name, 0.0) for c in equations.coordinates]
    v = [start.get(c.rate.name, 0.0) for c in equations.coordinates]
    weights = [1e-4 if c.name in fixed else 1.0 for c in equations.coordinates]
    q, v = _assembled(lowered, q, v, weights)
    noise = np.random.default_rng(1).normal(size=(2, COUNT, len(q)), scale=SPREAD)
    return at(lowered, np.zeros(COUNT), np.array(q) + noise[0], np.array(v) + noise[1])


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


def _assembled(
    lowered: Lowered, q: list[float], v: list[float], w: list[float]
) -> tuple[list[float], list[float]]:
    """The state returned onto the constraints, as far as Newton's method gets."""

    def moved(array: str, values: list[float]) -> list[float]:
        state = {"t": 0.0, "p": p, "w": w, "q": q, "v": v}
        change = _outputs(lowered, "correction", state).get(array, {})
        return [x + float(change.get(k, math.nan)) for k, x in enumerate(values)]

    if "correction" not in lowered.kernels:
        return q, v
    p = parameters(lowered.scene.equations)
    for _ in range(NEWTON):
        before, after = q, moved("dq", q)
        if not all(map(math.isfinite, after)):
            return q, v
        q = after
        if max((abs(b - a) for a, b in zip(before, q, strict=True)), default=0.0) < _CONVERGED:
            break
    corrected = moved("dv", v)
    return q, corrected if all(map(math.isfinite, corrected)) else v


def _outputs(
    lowered: Lowered, name: str, arguments: dict[str, object]
) -> dict[str, dict[int, float]]:
    """Outputs of a kernel; nothing where it has no value, as at a singular position."""
    try:
        return evaluate(lowered.program, name, arguments, math)
    except (ArithmeticError, ValueError):
        return {}
