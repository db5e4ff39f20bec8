"""Starts at or near a singular configuration, where Newton's method is too inaccurate.

At the distance d from a position in which motions cross, the smallest singular value of Phi_q is of
the order of d, and Newton's method leaves a position with the error eps / d and so velocities with
the relative error eps / d². The singular configuration itself is located to rounding (see
`runtime.singularity.singular_root_search`), and so is the direction of the branch there: a start on
the tangent has the relative error d.
"""

import numpy as np

from runtime.assembly.joint_closing import CLOSED, Task
from runtime.assembly.redundancy import is_clearly_independent
from runtime.core.arrays import EPS
from runtime.mechanism.dense_equations import FloatArray
from runtime.singularity.motion_polynomial import taylor
from runtime.singularity.singular_position_near_motion import SingularPositions

_NEAR = EPS ** (1.0 / 3.0)  # accuracy: distance d at which the errors d and eps / d² are equal
# accuracy: distance from which on a position shows on which branch it is
_DISTINCT = 4.0 * EPS**0.5
_ROUNDING = 64.0 * EPS  # accuracy: scaled gap that is rounding
# accuracy: error of a velocity against its branch, relative, as at the start of a run
_DIRECTION_ERROR = 1e-6
# accuracy: difference of a branch's fixed velocities from the given ones, in parts of the speed
_SAME_VELOCITY = 1e-9


def start_on_branch(
    task: Task, q: FloatArray, v: FloatArray, fixed_v: np.ndarray[tuple[int], np.dtype[np.bool_]]
) -> tuple[FloatArray, FloatArray] | None:
    """Position and velocity on the branch of (q, v), where that is close to a singular position.

    The coordinates that are not free in `task` keep their values, and the velocities in `fixed_v`
    theirs. None where the start is not so near, or where no branch has these values.
    """
    equations = task.equations
    if not equations.m or not v.any() or equations.m >= equations.n:
        return None
    least = _least_singular_value(task, q)
    if not least < _NEAR:
        return None
    positions = SingularPositions(equations.scaled(task.scale, np.arange(equations.m)))
    rest = np.zeros_like(v)
    position = positions.find(taylor(task.t, q, v, rest), 0.0)
    if position is None or position.gap > _ROUNDING:
        return None
    away = q - position.q
    if np.linalg.norm(away / task.scale) > _DISTINCT:
        part = float(away[fixed_v] @ v[fixed_v]) if fixed_v.any() else float(away @ v)
        along = away * np.sign(part or 1.0)
        along *= np.linalg.norm(v / task.scale) / np.linalg.norm(along / task.scale)
        position = positions.find(taylor(task.t, q, along, rest), 0.0)
        if position is None or position.gap > _ROUNDING:
            return None
    elif position.astray > _DIRECTION_ERROR:
        return None  # neither position nor velocities say which branch is meant
    else:
        along = v
    branch = along + position.veer
    speed = float(np.abs(branch / task.scale).max())
    if fixed_v.any():
        square = float(branch[fixed_v] @ branch[fixed_v])
        if not square > 0.0:
            return None
        branch = branch * (float(branch[fixed_v] @ v[fixed_v]) / square)
        if np.abs((branch - v)[fixed_v]).max() > _SAME_VELOCITY * speed:
            return None
        branch[fixed_v] = v[fixed_v]
    fixed = ~task.free
    square = float(branch[fixed] @ branch[fixed])
    tau = float((q - position.q)[fixed] @ branch[fixed]) / square if square > 0.0 else 0.0
    place = position.q + tau * branch
    if np.abs(((place - q) / task.scale)[fixed]).max(initial=0.0) > _ROUNDING:
        return None
    place[fixed] = q[fixed]
    for _ in range(2):  # Newton's method on the well-conditioned directions; the lost ones stay
        change = _least_squares(task.slopes(place), task.gaps(place), position.lost)
        place[task.free] -= change * task.scale[task.free]
    if np.abs(task.gaps(place)).max() > CLOSED:
        return None
    slopes = equations.jacobian(task.t, place) * task.scale / task.row_scale[:, None]
    gaps = slopes @ (branch / task.scale) - equations.velocity_rhs(task.t, place) / task.row_scale
    change = _least_squares(slopes[:, ~fixed_v], gaps, position.lost)
    branch[~fixed_v] -= change * task.scale[~fixed_v]
    return place, branch


def _least_singular_value(task: Task, q: FloatArray) -> float:
    """The smallest singular value of Φ_q, columns scaled, rows of unit length; 1 for an empty row.

    That of a large machine is by iteration, where it is clearly no small one.
    """
    if is_clearly_independent(task, q):
        return 1.0
    matrix = task.equations.jacobian(task.t, q) * task.scale
    lengths = np.linalg.norm(matrix, axis=1)
    if not lengths.all():
        return 1.0
    return float(np.linalg.svd(matrix / lengths[:, None], compute_uv=False)[-1])


def _least_squares(matrix: FloatArray, right: FloatArray, weak: int) -> FloatArray:
    """The least x with matrix x = right, without the `weak` smallest singular values."""
    left, values, basis = np.linalg.svd(matrix, full_matrices=False)
    firm = len(values) - weak
    x: FloatArray = basis[:firm].T @ (left[:, :firm].T @ right / values[:firm])
    return x
