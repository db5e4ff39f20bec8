"""Errors of an assembly: open joints, start values that contradict them, too many constraints."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from codegen.errors import AssemblyError, RedundancyError
from codegen.object_display import with_unit
from runtime.assembly import redundancy
from runtime.assembly.joint_closing import CLOSED, Task, close, least_gap
from runtime.assembly.redundancy import Dependency
from runtime.assembly.start_values import Start
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.validation.finite_equations import require_finite

BoolArray = npt.NDArray[np.bool_]
Key = TypeVar("Key")
_NOISE = 1e-6  # accuracy: of the worst gap; smaller ones are rounding


def why_open(task: Task, start: Start, q: FloatArray, drivers: BoolArray) -> AssemblyError:
    """The error of joints that do not close; q is where they come nearest to it."""
    require_finite(task.equations, task.t, q, np.zeros_like(q))
    for body, first in task.equations.description.turning:
        p = slice(first, first + 4)
        length = float(np.linalg.norm(start.q[p][start.fixed_q[p]]))
        if length > 1.0 + CLOSED or (start.fixed_q[p].all() and length < 1.0 - CLOSED):
            return AssemblyError(
                f"{task.equations.description.title}: the Euler parameters e0 to e3 of '{body}' "
                f"must have the length 1; those that the start fixes have {length:.6g}."
            )
    description, phi = task.equations.description, task.equations.constraints(task.t, q)
    doubled = redundancy.dependent_joints(task, q, drivers)
    if doubled:
        rank = len(task.rows) - int(drivers.sum()) - len(doubled)
        return redundancy_error(description, doubled, rank, "contradictory", phi)
    gaps = misses(task, q, phi, CLOSED)
    released = task._replace(free=np.ones_like(task.free))
    if start.fixed_q.any() and close(released, start.q).closed:
        names = [(row.name, row.unit) for row in description.coordinates]
        rows, columns = description.jacobian_rows, description.jacobian_columns
        settled = np.isin(np.arange(len(phi)), rows[~start.fixed_q[columns]], invert=True)
        if (settled & (np.abs(phi) > CLOSED)).any():  # an open row that no guess enters
            fault = f"values contradict the joints at t = {task.t:g} s"
        else:
            fault = (
                f"values leave joints open at t = {task.t:g} s from these guesses, and nearer "
                "guesses may close them"
            )
        return contradiction(task, fault, names, start.q, start.fixed_q, gaps)
    if drivers.any():
        joints = close(released._replace(rows=~drivers), start.q)
        if joints.closed:
            there = close(released, joints.q).q
            left = task.equations.constraints(task.t, there)
            reach = " or ".join(out_of_reach(released, start.q, joints.q, drivers))
            return AssemblyError(
                f"{description.title}: the joints close, but not with what the drivers "
                f"({', '.join(description.drivers)}) demand at t = {task.t:g} s: "
                f"{reach or misses(task, there, left, CLOSED)}. Change its value at this time, or "
                "the dimensions."
            )
    return AssemblyError(
        f"{description.title}: the machine cannot be assembled at t = {task.t:g} s; the nearest "
        f"that it comes leaves gaps: {gaps}. Check the dimensions and attachment points of these "
        "joints, or start nearer to an assembled position."
    )


def out_of_reach(
    task: Task, start: FloatArray, joined: FloatArray, drivers: BoolArray
) -> Iterator[str]:
    """For each driver without which all else closes: how far beyond its reach its value is.

    All else closes from the `start`, or from a position in which the joints alone do, (n,) each.
    """
    for row in np.flatnonzero(drivers).tolist():
        others = task._replace(rows=np.arange(task.equations.m) != row)
        closings = [close(others, start), close(others, joined)]
        closed = [closing.q for closing in closings if closing.closed]
        if not closed:
            continue
        gap = min((least_gap(task, row, q) for q in closed), key=abs)
        unit = task.equations.row_units(task.equations.slopes(task.t, closed[0]))[row]
        yield (
            f"driver {task.equations.description.constraints[row].element} asks for "
            f"{abs(gap):.3g} {unit} {'more' if gap < 0.0 else 'less'} than the joints let it reach"
        )


def contradiction(
    task: Task, fault: str, names: list[tuple[str, str]], values: FloatArray, fixed: BoolArray,
    misses: str,
) -> AssemblyError:  # fmt: skip
    """The error of start values that the joints do not allow; their `names` with their units."""
    said = (f"{names[k][0]} = {with_unit(values[k], names[k][1])}" for k in np.flatnonzero(fixed))
    shows = "" if task.equations.description.turning else ", and `linkwright draw` shows the gaps"
    return AssemblyError(
        f"{task.equations.description.title}: the fixed start {fault}. Start says "
        f"{', '.join(said)}; with these {misses}. "
        "Make one of them a guess (guess=), or correct its value. Where a point of a joint may be "
        f"wrong, `linkwright check` looks for it{shows}."
    )


def misses(task: Task, q: FloatArray, values: FloatArray, least: float, per: str = "") -> str:
    """`joint C misses by 0.31 m, ...`, the worst first; that one in any case."""
    equations, description = task.equations, task.equations.description
    units = equations.row_units(equations.slopes(task.t, q))
    elements = (row.element for row in description.constraints)
    found = largest_of(zip(elements, units, strict=True), values)
    worst = sorted(found.items(), key=lambda item: -item[1])[:6]
    return ", ".join(
        f"{'driver' if element in description.drivers else 'joint'} {element} misses by "
        f"{miss:.4g} {unit}{per}".removesuffix(" 1")
        for place, ((element, unit), miss) in enumerate(worst)
        if miss > max(least, _NOISE * worst[0][1]) or place == 0
    )


def largest_of(keys: Iterable[Key], values: FloatArray) -> dict[Key, float]:
    """Largest |value| of each key."""
    found: dict[Key, float] = {}
    for key, value in zip(keys, values, strict=True):
        found[key] = max(found.get(key, 0.0), abs(float(value)))
    return found


def redundancy_error(
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
