"""Assembly: positions and velocities that satisfy joints, drivers and the fixed start values.

Start values with the role "fixed" are kept. The others are guesses: positions move as little as
closing the joints allows, velocities as little as Phi_q v = nu allows.

At the distance d from a position in which motions cross, the smallest singular value of Phi_q is of
the order of d, and Newton's method leaves a position with the error eps / d and so velocities with
the relative error eps / d². The singular configuration itself is located to rounding (see
`runtime.singularity.singular_root_search`), and so is the direction of the branch there: a start on
the tangent has the relative error d.
"""

import numpy as np
import numpy.typing as npt

from codegen.errors import AssemblyError
from runtime.assembly import redundancy, regular_start
from runtime.assembly.far_starts import driven_from_drawing, note_on_start
from runtime.assembly.joint_closing import CLOSED, Task, close
from runtime.assembly.mirrored_joints import mirror_note
from runtime.assembly.open_joints import (
    contradiction,
    largest_of,
    misses,
    redundancy_error,
    why_open,
)
from runtime.assembly.redundancy import Findings, is_clearly_independent
from runtime.assembly.start_spins import with_spins
from runtime.assembly.start_values import MOVED, Start, start_of_state, start_values
from runtime.core.arrays import EPS
from runtime.linalg.least_norm import least_norm_solver
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Numbers
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import Assembly, Moved, Redundant, State
from runtime.singularity.motion_polynomial import taylor
from runtime.singularity.singular_position_near_motion import SingularPositions
from runtime.validation.arguments import parameter_values
from runtime.validation.finite_equations import require_finite
from runtime.validation.scene_support import require_mass

BoolArray = npt.NDArray[np.bool_]

_UNRESOLVED = 1e-8  # accuracy: rad; distance of neighbouring floats at which sin φ loses its digits
_NEAR = EPS ** (1.0 / 3.0)  # accuracy: distance d at which the errors d and eps / d² are equal
# accuracy: distance from which on a position shows on which branch it is
_DISTINCT = 4.0 * EPS**0.5
_ROUNDING = 64.0 * EPS  # accuracy: scaled gap that is rounding
# accuracy: error of a velocity against its branch, relative, as at the start of a run
_DIRECTION_ERROR = 1e-6
# accuracy: difference of a branch's fixed velocities from the given ones, in parts of the speed
_SAME_VELOCITY = 1e-9


def assemble(
    equations: Equations, t: float = 0.0, guess: Numbers | None = None,
    start_at: Numbers | Assembly | State | None = None, *, release: bool = False,
) -> Assembly:  # fmt: skip
    """Assemble at time t, from the start values of the scene, of `guess` and of `start_at`.

    Numbers of the latter are kept; a state is kept as far as joints and drivers allow; a guess of
    what the scene fixes is refused. With `release`, fixed positions are guesses and start
    velocities zero, as a search for equilibrium takes them.
    """
    given = dict(guess or {})
    if isinstance(start_at, Assembly | State):
        start = start_of_state(start_at)
    else:
        start = start_values(equations.mechanism, guess, start_at, release=release)
        given |= start_at or {}
    t = float(t)
    equations.start.arrays["ease_q"][:] = start.ease[0]
    regular_start.place_counted(equations.start.table, t, equations.p, start.q)
    near = driven_from_drawing(equations, t, start)
    regular = regular_start.find_regular_start(equations, t, near)
    if regular is None:
        q, v, scale, findings = _irregular_start(equations, t, near, given)
    else:
        (q, v, scale), findings = regular, Findings([], [], equations.m)
    if start.spins:
        v = with_spins(equations, t, q, v, scale * start.ease[1], start.fixed_v, start.spins)
    return _report(equations, t, q, v, scale, start, findings)


def assemble_declared(mechanism: Mechanism) -> Assembly:
    """The start that a scene declares, with the defaults of its parameters, at t = 0.

    That of a search for equilibrium may leave what the scene fixes. `check`, `draw`, `build` and
    `load` ask for it, so that they say of a scene what its analyses say.
    """
    equations = Equations(mechanism, parameter_values(mechanism))
    return assemble(equations, release=equations.description.analysis == "equilibrium")


def _irregular_start(
    equations: Equations, t: float, start: Start, given: dict[str, float]
) -> tuple[FloatArray, FloatArray, FloatArray, Findings]:
    """The assembled state, (n,) each, typical changes, and dependent constraints."""
    description, drivers = equations.description, equations.description.driver_rows
    _require_magnitude(equations, t, start.q, given)
    _require_resolved_angles(description, t, start.q)
    size = equations.size(t, start.q)
    task = Task(
        equations, t, equations.scale(size), equations.row_scale(t, start.q, size),
        rows=np.ones(equations.m, dtype=np.bool_), free=~start.fixed_q,
        weight=regular_start.weights(start),
    )  # fmt: skip
    closing = close(task, start.q)
    if not closing.closed:
        raise why_open(task, start, closing.q, drivers)
    q = closing.q
    _require_resolved_angles(description, t, q)
    require_finite(equations, t, q, np.zeros_like(start.v))
    findings = redundancy.find_redundancy(task, q, drivers, start.v)
    if any(drivers[row] for row, _ in findings.lasting):
        raise redundancy_error(description, findings.lasting, findings.rank, "consistent")
    v = _velocities(task, start, q)
    if findings.lasting:
        findings = findings._replace(undetermined=redundancy.undetermined_rows(task, q))
    else:
        q, v = _start_on_branch(task, q, v, start.fixed_v) or (q, v)
    require_finite(equations, t, q, v)
    return q, v, task.scale, findings


def _require_magnitude(
    equations: Equations, t: float, q: FloatArray, given: dict[str, float]
) -> None:
    """Refuse values so large that the equations lose all digits."""
    arrays = equations.constraints(t, q), equations.slopes(t, q), q
    largest = max(float(np.abs(values).max(initial=0.0)) for values in arrays)
    if largest <= regular_start.LARGEST:
        return
    require_finite(equations, t, q, np.zeros_like(q))
    for row, value in zip(equations.description.parameters, equations.p.tolist(), strict=False):
        given |= {row.name: value} if value != row.default else {}
    values = ", ".join(f"{name} = {value:g}" for name, value in given.items())
    raise AssemblyError(
        f"{equations.description.title}: the values are out of scale: lengths and angles in the "
        f"constraints reach {largest:g} at t = {t:g} s, and {regular_start.LARGEST:g} is the most "
        f"that can be computed with. Given: {values or 'nothing but the defaults'}."
    )


def _require_resolved_angles(description: Description, t: float, q: FloatArray) -> None:
    """Refuse angles so large that their sines have lost the digits that closing a joint needs."""
    problems = [
        f"{description.title}: at t = {t:g} s {description.coordinates[k].name} is {q[k]:.6g} rad; "
        f"numbers of this size lie {np.spacing(q[k]):.2g} rad apart, so that its sine is "
        f"not known to the {_UNRESOLVED:g} to which joints close. Take whole turns off: start "
        "values and motion laws mean the same without them."
        for k in np.flatnonzero(description.is_angle & (np.spacing(np.abs(q)) > _UNRESOLVED))
    ]
    if problems:
        raise AssemblyError(problems)


def _velocities(task: Task, start: Start, q: FloatArray) -> FloatArray:
    """Velocities nearest to the start values that satisfy Φ_q v = ν."""
    equations, t = task.equations, task.t
    nu, free = equations.velocity_rhs(t, q), ~start.fixed_v
    v, matrix, change = start.v.copy(), equations.matrix_of(equations.slopes(t, q)), None
    ease = start.ease[1]
    scale, follows = task.scale * ease, abs(matrix) @ (ease - 1.0) > 0.0
    unit = task.row_scale * np.where(follows, ease.max(initial=1.0), 1.0)
    if free.any() and len(nu):
        if equations.is_large:
            eased = task._replace(scale=scale, row_scale=unit)
            slopes = eased.scaled(equations.slopes(t, q))[:, free]
        else:
            slopes = matrix[:, free] * scale[free] / unit[:, None]
        change = least_norm_solver(slopes)
    for _ in range(3):
        if change is not None:
            v[free] -= change((matrix @ v - nu) / unit) * scale[free]
    given = max(
        np.abs(start.v / task.scale).max(initial=0.0), np.abs(nu / task.row_scale).max(initial=0.0)
    )
    if change is not None and CLOSED * np.abs(v / task.scale).max() > given:
        v = start.v.copy()
        dense = slopes.toarray() if equations.is_large else slopes
        right = (matrix @ v - nu) / unit
        v[free] -= np.linalg.lstsq(dense, right, rcond=CLOSED)[0] * scale[free]
    gaps = matrix @ v - nu
    most = regular_start.VELOCITY_CLOSED * max(1.0, float(np.abs(v / task.scale).max(initial=0.0)))
    if np.abs(gaps / task.row_scale).max(initial=0.0) > most:
        open_by = misses(task, q, gaps, most, "/s")
        if start.fixed_v.any():
            fault = "velocities contradict the joints"
            names = [(row.velocity, row.velocity_unit) for row in equations.description.coordinates]
            raise contradiction(task, fault, names, start.v, start.fixed_v, open_by)
        about = equations.description
        more = ", or give more digits of axes and points" * bool(about.redundant and about.turning)
        raise AssemblyError(
            f"{equations.description.title}: no velocities satisfy joints and drivers at t = {t:g} "
            f"s: {open_by}. The position is singular for this motion; start elsewhere{more}."
        )
    return v


def _report(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, scale: FloatArray, start: Start,
    findings: Findings,
) -> Assembly:  # fmt: skip
    """What was assembled, and what became of the start."""
    require_mass(equations.description, np.array([t]), q[None])
    notes = mirror_note(equations.description, q), note_on_start(equations, t, start, q, scale)
    coordinates, table = equations.description.coordinates, equations.description.constraints
    before, after = np.array([start.q, start.v]), np.array([q, v])
    far = np.abs(after - before) > MOVED * scale * np.maximum(1.0, np.abs(after))
    moved = []  # but for what follows from bodies, since nobody gave it
    for k, i in np.argwhere(far.T & (start.ease.T == 1.0)).tolist():
        row, asked, reached = coordinates[k], float(before[i, k]), float(after[i, k])
        name, unit = (row.velocity, row.velocity_unit) if i else (row.name, row.unit)
        moved.append(Moved(name, asked, reached, unit))
    redundant = {}
    for k, sources in findings.lasting:
        origins = tuple(sorted({table[source].element for source in sources}))
        redundant[k] = Redundant(table[k].name, table[k].element, origins)
    elements = [row.element for row in table]
    phi, slopes = equations.constraints(t, q), equations.slopes(t, q)
    rates = equations.matrix_of(slopes) @ v - equations.velocity_rhs(t, q)
    return Assembly(
        t, q, v, largest_of(elements, phi), largest_of(elements, rates), tuple(moved),
        degrees_of_freedom=len(equations.description.positions) - findings.rank,
        singular=tuple(table[k].name for k, _ in findings.here_only),
        redundant=tuple(redundant.values()),
        not_unique=tuple(dict.fromkeys(elements[k] for k in findings.undetermined)),
        independent=tuple(k for k in range(len(table)) if k not in redundant),
        coordinates=coordinates, note=" ".join(filter(None, notes)),
    )  # fmt: skip


def _start_on_branch(
    task: Task, q: FloatArray, v: FloatArray, fixed_v: np.ndarray[tuple[int], np.dtype[np.bool_]]
) -> tuple[FloatArray, FloatArray] | None:
    """Position and velocity on a branch near (q, v) at a singular position, held ones kept."""
    equations = task.equations
    if not equations.m or not v.any() or equations.m >= equations.n:
        return None
    least = _least_singular_value(task, q)
    if not least < _NEAR:
        return None
    positions = SingularPositions(equations.scaled(task.scale, np.arange(equations.m)))
    rest = np.zeros_like(v)
    position = positions.find(taylor(task.t, q, v, rest), 0.0, branch=True)
    if position is None or position.gap > _ROUNDING:
        return None
    away = q - position.q
    if np.linalg.norm(away / task.scale) > _DISTINCT:
        part = float(away[fixed_v] @ v[fixed_v]) if fixed_v.any() else float(away @ v)
        along = away * np.sign(part or 1.0)
        along *= np.linalg.norm(v / task.scale) / np.linalg.norm(along / task.scale)
        position = positions.find(taylor(task.t, q, along, rest), 0.0, branch=True)
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
    """The least singular value of Φ_q, columns scaled, rows of unit length; 1 for an empty row."""
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
