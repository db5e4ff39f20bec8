"""The choice of what a joint with redundant rows leaves in the linear systems, before the build.

The rest of a joint's rows of Φ_q, without their part in the span of other joints' rows, is what the
joint adds. Rows or combinations that stand for it (`codegen.lower.kernels.independent_rows`) are
compared with it at the start and at positions along the motion: the smallest singular value of the
product of orthonormal weights with an orthonormal basis of the rest is 1 where they span it, and 0
where one of them says nothing. Those are taken whose smallest value of all positions is largest;
in the plane columns with few entries come first, unless others say far more.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.lower.kernels.independent_rows import SharedRows, weighing_columns
from codegen.lower.linear.elimination_order import Row
from codegen.lower.lowered_scene import Lowered
from codegen.lower.poses_near_start import WALK, Poses, rest_of_rows
from codegen.lower.scene_graph import SceneGraph

Array = npt.NDArray[np.float64]
_SINGULAR = 1e-6  # accuracy: a rest of rows of length 1 without direction, as where bars align
_ALIKE = 1e-3  # accuracy: smallest values that differ by less are equal, and the first are taken
_DENSER = 2.0  # measured: ratio of smallest values, from which on columns with more entries pay
_FIXED = 0.999  # accuracy: smallest value of plain rows that hold in every position
_MOST = 3000  # safety: choices that are compared
_AROUND = 60  # measured: positions on each side of the start in space, a turn of all bodies
_TURNING = 0.1  # safety: of columns, from which on they are not mixed with plain rows


def shared_rows(lowered: Lowered, dependent: Sequence[int]) -> tuple[SharedRows, ...]:
    """What the joints of dependent rows leave beside other joints, in the order of the joints.

    Where the motion passes a position in which the others lose a direction that these joints hold,
    as a third crank does where two others lie in one line, the rows of all loops are combined.
    """
    scene, poses = lowered.scene, Poses(lowered)
    owners = dict.fromkeys(scene.owners[i] for i in dependent)
    own = {i for i, _ in scene.massless}  # such a row determines a coordinate of its joint
    joints = [
        tuple(i for i, name in enumerate(scene.owners) if name == owner and i not in own)
        for owner in owners
    ]
    driven = {i for i, name in enumerate(scene.owners) if name in lowered.description.drivers}
    undriven = np.array([float(i not in driven) for i in range(scene.m)])
    most = _AROUND if scene.turns else WALK
    places = poses.along_motion(undriven, most) or [poses.guess]
    columns = weighing_columns(scene, {i for rows in joints for i in rows})
    found = _chosen(scene, poses, places, joints, dependent)
    if not poses.is_sparse and _loses_direction(scene, poses, places, found, driven):
        loops = tuple(sorted({*columns} - own - driven - scene.norms.keys()))
        together = _chosen(scene, poses, places, [loops], dependent)
        if not _loses_direction(scene, poses, places, together, driven):
            return together
    return found


def _chosen(
    scene: SceneGraph, poses: Poses, places: Sequence[Array], joints: Sequence[tuple[int, ...]],
    dependent: Sequence[int],
) -> tuple[SharedRows, ...]:  # fmt: skip
    """The best rows and columns for each of `joints`, by positions, (n,) each."""
    redundant = [tuple(i for i in rows if i in dependent) for rows in joints]
    ranks = [len(rows) - len(of) for rows, of in zip(joints, redundant, strict=True)]
    columns = weighing_columns(scene, {i for rows in joints for i in rows})
    candidates = [_coordinates(columns, rows) for rows in joints]
    entries = [
        columns[i].get(k, scene.graph.zero)
        for rows, ks in zip(joints, candidates, strict=True) for k in ks for i in rows
    ]  # fmt: skip
    ends = np.cumsum([len(rows) * len(ks) for rows, ks in zip(joints, candidates, strict=True)])
    seen: list[list[tuple[Array, Array]]] = [[] for _ in joints]  # a joint → (rest, weights)
    for q in places:
        rests = _rests(poses.scaled(poses.jacobian(q), poses.unit), joints, ranks)
        weights = np.split(poses.values(scene.graph, entries, q), ends[:-1])
        for at, flat, (rest, lengths) in zip(seen, weights, rests, strict=True):
            if rest.size and np.isfinite(flat).all():
                values = flat.reshape(-1, len(lengths)) * lengths
                at.append((rest, np.vstack([np.eye(len(lengths)), values])))
    in_plane = not scene.turns  # columns of Euler parameters vanish in some poses
    found = zip(joints, redundant, candidates, seen, strict=True)
    return tuple(_best(*joint, in_plane) for joint in found)


def _loses_direction(
    scene: SceneGraph, poses: Poses, places: Sequence[Array], shared: Sequence[SharedRows],
    driven: set[int],
) -> bool:  # fmt: skip
    """Whether the rows of a machine with one freedom become dependent between two positions.

    The determinant of the rows and the direction of the motion changes its sign there.
    """
    held = {i for joint in shared for i in joint.rows}
    plain = [i for i in range(scene.m) if i not in held | driven]
    plain += [i for joint in shared for i in joint.kept]
    columns, zero = weighing_columns(scene, held), scene.graph.zero
    pairs = [(joint, k) for joint in shared for k in joint.columns]
    entries = [columns[i].get(k, zero) for joint, k in pairs for i in joint.rows]
    ends = np.cumsum([len(joint.rows) for joint, _ in pairs])
    known: list[tuple[Array, Array]] = []  # (position, direction), all in one sense
    signs = set[float]()
    for q in places:
        jacobian = poses.scaled(poses.jacobian(q), poses.unit)
        weights = np.split(poses.values(scene.graph, entries, q), ends[:-1])
        sums = [w @ jacobian[[*joint.rows]] for w, (joint, _) in zip(weights, pairs, strict=False)]
        rows = np.array([*jacobian[plain], *sums])
        if len(rows) + 1 != len(q) or not np.isfinite(rows).all():
            return False
        others = [i for i in range(scene.m) if i not in driven]
        direction = np.linalg.svd(jacobian[others])[2][-1]
        near = min(
            known, key=lambda one: float(np.abs((one[0] - q) / poses.unit).max()), default=None
        )
        if near is not None and direction @ near[1] < 0.0:
            direction = -direction
        known.append((q, direction))
        signs.add(float(np.linalg.slogdet(np.vstack([rows, direction]))[0]))
    return len(signs) > 1


def _coordinates(columns: Mapping[int, Row], rows: Sequence[int]) -> list[int]:
    """Coordinates with a column in the rows, first those that the fewest other rows contain."""
    users = Counter(k for row in columns.values() for k in row)
    return sorted({k for i in rows for k in columns[i]}, key=lambda k: (users[k], k))


def _rests(
    jacobian: Any, joints: Sequence[Sequence[int]], ranks: Sequence[int]
) -> list[tuple[Array, Array]]:
    """Of each joint a basis of what it adds, (g, rank), empty where it adds less; row lengths."""
    held = [i for rows in joints for i in rows]
    others = np.setdiff1d(np.arange(jacobian.shape[0]), held)
    shared = jacobian[held] if isinstance(jacobian, np.ndarray) else jacobian[held].toarray()
    lengths = np.maximum(np.linalg.norm(shared, axis=1), 1e-300)  # safety: a row of zeros
    rest = rest_of_rows(jacobian[others], shared / lengths[:, None])
    basis, found, first = np.zeros((0, shared.shape[1])), [], 0
    for rows, rank in zip(joints, ranks, strict=True):
        at = slice(first, first := first + len(rows))
        left, sizes, right = np.linalg.svd(rest[at] - rest[at] @ basis.T @ basis)
        basis = np.vstack([basis, right[:rank]])
        adds = sizes[:rank].min(initial=1.0) > _SINGULAR
        found.append((left[:, :rank] if adds else np.zeros((0, rank)), lengths[at]))
    return found


def _best(
    rows: tuple[int, ...], redundant: tuple[int, ...], coordinates: Sequence[int],
    seen: list[tuple[Array, Array]], in_plane: bool,
) -> SharedRows:  # fmt: skip
    """The rows and columns that stand for what a joint adds.

    Rows that no dependency contains stand for themselves. For others plain rows do where its
    direction is theirs, else columns, which turn with it also where no position was looked at.
    """
    size, rank = len(rows), len(rows) - len(redundant)
    best, least = tuple(range(rank)), -1.0
    if seen:
        rests, weights = (np.array(of) for of in zip(*seen, strict=True))
        weights /= np.maximum(np.linalg.norm(weights, axis=2).max(axis=0), 1e-300)[:, None]
        total, terms = weights.shape[1], np.count_nonzero(weights.any(axis=0), axis=1)
        terms *= in_plane and len(seen) > 1  # of one position entries may vanish by chance
        left_out = (1.0 - (rests**2).sum(axis=2)).max(axis=0)  # of each row, by a dependency
        alone = [*np.flatnonzero(left_out < _SINGULAR)]
        stages = ((range(size), _FIXED), (range(size, total), _TURNING), (range(total), 0.0))
        for stage, enough in stages:
            among, more = [s for s in stage if s not in alone], rank - len(alone)
            if math.comb(len(among), more) > _MOST:
                continue
            most, every = math.inf, combinations(among, more)
            choices = [tuple(sorted((*alone, *one))) for one in every]
            sizes = {one: int(terms[[*one]].sum()) for one in choices}
            for chosen in sorted(sizes, key=sizes.__getitem__):
                worst = np.linalg.svd(weights[:, chosen] @ rests, compute_uv=False).min(initial=1.0)
                pays = _DENSER if least >= _TURNING and sizes[chosen] > most else 1.0
                if worst > pays * least + _ALIKE:
                    best, least, most = chosen, worst, sizes[chosen]
            if least >= enough:
                break
    kept = tuple(rows[s] for s in best if s < len(rows))
    columns = tuple(coordinates[s - len(rows)] for s in best if s >= len(rows))
    return SharedRows(rows, redundant, kept, columns)
