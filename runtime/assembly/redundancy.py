"""Redundant constraints: their detection; kernels for masses far apart.

The rows of the joints are eliminated first and the drivers appended, so that a driver without a
motion left to drive is named as such.

A module has independent rows in the place of joints with redundant ones, by what was found before
the build (`codegen.check.shared_rows`). Masses that parameter values put far apart take the null
space of Φ_q, by a kernel in the place of the module's own: a module orders its elimination for the
masses that it was built with, and takes constraints for dependent that are not where pivots of
Φ_q M⁻¹ Φ_qᵀ are as small as a light body's share in M⁻¹ is large.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt
from numba import njit

from codegen.errors import AnalysisError
from runtime.assembly.joint_closing import CLOSED, Task, nearest, refine
from runtime.core.arrays import Kernel
from runtime.core.kernel_abi import SIGNATURES, Kernels
from runtime.linalg.dense_elimination import Sparse
from runtime.linalg.motion_by_null_space import solve_motion_by_null_space
from runtime.linalg.rank_policy import LOST
from runtime.mechanism.dense_equations import Equations, FloatArray, row_lengths
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.mechanism.typical_sizes import measure_spread
from runtime.results.assembled_state import Assembly

BoolArray = npt.NDArray[np.bool_]
# measured: scaled lengths of displacements, at whose ends the rank is determined again
_SIZES = (0.02, -0.05, 0.1, 0.02, -0.05, 0.1, -0.2)
_CLEARLY = 10.0  # safety: times LOST; a singular value above it, by iteration, is not lost
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
    """The fewest dependencies of those `here` and at `others` where the Jacobian is finite."""
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


# accuracy: in weak pivots: part of a pivot's reference that the spread of masses may take; beyond
# it accelerations have nine digits at most
MOST_SPREAD = 1e-2
DOUBTFUL = 1e-3  # safety: of `MOST_SPREAD`; with a larger spread in one pose others are examined
_UNCACHED: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}}
_VARIANTS: WeakKeyDictionary[Mechanism, Mechanism] = WeakKeyDictionary()  # compiled once for each


def suited_equations(equations: Equations, start: Assembly) -> Equations:
    """The equations, or those whose kernels bear masses far apart.

    Raises AnalysisError where friction needs the reactions that redundant constraints leave open,
    or where others are redundant than those that the module was built without.
    """
    mechanism, description = equations.mechanism, equations.description
    if start.redundant or description.redundant:
        if len(start.redundant) != len(description.redundant):
            raise AnalysisError(_other_redundancy(description, start))
        names = ", ".join(row.name for row in start.redundant)
        why = f"which redundant constraints leave undetermined ({names}). Remove one or the other."
    elif spread := _spread_of_masses(equations, start.t, start.q):
        why = (
            "and the masses and moments of inertia of this run make constraints "
            f"{spread:.1g} times as mobile as others, far more than those that the module was "
            "built with. Declare the parameters with values of this size, so that the build "
            "allows for them."
        )
    else:
        return equations
    # A dry friction with a given normal force needs no reaction.
    friction = [row.name for row in description.effects if row.kind == "friction"]
    if friction:
        raise AnalysisError(
            f"{mechanism.title}: friction in joints ({', '.join(friction)}) follows from "
            f"their reactions, {why}"
        )
    if start.redundant:
        return Equations(mechanism.with_independent_rows, equations.p)
    if mechanism not in _VARIANTS:
        kernel = _accelerations_by_null_space(mechanism.kernels, description)
        kernels = replace(mechanism.kernels, accelerations=kernel)
        _VARIANTS[mechanism] = replace(mechanism, kernels=kernels)
    return Equations(_VARIANTS[mechanism], equations.p)


def _other_redundancy(description: Description, start: Assembly) -> str:
    """Why a module does not suit the redundant constraints of a run, and what to do."""
    built, table = [description.constraints[k].name for k in description.redundant], start.redundant
    own = [row.name for row in table if row.name in description.coordinates.names]
    if own:  # an angle is no function of a pose in which its axes are opposite
        return (
            f"{description.title}: the axes of a joint point in opposite directions at the start, "
            f"where {', '.join(own)} cannot be counted. Give poses of its bodies, at the drawing "
            "or by guess=, with which they point the same way."
        )
    return (
        f"{description.title}: with the values of this run {_listed([r.name for r in table])} from "
        f"others, and with those that the module was built with {_listed(built)}. Load "
        "scene.with_(parameters=..., guess=...) with the values of this run, so that the build "
        "allows for them."
    )


def _listed(names: list[str]) -> str:
    """The subject and verb of a sentence on redundant rows: "a.x follows"."""
    verb = "follow" if len(names) > 1 else "follows"
    return f"{', '.join(names)} {verb}" if names else "no constraint follows"


def _spread_of_masses(equations: Equations, t: float, q: FloatArray) -> float:
    """How much more mobile some constraints are than others, where kernels do not bear it; or 0."""
    description = equations.description
    if not (description.has_masses and description.weak_pivot):
        return 0.0
    table, inertia = equations.start.table, equations.masses(q)
    slopes, most = np.abs(equations.slopes(t, q)), MOST_SPREAD / description.weak_pivot
    if measure_spread(table, inertia, slopes) < DOUBTFUL * most:
        return 0.0
    for pose in equations.turned(q):
        slopes = np.maximum(slopes, np.abs(equations.slopes(t, pose)))
    spread = float(measure_spread(table, inertia, slopes))
    return spread if spread > most else 0.0


def redundancy_note(start: Assembly) -> str:
    """Sentence of a result about redundant constraints; empty without any."""
    if not start.redundant:
        return ""
    return (
        f" Redundant: {', '.join(row.name for row in start.redundant)}; the reactions of "
        f"{', '.join(start.not_unique)} are not unique, those of least norm are given."
    )


def _accelerations_by_null_space(kernels: Kernels, description: Description) -> Kernel:
    """The kernel `accelerations` by the null space of Φ_q, of Φ_q, M, Q and γ."""
    jacobian, gamma_of = kernels.jacobian, kernels.acceleration_rhs
    mass_of, forces = kernels.mass, kernels.applied_forces
    resting = description.analysis == "equilibrium"  # such a scene has no γ, which is zero at rest
    rows, columns = description.jacobian_rows, description.jacobian_columns
    mass_rows, mass_columns = description.mass_rows, description.mass_columns
    n, m = len(description.coordinates), len(description.constraints)

    def accelerations(t: Any, q: Any, v: Any, p: Any, modes: Any, a: Any, lam: Any) -> int:
        values, masses = np.empty(rows.size), np.empty(mass_rows.size)
        gamma, force = np.zeros(m), np.empty(n)
        jacobian(t, q, p, values)
        if not resting:
            gamma_of(t, q, v, p, gamma)
        mass_of(q, p, masses)
        forces(t, q, v, p, modes, force)
        slopes, inertia = Sparse(rows, columns, values), Sparse(mass_rows, mass_columns, masses)
        return m if solve_motion_by_null_space(slopes, inertia, force, gamma, a, lam) else 0

    made: Kernel = njit(SIGNATURES["accelerations"], **_UNCACHED)(accelerations)
    return made
