"""A start that is far from its guess: its way there, bodies turned away, mirror images of loops.

With its drivers and what a scene fixes, a loop of bars closes in two ways or more, between which
the determinant of its constraints vanishes. So it has the other sign in the mirror image. The loops
are the irreducible blocks of Φ_q: the strong components of the graph of its columns, each of which
is matched with a row (A. L. Dulmage and N. S. Mendelsohn, Coverings of bipartite graphs, 1958).
"""

from collections.abc import Iterator

import numpy as np

from runtime.assembly.joint_closing import CLOSED, Task, refine
from runtime.assembly.start_values import Start
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.module_tables import Description

TURNED = 0.5 * np.pi  # accuracy: rad; a body that turns by more is far from its guess
_STAYED = 0.05  # measured: rad; a loop whose bodies all turn by less keeps its form
# measured: determinant, in rows of length 1, over that at the start; a guess with a smaller ratio
# is near to both forms of its loop
_BETWEEN = 0.05
_STEP = 0.05  # measured: of drivers from the drawing, scaled; 0.2 jumps between near branches
_MOST = 300  # safety: such steps
_STEPS = 5  # measured: of Gauss and Newton, towards where coordinates without a guess close best


def driven_from_drawing(equations: Equations, t: float, start: Start) -> Start:
    """The start, moved in steps from a drawing in space to its drivers at t if they are far."""
    description, q, before = equations.description, start.q, start.q
    if not description.turning or equations.m < len(description.positions):
        return start
    size, every = equations.size(t, q), np.ones(equations.m, np.bool_)
    scale, row_scale = equations.scale(size), equations.row_scale(t, q, size)
    gap = equations.constraints(t, q) * description.driver_rows
    steps = np.ceil(np.abs(gap / row_scale).max(initial=0.0) / _STEP)
    for part in np.linspace(1.0, 0.0, int(steps) + 1) if 1 < steps <= _MOST else ():
        task = Task(equations, t, scale, row_scale, every, ~start.fixed_q, scale, part * gap)
        before, q = q, refine(task, 2.0 * q - before)
        if not np.abs(task.gaps(q)).max() <= CLOSED:
            return start
    return start._replace(q=q)


def note_on_start(
    equations: Equations, t: float, start: Start, q: FloatArray, scale: FloatArray
) -> str:
    """Sentences on what is far from its guess at an assembled position q, (n,); empty if nothing.

    Coordinates without a start value or guess are nowhere near or far.
    """
    names = [row.name.rpartition(".") for row in equations.description.coordinates]
    is_angle = np.array([letter == "phi" for *_, letter in names], np.bool_)
    turns = np.remainder(q - start.q + np.pi, 2.0 * np.pi) - np.pi
    turned = np.where(is_angle & start.given_q, np.abs(turns), 0.0)
    angle_is_set = start.fixed_q[equations.mechanism.shape["counted"] > 0].any()
    in_space = [] if angle_is_set else [*_turned_bodies(equations.description, start, q)]
    if turned.max(initial=0.0) <= _STAYED and not in_space:
        return ""

    def said(columns: list[int]) -> str:
        return ", ".join(
            f"{names[k][0]} from {np.degrees(start.q[k]):.1f}° to {np.degrees(q[k]):.1f}°"
            for k in columns
        )

    parts, far = [], np.flatnonzero(turned > TURNED).tolist()
    if far or in_space:
        bodies = ", ".join(in_space) or said(far)
        parts.append(f"Closing the joints turns by more than a right angle: {bodies}.")
    for loop in _mirrored_loops(equations, t, start, q, scale):
        angles = [k for k in loop if is_angle[k]]
        if angles and start.given_q[angles].all():
            parts.append(f"A loop closes as the mirror image of its guess: {said(angles)}.")
    advice = "If another position is meant, give guesses nearer to it."
    return " ".join([*parts, advice]) if parts else ""


def _turned_bodies(description: Description, start: Start, q: FloatArray) -> Iterator[str]:
    """The bodies in space that turn by more than a right angle from a given attitude."""
    for body, first in description.turning:
        p = slice(first, first + 4)
        size = float(np.linalg.norm(start.q[p]))
        half = np.arccos(min(1.0, abs(float(start.q[p] @ q[p])) / size)) if size else 0.0
        if (start.given_q[p].any() or start.q[first] != 1.0) and 2.0 * half > TURNED:
            yield f"{body} by {np.degrees(2.0 * half):.1f}°"


def _mirrored_loops(
    equations: Equations, t: float, start: Start, q: FloatArray, scale: FloatArray
) -> Iterator[list[int]]:
    """The columns of the coordinates of each loop whose determinant has changed its sign.

    Coordinates without a guess are where the joints close best. There are no loops where more
    coordinates are free than the constraints determine.
    """
    free = np.flatnonzero(~start.fixed_q)
    if equations.is_large or len(free) != equations.m:
        return
    from scipy.sparse import csr_array  # runs that start near their guesses load none of it
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

    guess, loose = start.q.copy(), np.flatnonzero(~start.given_q & ~start.fixed_q)
    for _ in range(_STEPS):
        slopes = (equations.jacobian(t, guess) * scale)[:, loose]
        gaps = equations.constraints(t, guess)
        if not (np.isfinite(slopes).all() and np.isfinite(gaps).all()):
            return
        guess[loose] -= scale[loose] * np.linalg.lstsq(slopes, gaps, rcond=None)[0]
    before, after = ((equations.jacobian(t, at) * scale)[:, free] for at in (guess, q))
    graph = csr_array((before != 0.0) | (after != 0.0))
    match = maximum_bipartite_matching(graph, perm_type="column")
    if (match < 0).any():
        return
    count, loops = connected_components(graph[:, match], connection="strong")
    for loop in range(count):
        rows = np.flatnonzero(loops == loop)
        block = np.ix_(rows, match[rows])
        here, there = (
            np.linalg.det(m[block] / np.linalg.norm(m[block], axis=1, keepdims=True))
            for m in (before, after)
        )
        if here * there < 0.0 and abs(here) > _BETWEEN * abs(there):
            yield sorted(free[match[rows]].tolist())
