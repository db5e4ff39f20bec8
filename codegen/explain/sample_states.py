"""States at which a scene's kernels are timed: about its start, or along a run."""

import math
from collections.abc import Sequence

import numpy as np

from codegen.derive.equations import Equations
from codegen.explain.kernel_timer import Floats, States
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.scene_kernels import Lowered

COUNT = 64  # measured: states at which kernels are timed
SPREAD = 1e-3
"""measured: m or rad, and m/s or rad/s, by which states about a start differ."""
NEWTON = 30  # safety: iterations that bring a sampled state onto the constraints


def parameters(equations: Equations) -> list[float]:
    """The parameters that kernels take, without the constants behind them."""
    return [] if equations.scene.frozen else [p.value for p in equations.parameters]


def about_the_start(equations: Equations, lowered: Lowered) -> States:
    """The start that the scene names, put together by Newton's method, with a little noise."""
    told = {name.replace(".", "_"): x for name, x in equations.scene.guess}
    fixed = {name.replace(".", "_"): x for name, x in equations.scene.start}
    told |= fixed
    q = [told.get(c.name, 0.0) for c in equations.coordinates]
    v = [told.get(c.rate.name, 0.0) for c in equations.coordinates]
    weights = [1e-4 if c.name in fixed else 1.0 for c in equations.coordinates]
    q, v = _assembled(equations, lowered, q, v, weights)
    noise = np.random.default_rng(1).normal(size=(2, COUNT, len(q)), scale=SPREAD)
    return at(equations, lowered, np.zeros(COUNT), np.array(q) + noise[0], np.array(v) + noise[1])


def at(equations: Equations, lowered: Lowered, t: Floats, q: Floats, v: Floats) -> States:
    """States with the modes that hold at them; a condition on its edge does not hold."""
    modes = np.zeros((len(t), len(equations.switches)), dtype=np.int64)
    if equations.switches:
        p = parameters(equations)
        for k in range(len(t)):
            told = {"t": float(t[k]), "q": q[k].tolist(), "v": v[k].tolist(), "p": p}
            for slot, g in _kernel(lowered, "switching", told).get("g", {}).items():
                modes[k, slot] = g > 0.0
    times, places, rates = (np.ascontiguousarray(array) for array in (t, q, v))
    return States(times, places, rates, modes)


def _assembled(
    equations: Equations, lowered: Lowered, q: list[float], v: list[float], w: list[float]
) -> tuple[list[float], list[float]]:
    """The state returned onto the constraints, as far as Newton's method gets."""
    known = {"t": 0.0, "p": parameters(equations), "w": w}
    if "correction" not in {k.name for k in lowered.program.kernels}:
        return q, v
    for _ in range(NEWTON):
        change = _kernel(lowered, "correction", {**known, "q": q, "v": v})
        dq = _filled(change.get("dq", {}), len(q))
        if not all(map(math.isfinite, dq)):
            return q, v
        q = [a + b for a, b in zip(q, dq, strict=True)]
        if max(map(abs, dq), default=0.0) < 1e-12:
            break
    change = _kernel(lowered, "correction", {**known, "q": q, "v": v})
    dv = _filled(change.get("dv", {}), len(v))
    moved = [a + b for a, b in zip(v, dv, strict=True)]
    return q, moved if all(map(math.isfinite, moved)) else v


def _filled(slots: dict[int, float], size: int) -> Sequence[float]:
    return [float(slots.get(k, math.nan)) for k in range(size)]


def _kernel(
    lowered: Lowered, name: str, arguments: dict[str, object]
) -> dict[str, dict[int, float]]:
    """Outputs of a kernel; nothing where it has no value, as at a singular position."""
    try:
        return evaluate(lowered.program, name, arguments, math)
    except (ArithmeticError, ValueError):
        return {}
