"""Assembly: positions and velocities that satisfy joints, drivers and the fixed start values.

Start values with the role "fixed" are kept. The others are guesses: positions move as little as
closing the joints allows, velocities as little as Phi_q v = nu allows.
"""

from collections.abc import Iterable
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from codegen.errors import AssemblyError, RedundancyError
from runtime.assembly import redundancy
from runtime.assembly.accurate_start_near_singularity import start_on_branch
from runtime.assembly.joint_closing import CLOSED, Closing, Task, close
from runtime.assembly.redundancy import Dependency, Findings
from runtime.assembly.regular_start import LARGEST, VELOCITY_CLOSED, find_regular_start, weights
from runtime.assembly.start_values import MOVED, Start, start_of_state, start_values
from runtime.linalg.least_norm import least_norm_solver
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.mechanism.module_tables import Description
from runtime.results.assembled_state import Assembly, Moved, Redundant, State
from runtime.validation.finite_equations import require_finite
from runtime.validation.parameters import parameter_values

BoolArray = npt.NDArray[np.bool_]
Key = TypeVar("Key")

_UNRESOLVED = 1e-8  # accuracy: rad; distance of neighbouring numbers at which sin φ has no digits


def assemble(
    mechanism: Mechanism, guess: Values | None = None, parameters: Values | None = None,
    t: float = 0.0, *, start_at: Values | State | None = None, release: bool = False,
) -> Assembly:  # fmt: skip
    """Assemble at time t, from the start values of the scene, of `guess` and of `start_at`.

    Values of the latter are kept; a state is kept as far as joints and drivers allow; a guess of
    what the scene fixes is refused. With `release`, fixed positions are guesses and start
    velocities zero, as a search for equilibrium takes them.
    """
    equations = Equations(mechanism, parameter_values(mechanism, parameters))
    if isinstance(start_at, State):
        start = start_of_state(start_at)
    else:
        start = start_values(mechanism, guess, start_at, release=release)
    t = float(t)
    drivers = mechanism.description.driver_rows
    said = {} if isinstance(start_at, State) else start_at or {}
    if (found := find_regular_start(equations, t, start)) is not None:
        q, v, scale = found
        slopes = equations.slopes(t, q)
        gaps = equations.matrix_of(slopes) @ v - equations.velocity_rhs(t, q)
        phi = equations.constraints(t, q)
        independent = Findings([], [], equations.m)
        return _report(equations, t, scale, start, (q, v), (phi, gaps), independent)
    _require_magnitude(equations, t, start.q, {**(guess or {}), **said, **(parameters or {})})
    _require_resolved_angles(mechanism.description, t, start.q)
    size, slopes = equations.size(t, start.q), equations.slopes(t, start.q)
    task = Task(
        equations, t, equations.scale(size), equations.row_scale(t, start.q, size),
        equations.row_units(slopes), rows=np.ones(equations.m, dtype=np.bool_),
        free=~start.fixed_q, weight=weights(start),
    )  # fmt: skip
    closing = close(task, start.q)
    if not closing.closed:
        raise _why_open(task, start, closing, drivers)
    _require_resolved_angles(mechanism.description, t, closing.q)
    findings = redundancy.find_redundancy(task, closing.q, drivers, start.v)
    if any(drivers[row] for row, _ in findings.lasting):
        raise _redundancy(mechanism.description, findings.lasting, findings.rank, "consistent")
    require_finite(equations, t, closing.q, np.zeros_like(start.v))
    v, velocity_gaps = _velocities(task, start, closing.q)
    near = None if findings.lasting else start_on_branch(task, closing.q, v, start.fixed_v)
    if near is not None:
        q, v = near
        closing = Closing(q, equations.constraints(t, q), closing.gap)
        velocity_gaps = equations.matrix_of(equations.slopes(t, q)) @ v - equations.velocity_rhs(
            t, q
        )
    require_finite(equations, t, closing.q, v)
    state, gaps = (closing.q, v), (closing.phi, velocity_gaps)
    shares = redundancy.undetermined_rows(task, closing.q) if findings.lasting else ()
    return _report(equations, t, task.scale, start, state, gaps, findings, shares)


def _require_magnitude(equations: Equations, t: float, q: FloatArray, given: Values) -> None:
    """Refuse values so large that the equations lose all digits."""
    arrays = equations.constraints(t, q), equations.slopes(t, q), q
    largest = max(float(np.abs(values).max(initial=0.0)) for values in arrays)
    if largest <= LARGEST:
        return
    require_finite(equations, t, q, np.zeros_like(q))
    values = ", ".join(f"{name} = {value:g}" for name, value in given.items())
    raise AssemblyError(
        f"{equations.description.title}: the values are out of scale: lengths and angles in the "
        f"constraints reach {largest:g} at t = {t:g} s, and {LARGEST:g} is the most that can be "
        f"computed with. Given: {values or 'nothing but the defaults'}."
    )


def _require_resolved_angles(description: Description, t: float, q: FloatArray) -> None:
    """Refuse angles so large that their sines have lost the digits that closing a joint needs."""
    problems = [
        f"{description.title}: at t = {t:g} s {description.coordinates[k].name} is {q[k]:.6g} rad; "
        f"numbers of this size lie {np.spacing(q[k]):.2g} rad apart, so that its sine is "
        f"not known to the {_UNRESOLVED:g} to which joints close. Take whole turns off: start "
        "values and motion laws mean the same without them."
        for k in np.flatnonzero(~description.is_length & (np.spacing(np.abs(q)) > _UNRESOLVED))
    ]
    if problems:
        raise AssemblyError(problems)


def _velocities(task: Task, start: Start, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Velocities nearest to the start values that satisfy Φ_q v = ν, and the residual."""
    equations, t = task.equations, task.t
    nu, free = equations.velocity_rhs(t, q), ~start.fixed_v
    v, matrix, change = start.v.copy(), equations.matrix_of(equations.slopes(t, q)), None
    if free.any() and len(nu):
        if equations.is_large:
            slopes = task.scaled(equations.slopes(t, q))[:, free]
        else:
            slopes = matrix[:, free] * task.scale[free] / task.row_scale[:, None]
        change = least_norm_solver(slopes)
    for _ in range(3):
        gaps = (matrix @ v - nu) / task.row_scale
        if change is not None:
            v[free] -= change(gaps) * task.scale[free]
    gaps = matrix @ v - nu
    speed = max(1.0, float(np.abs(v / task.scale).max(initial=0.0)))
    if np.abs(gaps / task.row_scale).max(initial=0.0) > VELOCITY_CLOSED * speed:
        misses = _misses(task, gaps, VELOCITY_CLOSED * speed, "/s")
        if start.fixed_v.any():
            fault = "velocities contradict the joints"
            names = [(row.velocity, row.velocity_unit) for row in equations.description.coordinates]
            raise _contradiction(task, fault, names, start.v, start.fixed_v, misses)
        raise AssemblyError(
            f"{equations.description.title}: no velocities satisfy joints and drivers at "
            f"t = {t:g} s: {misses}. The position is singular for this motion; start elsewhere."
        )
    return v, gaps


def _contradiction(
    task: Task, fault: str, names: list[tuple[str, str]], values: FloatArray, fixed: BoolArray,
    misses: str,
) -> AssemblyError:  # fmt: skip
    """The error of start values that the joints do not allow; their `names` with their units."""
    said = (f"{names[k][0]} = {values[k]:g} {names[k][1]}" for k in np.flatnonzero(fixed))
    return AssemblyError(
        f"{task.equations.description.title}: the fixed start {fault}. Start says "
        f"{', '.join(said)}; with these {misses}. "
        "Make one of them a guess (guess=), or correct its value. Where a point of a joint may be "
        "wrong, `linkwright check` looks for it, and `linkwright draw` shows the gaps."
    )


def _why_open(task: Task, start: Start, closing: Closing, drivers: BoolArray) -> AssemblyError:
    """The error of joints that do not close."""
    description = task.equations.description
    doubled = redundancy.dependent_joints(task, closing.q, drivers)
    if doubled:
        rank = len(task.rows) - int(drivers.sum()) - len(doubled)
        return _redundancy(description, doubled, rank, "contradictory", closing.phi)
    gaps = _misses(task, closing.phi, CLOSED)
    released = task._replace(free=np.ones_like(task.free))
    if start.fixed_q.any() and close(released, start.q).closed:
        names = [(row.name, row.unit) for row in description.coordinates]
        fault = f"values contradict the joints at t = {task.t:g} s"
        return _contradiction(task, fault, names, start.q, start.fixed_q, gaps)
    if drivers.any():
        joints = close(released._replace(rows=~drivers), start.q)
        if joints.closed:
            driven = close(released, joints.q)
            return AssemblyError(
                f"{description.title}: the joints close, but not with what the drivers "
                f"({', '.join(description.drivers)}) demand at t = {task.t:g} s: "
                f"{_misses(task, driven.phi, CLOSED)}. The driver asks for a position out of "
                "reach, or fights the joints; change its value at this time or the dimensions."
            )
    return AssemblyError(
        f"{description.title}: the machine cannot be assembled at t = {task.t:g} s; the nearest "
        f"that it comes leaves gaps: {gaps}. Check the dimensions and attachment points of these "
        "joints, or start nearer to an assembled position."
    )


def _largest(keys: Iterable[Key], values: FloatArray) -> dict[Key, float]:
    """Largest |value| of each key."""
    found: dict[Key, float] = {}
    for key, value in zip(keys, values, strict=True):
        found[key] = max(found.get(key, 0.0), abs(float(value)))
    return found


def _misses(task: Task, values: FloatArray, least: float, per: str = "") -> str:
    """`joint C misses by 0.31 m, ...`, the worst first; that one in any case."""
    description = task.equations.description
    elements = (row.element for row in description.constraints)
    found = _largest(zip(elements, task.row_units, strict=True), values)
    worst = sorted(found.items(), key=lambda item: -item[1])[:6]
    return ", ".join(
        f"{'driver' if element in description.drivers else 'joint'} {element} misses by "
        f"{miss:.4g} {unit}{per}"
        for place, ((element, unit), miss) in enumerate(worst)
        if miss > least or place == 0
    )


def _redundancy(
    description: Description, dependencies: list[Dependency], independent: int, kind: str,
    phi: FloatArray | None = None,
) -> RedundancyError:  # fmt: skip
    """The error that names dependent constraints and what to remove."""
    table, problems = description.constraints, []
    for row, sources in dependencies:
        name, element = table[row].name, table[row].element
        from_elements = sorted({table[source].element for source in sources})
        origin = f"follows from {', '.join(from_elements)}" if from_elements else "moves nothing"
        if element in description.drivers:
            problems.append(
                f"{description.title}: driver {element} fights the joints: what it drives is "
                f"already determined ({name} {origin}). Remove {element}, or free that motion."
            )
            continue
        gap = "" if phi is None else f", and contradicts them (gap {abs(phi[row]):.4g})"
        problems.append(
            f"{description.title}: constraint {name} is redundant and {kind}: it "
            f"{origin}{gap}. Remove {element}, or use a joint with fewer constraints in its place "
            f"({len(description.positions)} coordinates, {len(table)} constraints, "
            f"{independent} independent)."
        )
    return RedundancyError(problems)


def _report(
    equations: Equations, t: float, scale: FloatArray, start: Start,
    state: tuple[FloatArray, FloatArray], gaps: tuple[FloatArray, FloatArray], findings: Findings,
    shares: Iterable[int] = (),
) -> Assembly:  # fmt: skip
    """What was assembled: the state (q, v), Φ and Φ_q v - ν there, and what became of the start."""
    description, (q, v) = equations.description, state
    coordinates, table = description.coordinates, description.constraints
    moved: list[Moved] = []
    before, after = np.array([start.q, start.v]), np.array(state)
    least = MOVED * scale * np.maximum(1.0, np.abs(after))
    for k in np.flatnonzero((np.abs(after - before) > least).any(axis=0)).tolist():
        row = coordinates[k]
        pair = (
            Moved(row.name, float(start.q[k]), float(q[k]), row.unit),
            Moved(row.velocity, float(start.v[k]), float(v[k]), row.velocity_unit),
        )
        small = MOVED * scale[k]
        moved += [one for one in pair if abs(one.by) > small * max(1.0, abs(one.reached))]
    redundant = {}
    for k, sources in findings.lasting:
        origins = tuple(sorted({table[source].element for source in sources}))
        redundant[k] = Redundant(table[k].name, table[k].element, origins)
    elements = [row.element for row in table]
    return Assembly(
        t, q, v, _largest(elements, gaps[0]), _largest(elements, gaps[1]),
        tuple(moved), degrees_of_freedom=len(description.positions) - findings.rank,
        singular=tuple(table[k].name for k, _ in findings.here_only),
        redundant=tuple(redundant.values()),
        not_unique=tuple(dict.fromkeys(elements[k] for k in shares)),
        independent=tuple(k for k in range(len(table)) if k not in redundant),
        coordinates=coordinates,
    )  # fmt: skip
