"""A look at a mechanism before it is compiled: whether its constraints can be independent.

The equations are evaluated by the interpreter, near the start values; the constraints are closed
by Gauss-Newton steps of least norm; then orthogonalisation finds the rows of Φ_q that depend on
earlier ones (Haug 3.4). Drivers stand last, so that a driver that repeats a joint is the one named.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.derive.equations import Equations
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.scene_kernels import Lowered

Array = npt.NDArray[np.float64]
# accuracy: rest of a row, columns scaled, below which the row follows from those before it
TOLERANCE = 1e-8
# safety: positions about the start that are tried, so that a singular start is not redundancy
PROBES = 3


class Findings(NamedTuple):
    """Findings about the constraints of a scene."""

    problems: tuple[str, ...]  # drivers that have nothing left to drive
    notes: tuple[str, ...]
    """Joints that repeat each other: a run bears with them while their parameters agree."""
    independent: int  # number of constraints that do not follow from others


def examine(equations: Equations, lowered: Lowered) -> Findings:
    """Look for constraints that are too many near the start values."""
    rows = [(c, row) for c in equations.constraints for row in c.statement.rows]
    if not rows:
        return Findings((), (), 0)
    known = dict((*equations.scene.guess, *equations.scene.start))
    coordinates = equations.coordinates
    guess = np.array([known.get(f"{q.owner}.{q.letter}", q.measure.neutral) for q in coordinates])
    probes = (_jacobian_near(equations, lowered, guess, k) for k in range(PROBES))
    dependent = [rows[i] for i in min(map(_dependent_rows, probes), key=len)]
    independent = len(rows) - len(dependent)
    if not dependent:
        return Findings((), (), independent)
    redundant = ", ".join(f"{c.name}.{row} ({c.kind})" for c, row in dependent)
    head = (
        f"scene '{equations.scene.name}': {len(rows)} constraints on {len(coordinates)} "
        f"coordinates, of which only {independent} are independent; redundant: {redundant}."
    )
    drivers = {c.name for c, _ in dependent if c.driver}
    names = " or ".join(map(repr, sorted(drivers or {c.name for c, _ in dependent})))
    if drivers:
        problem = f"{head} Remove or relax {names}: no motion is left for them to prevent."
        return Findings((problem,), (), independent)
    note = (
        f"{head} The scene runs as long as its parameters let them agree, at some cost, and "
        f"reactions of joints that share a load are not unique. Remove or relax {names} to "
        f"avoid both."
    )
    return Findings((), (note,), independent)


def _jacobian_near(equations: Equations, lowered: Lowered, guess: Array, probe: int) -> Array:
    """Φ_q in units of the machine's size, where the constraints hold or a few steps near there."""
    random = np.random.default_rng(probe)
    unit = _units(equations, _jacobian(equations, lowered, guess))
    q = guess + (0.0 if probe == 0 else 0.1) * unit * random.standard_normal(len(guess))
    jacobian = _jacobian(equations, lowered, q)
    for _ in range(25):
        if not np.all(np.isfinite(jacobian)):
            break
        phi = _flat(equations, lowered, "constraints", "phi", q)
        step = np.linalg.lstsq(jacobian * unit, -phi, rcond=1e-10)[0]
        length = float(np.linalg.norm(step))
        q = q + unit * step / max(1.0, length)
        jacobian = _jacobian(equations, lowered, q)
        if length < 1e-12:
            break
    if not np.all(np.isfinite(jacobian)):
        return random.standard_normal(jacobian.shape)
    return jacobian * unit


def _units(equations: Equations, jacobian: Array) -> Array:
    """1 for angles and numbers; for lengths the longest arm, so that size does not matter."""
    angles = np.array([q.unit != "m" for q in equations.coordinates])
    moved = np.abs(jacobian[:, ~angles]).max(axis=1, initial=0.0)
    turned = np.abs(jacobian[:, angles]).max(axis=1, initial=0.0)
    arms = [float(a / b) for a, b in zip(turned, moved, strict=True) if a > 0 and b > 0]
    longest = max(arms, default=1.0)
    return np.where(angles, 1.0, longest if math.isfinite(longest) else 1.0)


def _jacobian(equations: Equations, lowered: Lowered, q: Array) -> Array:
    m = sum(len(c.statement.rows) for c in equations.constraints)
    dense = np.zeros((m, len(equations.coordinates)))
    pattern = lowered.description.jacobian
    dense[list(pattern.rows), list(pattern.columns)] = _flat(
        equations, lowered, "jacobian", "values", q
    )
    return dense


def _flat(equations: Equations, lowered: Lowered, kernel: str, array: str, q: Array) -> Array:
    """The array that a kernel writes, or nan throughout where it is undefined."""
    parameters = [p.value for p in equations.parameters]
    arguments = {"t": 0.0, "q": q.tolist(), "p": parameters}
    try:
        slots = evaluate(lowered.program, kernel, arguments, math).get(array, {})
    except (ZeroDivisionError, ValueError, OverflowError):
        (undefined,) = (k for k in lowered.program.kernels if k.name == kernel)
        return np.full(len(undefined.outputs), np.nan)
    return np.array([slots[k] for k in range(len(slots))])


def _dependent_rows(jacobian: Array) -> list[int]:
    """Rows that depend on earlier ones, by Gram-Schmidt, each row orthogonalised twice."""
    basis = np.zeros((0, jacobian.shape[1]))
    dependent = []
    for i, row in enumerate(jacobian):
        rest = row / max(float(np.linalg.norm(row)), 1e-300)  # safety: a row of zeros
        for _ in range(2):
            rest = rest - basis.T @ (basis @ rest)
        size = float(np.linalg.norm(rest))
        if size > TOLERANCE:
            basis = np.vstack([basis, rest / size])
        else:
            dependent.append(i)
    return dependent
