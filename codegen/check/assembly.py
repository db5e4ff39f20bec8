"""Whether the joints of a scene close at the start, found before anything is compiled.

As the assembly of a run does, this keeps what the scene fixes and moves what it guesses. The
interpreter evaluates the constraints, and Gauss-Newton steps close them; where that fails, it is
tried anew from other values of the coordinates that the scene says nothing of.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from codegen.lower.lowered_scene import Lowered
from codegen.lower.poses_near_start import FloatArray, Poses

_RESTARTS = 12  # safety: random starts after the given one has failed
_MOVED = 1e-9  # accuracy: of the machine's size; a coordinate that moves less has stayed
_SHOWN = 6  # layout: joints that a message lists


@dataclass(frozen=True)
class Moved:
    """A coordinate that closing the joints moves: its guess, the value reached, the unit."""

    name: str
    guess: float
    reached: float
    unit: str


class Assembly(NamedTuple):
    """The position at which the joints close, or what keeps them open.

    Attributes
    ----------
    gap
        The largest residual of a constraint, m or rad.
    moved
        The coordinates that are not where the scene guesses them, the largest change first.
    problem
        A sentence about joints that stay open; nothing where they close.
    """

    gap: float
    moved: tuple[Moved, ...]
    problem: str


def assemble_at_start(lowered: Lowered) -> Assembly:
    """Close the joints of a scene at t = 0."""
    poses = Poses(lowered)
    q = _closed(poses, poses.free)
    gap = float(np.abs(poses.residual(q)).max(initial=0.0))
    rows = zip(lowered.description.coordinates, poses.guess, q, poses.unit, strict=True)
    moved = [
        (abs(reached - guess) / unit, Moved(row[0], float(guess), float(reached), row[2]))
        for row, guess, reached, unit in rows
        if abs(reached - guess) > _MOVED * unit
    ]
    moved.sort(key=lambda pair: -pair[0])
    problem = "" if poses.holds(q) else _why_open(lowered, poses, q)
    return Assembly(gap, tuple(one for _, one in moved), problem)


def _closed(poses: Poses, free: FloatArray, kept: FloatArray | float = 1.0) -> FloatArray:
    """A position at which the constraints hold, or the one that comes nearest."""
    known = {name for name, *_ in poses.description.start}
    unknown = np.array([name not in known for name, *_ in poses.description.coordinates])
    random = np.random.default_rng(1)
    best, least = poses.guess, np.inf
    for trial in range(1 + _RESTARTS):
        shift = poses.unit * unknown * free * random.standard_normal(len(free))
        q, _ = poses.closed_near(poses.guess + (shift if trial else 0.0), free, kept)
        open_by = float(np.abs(poses.residual(q) * kept).max(initial=0.0))
        if open_by < least:
            best, least = q, open_by
        if poses.holds(q, kept) or not np.any(unknown * free):
            break
    return best


def _why_open(lowered: Lowered, poses: Poses, q: FloatArray) -> str:
    """The sentence about joints that do not close: start values, drivers, or dimensions."""
    description = lowered.description
    where = f"scene '{description.scene}'"
    gaps = _gaps(lowered, poses.residual(q))
    everything = np.ones(len(q))
    fixed = [
        (name, value)
        for name, value, role in description.start
        if role == "fixed" and name in {row[0] for row in description.coordinates}
    ]
    if fixed and poses.holds(_closed(poses, everything)):
        said = ", ".join(f"{name} = {value:g}" for name, value in fixed)
        return (
            f"{where}: the start values contradict the joints. start= says {said}; with these "
            f"{gaps}. Move one of them to guess=, correct its value, or check the points and "
            "dimensions of these joints: `linkwright draw` shows the gaps."
        )
    if description.drivers:
        joints = np.array([float(c[0] not in description.drivers) for c in description.constraints])
        if poses.holds(_closed(poses, everything, joints), joints):
            return (
                f"{where}: the joints close, but not with what the drivers "
                f"({', '.join(description.drivers)}) demand at t = 0: {gaps}. The driver asks for "
                "a position out of reach; change its value at t = 0, or the dimensions."
            )
    return (
        f"{where}: the joints do not close at the start; the nearest position found leaves "
        f"gaps: {gaps}. Check the points and dimensions of these joints, or give guesses nearer to "
        "an assembled position; `linkwright draw` shows the gaps."
    )


def _gaps(lowered: Lowered, residual: FloatArray) -> str:
    """`joint C misses by 0.31`, the worst first."""
    description = lowered.description
    largest: dict[str, float] = {}
    for (element, _, _), value in zip(description.constraints, residual, strict=True):
        largest[element] = max(largest.get(element, 0.0), abs(float(value)))
    worst = sorted(largest.items(), key=lambda pair: -pair[1])[:_SHOWN]
    return ", ".join(
        f"{'driver' if name in description.drivers else 'joint'} {name} misses by {miss:.4g}"
        for name, miss in worst
        if miss > 1e-3 * worst[0][1] or not np.isfinite(miss)
    )
