"""Assembly: positions and velocities that satisfy joints, drivers and the fixed start values.

Start values with the role "fixed" are kept. The others are guesses: positions move as little as
closing the joints allows, velocities as little as Phi_q v = nu allows.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import AssemblyError, RedundancyError
from runtime.assembly.closure import CLOSED, Closing, Task, close
from runtime.assembly.near_singular_start import start_on_branch
from runtime.assembly.redundancy import (
    Dependency,
    Findings,
    find_redundancy,
    overdetermined_rows,
    structural_redundancy,
    undetermined_rows,
)
from runtime.linalg.rank_policy import NO_PIVOT
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.description import unknown
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.results.assembled_state import Assembly, Moved, Redundant
from runtime.validation.arguments import number
from runtime.validation.parameters import parameter_values

BoolArray = npt.NDArray[np.bool_]

_VELOCITY_CLOSED = 1e-9  # accuracy: residual of Φ_q v = ν, scaled, in parts of the largest speed
# measured: weight of a coordinate that the scene names no value of; the others have 1
_UNNAMED_WEIGHT = 1e-3
_LARGEST = 1e100  # safety: lengths and angles above this overflow when they are squared


class Start(NamedTuple):
    """Start values as arrays, whether they are fixed, and whether they are given; each (n,)."""

    q: FloatArray
    v: FloatArray
    fixed_q: BoolArray
    fixed_v: BoolArray
    given_q: BoolArray


def start_values(mechanism: Mechanism, guess: Values | None) -> Start:
    """The scene's start values, with the user's in place of those of the same name."""
    table = mechanism.description.coordinates
    q_places = {row.name: index for index, row in enumerate(table)}
    v_places = {row.velocity: index for index, row in enumerate(table)}
    q, v = mechanism.description.neutral, np.zeros(len(table))
    fixed_q, fixed_v = np.zeros(len(table), np.bool_), np.zeros(len(table), np.bool_)
    given_q = np.zeros(len(table), np.bool_)
    for row in mechanism.description.start:
        if row.role == "neutral":
            continue
        if row.name in q_places:
            place = q_places[row.name]
            q[place], fixed_q[place], given_q[place] = row.value, row.role == "fixed", True
        else:
            place = v_places[row.name]
            v[place], fixed_v[place] = row.value, row.role == "fixed"
    problems = []
    for name, value in (guess or {}).items():
        finite = number(value)
        if finite is None or not np.isfinite(finite):
            problems.append(f"Start value {name} is {value!r}; it must be a finite number.")
        elif name in q_places:
            q[q_places[name]], given_q[q_places[name]] = finite, True
        elif name in v_places:
            v[v_places[name]] = finite
        else:
            problems.append(unknown("coordinate or velocity", name, [*q_places, *v_places]))
    if problems:
        raise AssemblyError(problems)
    return Start(q, v, fixed_q, fixed_v, given_q)


def assemble(
    mechanism: Mechanism,
    guess: Values | None = None,
    parameters: Values | None = None,
    t: float = 0.0,
    *,
    release: bool = False,
) -> Assembly:
    """Assemble at time t.

    Parameters
    ----------
    guess
        Start values by coordinate or velocity name, over those of the scene; a name that the
        scene fixes stays fixed, at the new value.
    release
        Treat fixed positions as guesses and leave velocities at zero change, as a search for
        equilibrium does.
    """
    equations = Equations(mechanism, parameter_values(mechanism, parameters))
    start = start_values(mechanism, guess)
    if release:
        none = np.zeros_like(start.fixed_q)
        start = start._replace(fixed_q=none, fixed_v=none, v=np.zeros_like(start.v))
    t = float(t)
    drivers = mechanism.description.driver_rows
    _require_magnitude(equations, t, start.q, {**(guess or {}), **(parameters or {})})
    size = equations.size(t, start.q)
    matrix = equations.jacobian(t, start.q)
    units = equations.row_units(matrix)
    task = Task(
        equations=equations,
        t=t,
        scale=equations.scale(size),
        row_scale=np.array([size if unit == "m" else 1.0 for unit in units]),
        rows=np.ones(equations.m, dtype=np.bool_),
        free=~start.fixed_q,
        weight=np.where(start.given_q, 1.0, _UNNAMED_WEIGHT),
    )
    closing = close(task, start.q)
    if not closing.closed:
        raise _why_open(mechanism, task, start, closing, units)
    findings = find_redundancy(task, closing.q, drivers, start.v)
    if any(drivers[row] for row, _ in findings.lasting):
        raise _redundancy(mechanism, findings.lasting, drivers, findings.rank, "consistent")
    v, velocity_gaps = _velocities(mechanism, task, start, closing.q)
    near = None if findings.lasting else start_on_branch(task, closing.q, v, start.fixed_v)
    if near is not None:
        phi, v = equations.constraints(t, near.q), near.v
        closing = Closing(near.q, phi, closing.gap)
        velocity_gaps = equations.jacobian(t, near.q) @ v - equations.velocity_rhs(t, near.q)
    return _report(mechanism, task, start, closing, v, velocity_gaps, findings, units)


def _require_magnitude(equations: Equations, t: float, q: FloatArray, given: Values) -> None:
    """Refuse values so large that the equations lose all digits."""
    phi, matrix = equations.constraints(t, q), equations.jacobian(t, q)
    largest = max(
        float(np.abs(phi).max(initial=0.0)),
        float(np.abs(matrix).max(initial=0.0)),
        float(np.abs(q).max(initial=0.0)),
    )
    if largest <= _LARGEST:
        return
    values = ", ".join(f"{name} = {value:g}" for name, value in given.items())
    raise AssemblyError(
        f"{equations.description.title}: the values are out of scale: lengths and angles in the "
        f"constraints reach {largest:g} at t = {t:g} s, and {_LARGEST:g} is the most that can be "
        f"computed with. Given: {values or 'nothing but the defaults'}."
    )


def _velocities(
    mechanism: Mechanism, task: Task, start: Start, q: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Velocities nearest to the start values that satisfy Phi_q v = nu, and the residual."""
    equations, t = task.equations, task.t
    matrix, nu = equations.jacobian(t, q), equations.velocity_rhs(t, q)
    free = ~start.fixed_v
    v = start.v.copy()
    slopes = matrix[:, free] * task.scale[free] / task.row_scale[:, None]
    for _ in range(3):
        gaps = (matrix @ v - nu) / task.row_scale
        if free.any() and len(gaps):
            v[free] -= np.linalg.lstsq(slopes, gaps, rcond=NO_PIVOT)[0] * task.scale[free]
    gaps = matrix @ v - nu
    speed = max(1.0, float(np.abs(v / task.scale).max(initial=0.0)))
    if np.abs(gaps / task.row_scale).max(initial=0.0) > _VELOCITY_CLOSED * speed:
        fixed = ", ".join(
            f"{row.velocity} = {start.v[index]:g} {row.velocity_unit}"
            for index, row in enumerate(mechanism.description.coordinates)
            if start.fixed_v[index]
        )
        misses = _misses(equations, gaps, equations.row_units(matrix), 1e-9 * speed, "/s")
        if not fixed:
            raise AssemblyError(
                f"{mechanism.title}: no velocities satisfy joints and drivers at "
                f"t = {t:g} s: {misses}. The position is singular for this motion; start elsewhere."
            )
        raise AssemblyError(
            f"{mechanism.title}: the fixed start velocities contradict the joints. "
            f"Start says {fixed}; with these {misses}. "
            f'Give one of them the role "guess", or correct its value.'
        )
    return v, gaps


def _why_open(
    mechanism: Mechanism, task: Task, start: Start, closing: Closing, units: list[str]
) -> AssemblyError:
    """The error of joints that do not close."""
    description = mechanism.description
    drivers = description.driver_rows
    doubled = structural_redundancy(task, closing.q, drivers) or overdetermined_rows(
        task, closing.q, drivers
    )
    if doubled:
        rank = len(task.rows) - int(drivers.sum()) - len(doubled)
        return _redundancy(mechanism, doubled, drivers, rank, "contradictory", closing.phi)
    phi, equations = closing.phi, task.equations
    if start.fixed_q.any():
        loose = close(task._replace(free=np.ones_like(task.free)), start.q)
        if loose.closed:
            fixed = ", ".join(
                f"{row.name} = {start.q[index]:g} {row.unit}"
                for index, row in enumerate(mechanism.description.coordinates)
                if start.fixed_q[index]
            )
            return AssemblyError(
                f"{description.title}: the fixed start values contradict the joints at t = "
                f"{task.t:g} s. Start says {fixed}; with these "
                f"{_misses(equations, phi, units, CLOSED)}. "
                f'Give one of them the role "guess", or correct its value.'
            )
    if drivers.any():
        free = np.ones_like(task.free)
        joints = close(task._replace(rows=~drivers, free=free), start.q)
        if joints.closed:
            driven = close(task._replace(free=free), joints.q)
            gaps = _misses(equations, driven.phi, units, CLOSED)
            names = ", ".join(description.drivers)
            return AssemblyError(
                f"{description.title}: the joints close, but not with what the drivers ({names}) "
                f"demand at t = {task.t:g} s: {gaps}. The driver asks for a position out of reach, "
                f"or fights the joints; change its value at this time or the dimensions."
            )
    return AssemblyError(
        f"{description.title}: the machine cannot be assembled at t = {task.t:g} s; the nearest "
        f"that it comes leaves gaps: {_misses(equations, phi, units, CLOSED)}. Check the "
        "dimensions and attachment points of these joints, or start nearer to an assembled "
        "position."
    )


def _misses(
    equations: Equations, values: FloatArray, units: list[str], least: float, per: str = ""
) -> str:
    """`joint C misses by 0.31 m, ...`, the worst first."""
    drivers = equations.description.drivers
    misses = sorted(equations.misses(values, units).items(), key=lambda item: -item[1])
    return ", ".join(
        f"{'driver' if element in drivers else 'joint'} {element} misses by {miss:.4g} {unit}{per}"
        for (element, unit), miss in misses[:6]
        if miss > least
    )


def _redundancy(
    mechanism: Mechanism,
    dependencies: list[Dependency],
    drivers: BoolArray,
    independent: int,
    kind: str,
    phi: FloatArray | None = None,
) -> RedundancyError:
    """The error that names dependent constraints and what to remove."""
    description = mechanism.description
    names = description.constraints.names
    problems = []
    for row, sources in dependencies:
        element = description.constraints[row].element
        from_elements = sorted({description.constraints[source].element for source in sources})
        origin = f"follows from {', '.join(from_elements)}" if from_elements else "moves nothing"
        if drivers[row]:
            problems.append(
                f"{description.title}: driver {element} fights the joints: what it drives is "
                f"already determined ({names[row]} {origin}). Remove {element}, or free that "
                "motion."
            )
            continue
        gap = "" if phi is None else f", and contradicts them (gap {abs(phi[row]):.4g})"
        problems.append(
            f"{description.title}: constraint {names[row]} is redundant and {kind}: it "
            f"{origin}{gap}. Remove {element}, or use a joint with fewer constraints in its place "
            f"({len(description.coordinates)} coordinates, {len(names)} constraints, "
            f"{independent} independent)."
        )
    return RedundancyError(problems)


def _report(
    mechanism: Mechanism,
    task: Task,
    start: Start,
    closing: Closing,
    v: FloatArray,
    velocity_gaps: FloatArray,
    findings: Findings,
    units: list[str],
) -> Assembly:
    moved = []
    for index, row in enumerate(mechanism.description.coordinates):
        small = 1e-9 * task.scale[index]
        pairs = (
            (row.name, start.q[index], closing.q[index], row.unit),
            (row.velocity, start.v[index], v[index], row.velocity_unit),
        )
        moved += [
            Moved(name, float(start_value), float(reached), unit)
            for name, start_value, reached, unit in pairs
            if abs(reached - start_value) > small * max(1.0, abs(reached))
        ]
    table = mechanism.description.constraints
    names = table.names
    redundant = tuple(
        Redundant(
            names[row], table[row].element, tuple(sorted({table[k].element for k in sources}))
        )
        for row, sources in findings.lasting
    )
    lost = {dependency.row for dependency in findings.lasting}
    shares = undetermined_rows(task, closing.q) if redundant else ()

    def by_element(values: FloatArray) -> dict[str, float]:
        largest: dict[str, float] = {}
        for (element, _), miss in task.equations.misses(values, units).items():
            largest[element] = max(largest.get(element, 0.0), miss)
        return largest

    return Assembly(
        t=task.t,
        q=closing.q,
        v=v,
        residual=by_element(closing.phi),
        velocity_residual=by_element(velocity_gaps),
        moved=tuple(moved),
        degrees_of_freedom=len(mechanism.description.coordinates) - findings.rank,
        singular=tuple(names[dependency.row] for dependency in findings.here_only),
        redundant=redundant,
        not_unique=tuple(dict.fromkeys(table[row].element for row in shares)),
        independent=tuple(row for row in range(len(names)) if row not in lost),
        coordinates=mechanism.description.coordinates,
    )
