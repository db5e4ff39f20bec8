"""A look at a mechanism before it is compiled: whether its constraints can be independent.

At positions near the start values, in which the joints close, orthogonalisation finds the rows of
Φ_q that depend on earlier ones (Haug 3.4). Drivers stand last, so that a driver that repeats a
joint is the one named.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.derive.equations import Equations
from codegen.lower.lowered_scene import Lowered
from codegen.lower.poses_near_start import Poses, dependent_rows, is_finite

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
    poses, coordinates = Poses(lowered), equations.coordinates
    dependent = [rows[i] for i in _least_dependent(poses)]
    independent = len(rows) - len(dependent)
    positions = len(coordinates) - len(equations.states)
    if not dependent:
        return Findings((), (), independent)
    redundant = ", ".join(f"{c.name}.{row} ({c.kind})" for c, row in dependent)
    head = (
        f"scene '{equations.scene.name}': {len(rows)} constraints on {positions} "
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


def _least_dependent(poses: Poses) -> list[int]:
    """The rows that depend on earlier ones where they are fewest.

    Of as many, the last ones: at a singular position an earlier row depends on others by chance.
    A probe without any is the last one.
    """
    probes = []
    for k in range(PROBES):
        probes.append(_dependent_rows(_jacobian_near(poses, k)))
        if not probes[-1]:
            break
    return min(probes, key=lambda rows: (len(rows), [-i for i in rows]))


def _jacobian_near(poses: Poses, probe: int) -> Any:
    """Φ_q in units of the machine's size, where the constraints hold; sparse for a large machine.

    Where they do not, the position that comes nearest is singular, as a rod that is stretched after
    what it cannot reach: Φ_q is that of the place where the search began.
    """
    random = np.random.default_rng(probe)
    shift = (0.0 if probe == 0 else 0.1) * poses.unit * random.standard_normal(len(poses.guess))
    q, jacobian = poses.closed_near(poses.guess + shift)
    if not poses.holds(q):
        jacobian = poses.scaled(poses.jacobian(poses.guess + shift), poses.unit)
    if is_finite(jacobian):
        return jacobian
    if isinstance(jacobian, np.ndarray):
        return random.standard_normal(jacobian.shape)
    jacobian.data = random.standard_normal(jacobian.data.size)
    return jacobian


def _dependent_rows(jacobian: Any) -> list[int]:
    """Rows that depend on earlier ones, by Gram-Schmidt, each row orthogonalised twice.

    Those of a sparse matrix follow from its left null vectors.
    """
    if not isinstance(jacobian, np.ndarray):
        return dependent_rows(jacobian, TOLERANCE)
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
