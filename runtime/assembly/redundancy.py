"""Redundant constraints: detection, and distinction from singular configurations.

The rows of the joints are eliminated first and the drivers appended, so that a driver without a
motion left to drive is named as such.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.assembly.joint_closing import CLOSED, Task, nearest, refine
from runtime.linalg.rank_policy import LOST
from runtime.mechanism.dense_equations import FloatArray, row_lengths

BoolArray = npt.NDArray[np.bool_]
# measured: scaled lengths of the displacements at whose ends the rank is taken again
_SIZES = (0.02, -0.05, 0.1, 0.02, -0.05, 0.1, -0.2)
_CLEARLY = 10.0  # safety: times LOST; a singular value above it, by iteration, is no lost one
_SHARE = 1e-6  # accuracy: share of a constraint in a dependency, below which it has none
_APART = 1e-3  # measured: scaled distance at which a rank deficiency of a single position has ended


class Dependency(NamedTuple):
    """A row that follows from earlier ones: its index, and those from which it follows."""

    row: int
    follows_from: tuple[int, ...]


def dependent_rows(matrix: FloatArray, order: list[int]) -> list[Dependency]:
    """Rows that are combinations of those before them in `order`.

    Rows are made unit length and reduced one by one against an orthonormal basis of the rows
    accepted so far, twice against loss of orthogonality. No remainder is shorter than the least
    singular value of the rows: where that is long enough, nothing need be reduced. A row that is
    not finite is no combination of others.
    """
    lengths = np.linalg.norm(matrix, axis=1)
    finite = np.isfinite(lengths)
    order = [row for row in order if finite[row]]
    unit = matrix / np.where(finite & (lengths > 0.0), lengths, 1.0)[:, None]
    rows = unit[order]
    if len(rows) <= rows.shape[1]:
        least = np.linalg.svd(rows, compute_uv=False).min(initial=np.inf)
        if least > 2.0 * LOST:
            return []
    basis = np.zeros((0, rows.shape[1]))
    accepted: list[int] = []
    dependent = []
    for row in order:
        rest = unit[row] - basis.T @ (basis @ unit[row])
        rest -= basis.T @ (basis @ rest)
        size = float(np.linalg.norm(rest))
        if size > LOST:
            basis = np.vstack([basis, rest / size])
            accepted.append(row)
            continue
        shares = np.linalg.lstsq(unit[accepted].T, unit[row], rcond=None)[0] if accepted else ()
        sources = (k for k, share in zip(accepted, shares, strict=True) if abs(share) > _SHARE)
        dependent.append(Dependency(row, tuple(sources)))
    return dependent


class Findings(NamedTuple):
    """Dependencies at every position, those at this position only, and the rank.

    Where there are any of the first, `undetermined` are the rows whose multipliers they leave open.
    """

    lasting: list[Dependency]
    here_only: list[Dependency]
    rank: int
    undetermined: Sequence[int] = ()


def find_redundancy(task: Task, q: FloatArray, drivers: BoolArray, v: FloatArray) -> Findings:
    """Find dependent constraints at an assembled position.

    A dependency that disappears a little further along the machine's motion belongs to the position
    (a dead centre); one that stays is a redundancy. The start velocities `v` give one such motion,
    if the joints allow them; others are tried too.
    """
    order = np.argsort(drivers, kind="stable").tolist()
    if is_clearly_independent(task, q):
        return Findings([], [], len(order))
    here = dependent_rows(_scaled(task, q), order)
    if not here:
        return Findings([], [], len(order))
    lasting = _fewest(task, order, here, _neighbours(task, q, drivers, v))
    if len(lasting) == len(here):
        return Findings(here, [], len(order) - len(here))
    # The last row of a dependency may differ between positions: the lasting ones go first.
    lost = {dependency.row for dependency in lasting}
    rows = [row for row in order if row not in lost]
    return Findings(lasting, dependent_rows(_scaled(task, q), rows), len(rows))


def unit_rows(task: Task, q: FloatArray) -> Any:
    """Φ_q of a large machine with scaled columns and rows of unit length, sparse, (m, n)."""
    rows = task.equations.description.jacobian_rows
    slopes = task.equations.slopes(task.t, q)
    slopes = slopes * task.scale[task.equations.description.jacobian_columns]
    lengths = np.sqrt(np.bincount(rows, slopes**2, minlength=task.equations.m))
    return task.equations.sparse_jacobian(slopes / np.where(lengths > 0.0, lengths, 1.0)[rows])


def is_clearly_independent(task: Task, q: FloatArray) -> bool:
    """Whether sparse factors show a large machine's constraints to be independent at q.

    Where they do not, or the machine is not large, dense matrices decide.
    """
    equations = task.equations
    if not equations.is_large or equations.m > equations.n:
        return False
    matrix = unit_rows(task, q)
    if not np.isfinite(matrix.data).all():
        return False
    from runtime.linalg.least_norm import LeastNorm

    return LeastNorm(matrix).least_singular_value() > _CLEARLY * LOST


def dependent_joints(task: Task, q: FloatArray, drivers: BoolArray) -> list[Dependency]:
    """Dependencies among the joints at every position, assembled or not.

    Else, of more joints than coordinates, those at q, where they come nearest to closing: the
    residual of contradictory constraints is a combination that no motion changes.
    """
    order = np.flatnonzero(~drivers).tolist()
    here = dependent_rows(_scaled(task, q), order)
    if not here:
        return []
    random = np.random.default_rng(2)
    others = [q + 0.3 * random.normal(size=len(q)) * task.scale for _ in range(2)]
    return _fewest(task, order, here, others) or (here if len(order) > len(q) else [])


def _fewest(
    task: Task, order: list[int], here: list[Dependency], others: list[FloatArray]
) -> list[Dependency]:
    """The fewest dependencies at any position: those `here`, and at the `others`.

    A position at which the Jacobian is not finite says nothing.
    """
    matrices = [_scaled(task, q) for q in others]
    defined = [matrix for matrix in matrices if np.isfinite(matrix).all()]
    return min([here, *(dependent_rows(matrix, order) for matrix in defined)], key=len)


def _scaled(task: Task, q: FloatArray) -> FloatArray:
    matrix: FloatArray = task.equations.jacobian(task.t, q) * task.scale
    return matrix


def undetermined_rows(task: Task, q: FloatArray) -> list[int]:
    """Constraints whose multipliers the equations of motion leave open: rows in dependencies."""
    matrix = _scaled(task, q)
    left, values, _ = np.linalg.svd(matrix / row_lengths(matrix)[:, None])
    rank = int(np.sum(values > LOST))
    shares = np.abs(left[:, rank:]).max(axis=1, initial=0.0)
    return [int(row) for row in np.flatnonzero(shares > LOST)]


def _neighbours(task: Task, q: FloatArray, drivers: BoolArray, v: FloatArray) -> list[FloatArray]:
    """Assembled positions a little way off, along the motion that the joints leave."""
    joints = task._replace(rows=~drivers, free=np.ones(len(q), dtype=np.bool_))
    _, values, right = np.linalg.svd(joints.slopes(q))
    motions = right[int(np.sum(values > LOST * max(1.0, float(values.max(initial=0.0))))) :]
    if not len(motions):
        return []
    neighbours = []
    random = np.random.default_rng(3)
    along = motions.T @ (motions @ (v / task.scale))
    tried = [along, along] if np.linalg.norm(along) > 0.0 else []
    tried += [random.normal(size=len(motions)) @ motions for _ in _SIZES[2:]]
    for direction, size in zip(tried, _SIZES, strict=False):
        begin = q + size * direction / np.linalg.norm(direction) * task.scale
        # Newton's method may fall back into q where motions cross; the nearest point does not.
        for moved in (refine(joints, begin), refine(joints, nearest(joints, begin))):
            apart = float(np.abs((moved - q) / task.scale).max())
            if np.abs(joints.gaps(moved)).max(initial=0.0) <= CLOSED and apart > _APART:
                neighbours.append(moved)
                break
    return neighbours
