"""Machines on their constraints, and derivatives of their kernels along a direction."""

import cmath
import math
from typing import Any

import numpy as np
from scipy.linalg import qr

from codegen.lower.interpreter import evaluate
from codegen.lower.program import Program
from tests.codegen.workbench import STEP, Interpreted, State, plain


def assembled(machine: Interpreted, seed: int, t: float = 0.0) -> State:
    """A state on the constraints near the scene's start, at random velocities that they allow."""
    named = machine.equations.scene
    known = dict(named.guess) | dict(named.start)
    names = [row[0] for row in machine.lowered.description.coordinates]
    random = np.random.default_rng(seed)
    q = np.array([known.get(name, 0.0) for name in names]) + 1e-3 * random.standard_normal(
        len(names)
    )
    s = State(t=t, q=q, v=random.uniform(-2, 2, machine.n))
    for _ in range(30):
        s = machine.corrected(s)
    assert np.abs(machine.vector("constraints", s)).max(initial=0.0) < 1e-12
    return s


def by_complex_step(
    machine: Interpreted,
    kernel: str,
    arrays: tuple[str, ...],
    s: State,
    dq: Any,
    dv: Any,
    **more: Any,
) -> np.ndarray:
    """Derivatives of a kernel's outputs along (dq, dv), to the last digit."""
    moved = State(t=s.t, q=s.q + 1j * STEP * dq, v=s.v + 1j * STEP * dv)
    out = machine.flat(kernel, moved, cmath, **more)
    return np.array([np.imag(out[array]) / STEP for array in arrays])


def by_tangent(
    machine: Interpreted,
    tangents: Program,
    kernel: str,
    arrays: tuple[str, ...],
    s: State,
    **more: Any,
) -> np.ndarray:
    """Answers of a kernel of derivatives, by the interpreter."""
    inputs = {"t": s.t, "q": s.q, "v": s.v, "p": machine.p, "modes": [1] * machine.s} | more
    out = evaluate(tangents, kernel, {k: plain(x) for k, x in inputs.items()}, math)
    return np.array([[out[array][k] for k in range(machine.n)] for array in arrays])


def dependent(machine: Interpreted, s: State) -> list[int]:
    """Columns of a well-conditioned square block of Φ_q."""
    *_, order = qr(machine.jacobian(s), pivoting=True)
    return sorted(order[: machine.m])
