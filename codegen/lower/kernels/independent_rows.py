"""The constraints of a scene as independent rows, where some of them follow from others.

Of a joint with g rows, of which ρ follow from other joints, the linear systems contain g - ρ rows:
a row as it is, or a combination cᵀΦ with the weights c = ∂Φ/∂q_k, the column of a coordinate after
the coordinates that one constraint determines are substituted. The column of a crank's angle turns
with the crank, as the direction does in which its pin is not held by other joints; a fixed choice
of rows becomes singular twice a turn. The multipliers of the joint are c μ, with μ that of the
combination: one of the valid choices, in which redundant rows of themselves bear nothing.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from typing import NamedTuple

from codegen.lower.kernels.accelerations import elimination
from codegen.lower.linear.elimination_order import Row
from codegen.lower.linear.factorization import Entries, Strategy
from codegen.lower.linear.sparse_row_elimination import SparseRows, Task
from codegen.lower.program import Kernel, Labels, Output
from codegen.lower.scene_graph import SceneGraph


class SharedRows(NamedTuple):
    """The rows of a joint, of which some follow from others, and what they are left as.

    Or those of all loops, where no joint alone is redundant in every position.
    """

    rows: tuple[int, ...]
    redundant: tuple[int, ...]  # those that are named as such; what is left are as many fewer
    kept: tuple[int, ...]  # the rows that stay
    columns: tuple[int, ...]  # coordinates whose columns are the weights of combinations


_LARGEST = 400  # safety: stores of a kernel; more free multipliers are found in a run


class _Substitution(SparseRows):
    """Explicit coordinates substituted by rows that are not `held`."""

    def __init__(self, scene: SceneGraph, held: set[int]) -> None:
        graph = scene.graph
        super().__init__(Task(graph, scene.jacobian, [[graph.zero] * scene.m]))
        self._changed -= held
        while pivot := self._explicit_coordinate():
            i, k = pivot
            row = self._remove(i)
            inverse = graph.div(graph.one, row.pop(k))
            self._eliminate(k, {j: graph.mul(inverse, x) for j, x in row.items()}, [graph.zero])
            self._changed -= held
        self.left: Mapping[int, Row] = self._rows


def weighing_columns(scene: SceneGraph, held: set[int]) -> Mapping[int, Row]:
    """Row → coordinate → value, of what is left: the rows `held`, and others of no use for it."""
    return _Substitution(scene, held).left


def with_independent_rows(scene: SceneGraph, shared: Sequence[SharedRows]) -> SceneGraph:
    """The scene with the rows of these joints replaced by what they are left as."""
    if not shared:
        return scene
    graph, found = scene.graph, copy(scene)
    held = {i for joint in shared for i in joint.rows}
    weights = {i: row for i, row in enumerate(scene.weights) if i not in held}
    with graph.serving("factorization"):
        columns = weighing_columns(scene, held)
        for joint in shared:
            left = [scene.weights[i] for i in joint.kept]
            for k in joint.columns:
                entries = {j: columns[j].get(k, graph.zero) for j in joint.rows}
                left.append({j: entry for j, entry in entries.items() if entry != graph.zero})
            weights |= zip((i for i in joint.rows if i not in joint.redundant), left, strict=True)
        found.stated = sorted(weights)
        places = {stated: row for row, stated in enumerate(found.stated)}
        found.weights = [weights[i] for i in places]
        found.m = len(places)
        found.rows, found.owners = ([of[i] for i in places] for of in (scene.rows, scene.owners))
        found.phi, found.nu, found.gamma, found.turned_gamma = (
            [graph.dot(row.values(), [of[i] for i in row]) for row in found.weights]
            for of in (scene.phi, scene.nu, scene.gamma, scene.turned_gamma)
        )
        found.jacobian, found.turned_jacobian = (
            _combined(scene, found.weights, of) for of in (scene.jacobian, scene.turned_jacobian)
        )
    found.massless = [(places[i], k) for i, k in scene.massless]
    found.norms = {places[i]: turn for i, turn in scene.norms.items()}
    return found


def _combined(scene: SceneGraph, weights: list[Row], jacobian: Entries) -> Entries:
    """The slopes of the rows with these weights, from those of the constraints as stated."""
    graph, stated, found = scene.graph, dict[int, Row](), Entries()
    for (i, k), entry in jacobian.items():
        stated.setdefault(i, {})[k] = entry
    for row, factors in enumerate(weights):
        for k in sorted({k for i in factors for k in stated.get(i, ())}):
            pairs = [
                (factor, stated[i][k]) for i, factor in factors.items() if k in stated.get(i, ())
            ]
            found[row, k] = graph.dot(*zip(*pairs, strict=True))
    return found


def free_multipliers(
    scene: SceneGraph, jacobian: Entries, shared: Sequence[SharedRows], strategy: Strategy
) -> tuple[Kernel, int] | None:
    """The kernel of multipliers that exert no force, and how many; None of a large machine.

    And of one in space, whose columns are those of motion. What a joint leaves out is a sum d of
    its rows in `jacobian`, Φ_q as stated, that the others imply: their multipliers balance the
    forces -dᵀ, and nothing moves.
    """
    graph, n, m = scene.graph, scene.n, len(scene.row_names)
    left_out = [row for joint in shared for row in _left_out(scene, joint)]
    if scene.turns or len(left_out) * m > _LARGEST:
        return None
    right = []
    for row in left_out:
        force = [graph.zero] * (n + scene.m)
        for (i, k), entry in jacobian.items():
            if i in row:
                force[k] = graph.sub(force[k], graph.mul(row[i], entry))
        right.append(force)
    columns = elimination(scene, Labels(), right=right).solve(strategy)
    outputs = []
    for number, (row, column) in enumerate(zip(left_out, columns, strict=True)):
        found = scene.multipliers(column[n:])
        for i, factor in row.items():
            found[i] = graph.add(found[i], factor)
        outputs += [
            Output("out", number * m + i, value, scene.row_names[i])
            for i, value in enumerate(found) if value != graph.zero
        ]  # fmt: skip
    summary = "Multipliers that exert no force: Φ_qᵀ λ = 0; entries that are 0 are not written."
    return Kernel("free_multipliers", summary, ("t", "q", "p", "out"), tuple(outputs)), len(right)


def _left_out(scene: SceneGraph, joint: SharedRows) -> list[Row]:
    """Sums of a joint's rows, as many as are redundant or more, that are not among the rows."""
    graph = scene.graph
    if not joint.columns:
        return [{i: graph.one} for i in joint.rows if i not in joint.kept]
    if len(joint.rows) > 2:
        return [{i: graph.one} for i in joint.rows]
    (place,) = (row for row, i in enumerate(scene.stated) if i in joint.rows)
    first, second = (scene.weights[place].get(i, graph.zero) for i in joint.rows)
    return [dict(zip(joint.rows, (graph.neg(second), first), strict=True))]
