"""The kernel `correction` of bodies in space: solved in turns, as accelerations are.

The equation pᵀp = 1 of a body goes first: p moves by h (1 - pᵀp)/2, h = W p / (pᵀ W p), the least
change that meets it to first order, and ṗ by -h pᵀṗ. There, where p has length 1 but for the square
of that change, the other constraints are evaluated; what they ask for leaves the length as it is,

    δp = V x,   V = 2 (W - W p hᵀ) Gᵀ,   x = Φ_π'ᵀ μ,   δπ' = 2 G δp = B x,   B = 2 G V.

So Newton's method converges quadratically in all of p, and w = 0 holds an Euler parameter: its row
of V vanishes. B, 3 x 3, is the body's part of W.
"""

from codegen.declare.rotation_entries import G
from codegen.lower.differentiation.turning import THREE, Turn, along_g
from codegen.lower.graph import substitute
from codegen.lower.kernels.motion_system import motion_system
from codegen.lower.linear.least_change import NormalEquations
from codegen.lower.linear.sparse_row_elimination import Task
from codegen.lower.program import Check
from codegen.lower.scene_graph import SceneGraph

Changes = list[list[int]]  # of q and of v


class _Body:
    """Of one body the Euler parameters of length 1, the spin with them, and the weights."""

    def __init__(self, scene: SceneGraph, turn: Turn, row: int) -> None:
        self.turn, graph, number, p = turn, scene.graph, scene.graph.constant, turn.p
        w = scene.w[turn.first : turn.first + 4]
        weighted = [graph.mul(a, b) for a, b in zip(w, p, strict=True)]
        size = graph.dot(p, weighted)
        self.check = Check(size, graph.total(w), row)
        inverse = graph.div(graph.one, size)
        h = [graph.mul(inverse, x) for x in weighted]
        lack = graph.mul(number(-0.5), scene.phi[row])
        self.shifts = [graph.mul(x, lack) for x in h]
        self.p = list(map(graph.add, p, self.shifts))
        double = [graph.mul(number(2.0), e) for e in self.p]
        slip = graph.dot(self.p, turn.rates)
        self.slips = [graph.neg(graph.mul(x, slip)) for x in h]
        rates = list(map(graph.add, turn.rates, self.slips))
        self.omega = [along_g(graph, k, double, rates) for k in THREE]
        along = [along_g(graph, k, double, h) for k in THREE]
        self.changes: Changes = []  # V
        for k, (weight, e) in enumerate(zip(w, p, strict=True)):
            row_of_g = [graph.mul(number(sign), double[j]) for sign, j in (g[k] for g in G)]
            left = [graph.sub(x, graph.mul(e, y)) for x, y in zip(row_of_g, along, strict=True)]
            self.changes.append([graph.mul(weight, x) for x in left])
        columns = list(zip(*self.changes, strict=True))
        self.block = [
            [along_g(graph, min(i, k), double, columns[max(i, k)]) for k in THREE] for i in THREE
        ]


def changes_by_turns(scene: SceneGraph) -> tuple[Changes, NormalEquations]:
    """The changes that meet the constraints, and their solver."""
    graph, system = scene.graph, motion_system(scene)
    columns = scene.turning.of_motion(scene.n)
    place = {column: k for k, column in enumerate(columns)}
    which = {turn: row for row, turn in scene.norms.items()}
    bodies = [_Body(scene, turn, which[k]) for k, turn in enumerate(scene.turns)]
    moved = {e: x for body in bodies for e, x in zip(body.turn.p, body.p, strict=True)}
    stated = [of[i] for of in (scene.phi, scene.nu) for i in system.rows]
    values = substitute(graph, [*stated, *system.jacobian.values()], moved)
    m = len(system.rows)
    jacobian = dict(zip(system.jacobian, values[2 * m :], strict=True))
    # unknown → its row of W, or of V; those of Euler parameters stand behind the columns
    changes = {place.get(k, system.n + k): {place.get(k, 0): w} for k, w in enumerate(scene.w)}
    blocks, speeds = {k: {k: scene.w[c]} for c, k in place.items() if c < scene.n}, system.speeds[:]
    first = [[graph.zero] * scene.n, [graph.zero] * scene.n]
    for body, (turn, at) in zip(bodies, scene.turning.turns, strict=True):
        axes = [place[at + k] for k in THREE]
        for axis, spin, row in zip(axes, body.omega, body.block, strict=True):
            speeds[axis], blocks[axis] = spin, dict(zip(axes, row, strict=True))
        for k, row in enumerate(body.changes, turn.first):
            changes[system.n + k] = dict(zip(axes, row, strict=True))
        for of, shifts in zip(first, (body.shifts, body.slips), strict=True):
            of[turn.first : turn.first + 4] = shifts
    rates = values[m : 2 * m]
    for (i, k), entry in jacobian.items():
        rates[i] = graph.sub(rates[i], graph.mul(entry, speeds[k]))
    right = [[graph.neg(phi) for phi in values[:m]], rates]
    weights = [blocks[k][k] for k in range(system.n)]
    names = [scene.rows[i] for i in system.rows]
    stems = ["rhs_q", "rhs_v"]
    task = Task(
        graph, jacobian, right, weights, system.names, names, stems, blocks=blocks, changes=changes
    )
    solver = NormalEquations(task)
    found = [list(map(graph.add, *of)) for of in zip(first, solver.solve(), strict=True)]
    checks = (c._replace(constraint=system.rows[c.constraint]) for c in solver.checks)
    solver.checks = [*(body.check for body in bodies), *checks]
    return found, solver
