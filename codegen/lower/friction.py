"""Friction from reactions: the accelerations and multipliers that agree with their own friction.

Without friction the solution is x₀; a unit force of friction i adds x_i. With the force
f_i = -g_i Σ N over the contacts of i, the load of a contact is a linear function of the solution,

    N = |c + d N|,   c = load(x₀) - Σ g_j N' load(x_j),   d = -g_i load(x_i),

where N' runs over all other contacts. Each of these equations has the closed solution

    N = (cᵀd + √((cᵀd)² + (1 - dᵀd) cᵀc)) / (1 - dᵀd)

while dᵀd < 1; at 1 the joint jams. A single contact is solved by that. Several are solved in turn,
a fixed number of times, so that the kernel stays one smooth straight line.
"""

from codegen.lower.scene_graph import SceneGraph

SWEEPS = 8
"""Each sweep multiplies the error by the product of two couplings, a few parts in a hundred."""


def with_friction(scene: SceneGraph, solutions: list[list[int]]) -> list[int]:
    """The solution with its friction, from the one without and those of unit forces."""
    graph, n = scene.graph, scene.n
    base, *units = solutions
    if not scene.frictions:
        return base
    contacts = [
        (i, [scene.along(entry, base[n:]) for entry in load],
         [[scene.along(entry, unit[n:]) for entry in load] for unit in units])
        for i, friction in enumerate(scene.frictions)
        for load in friction.loads
    ]  # fmt: skip
    grips = [graph.neg(friction.grip) for friction in scene.frictions]
    sizes = [scene.size(free) for _, free, _ in contacts]
    for _ in range(SWEEPS if len(contacts) > 1 else 1):
        for k, (i, free, reach) in enumerate(contacts):
            pressed = list(free)
            for other, (j, *_) in enumerate(contacts):
                if other != k:
                    push = graph.mul(grips[j], sizes[other])
                    pressed = [
                        graph.add(c, graph.mul(push, share))
                        for c, share in zip(pressed, reach[j], strict=True)
                    ]
            sizes[k] = _agreeing(scene, pressed, [graph.mul(grips[i], d) for d in reach[i]])
    result = list(base)
    for i, unit in enumerate(units):
        total = graph.total([s for s, (of, *_) in zip(sizes, contacts, strict=True) if of == i])
        force = graph.mul(grips[i], total)
        result = [graph.add(x, graph.mul(force, y)) for x, y in zip(result, unit, strict=True)]
    return result


def _agreeing(scene: SceneGraph, c: list[int], d: list[int]) -> int:
    """N = |c + d N|."""
    graph = scene.graph
    both = graph.total([graph.mul(x, y) for x, y in zip(c, d, strict=True)])
    rest = graph.sub(graph.one, graph.total([graph.mul(y, y) for y in d]))
    square = graph.total([graph.mul(x, x) for x in c])
    root = graph.add(graph.mul(both, both), graph.mul(rest, square))
    return graph.div(graph.add(both, graph.power(root, 0.5)), rest)
