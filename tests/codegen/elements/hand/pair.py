"""Two bodies, two points: what Haug's formulas are written in, in numpy and by hand."""

from collections.abc import Callable

import numpy as np

from tests.codegen.workbench import A, B, Interpreted, State

SI, SJ = np.array([0.7, -0.4]), np.array([-1.1, 0.3])
AXIS = np.array([2.0, -1.5])
UNIT, NORMAL = np.array([0.8, -0.6]), np.array([0.6, 0.8])

Rows = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Φ, Φ_q of the first body (m × 3), Φ_q of the second (m × 3), γ."""
Formula = Callable[[State, int | None, int | None], Rows]


def place(s: State, k: int | None, point: np.ndarray) -> np.ndarray:
    """Where a point of body `k` is."""
    r, phi, _, _ = s.body(k)
    return r + A(phi) @ point


def span(
    s: State, i: int | None, j: int | None, si: np.ndarray = SI, sj: np.ndarray = SJ
) -> tuple[np.ndarray, ...]:
    """d = r_j^P - r_i^P, ḋ, and d̈ without accelerations."""
    (_, pi, vi, wi), (_, pj, vj, wj) = s.body(i), s.body(j)
    d = place(s, j, sj) - place(s, i, si)
    rate = vj + wj * B(pj) @ sj - vi - wi * B(pi) @ si
    return d, rate, wi**2 * A(pi) @ si - wj**2 * A(pj) @ sj


def columns(r: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Φ_r and Φ_φ side by side."""
    return np.column_stack([np.atleast_2d(r), np.atleast_1d(phi)])


def closed(machine: Interpreted, seed: int) -> State:
    """A state on the constraints, by Newton steps of least norm from a random one."""
    s = machine.state(seed)
    for _ in range(60):
        s = machine.corrected(s)
    assert np.abs(machine.vector("constraints", s)).max() < 1e-12
    return s


def reactions(machine: Interpreted, s: State) -> dict[tuple[str, str], float]:
    """(element, component) → its value in the motion that starts at `s`."""
    _, lam = machine.solution(s)
    values = machine.vector("reactions", s, lam=lam)
    rows = machine.lowered.description.reactions
    return {row[:2]: x for row, x in zip(rows, values, strict=True)}


def moment(arm: np.ndarray, force: np.ndarray) -> float:
    """arm × force."""
    return float(arm[0] * force[1] - arm[1] * force[0])


def balance(s: State, forces: np.ndarray) -> tuple[np.ndarray, float]:
    """Sum of the generalized forces on two bodies, and of their moments about the origin."""
    first, second = forces[:3], forces[3:]
    turning = moment(s.q[:2], first[:2]) + first[2] + moment(s.q[3:5], second[:2]) + second[2]
    return first[:2] + second[:2], turning
