"""Which coordinates are kept, and what stands for each of the others and its rates.

What constraints give outright is put in (`outright`), and the loops that close in closed form are
closed (`loops`). With q = q(u, t) of the coordinates u that are left, q̇ = T u̇ + ν and
q̈ = T ü + γ, found by the same eliminations.
"""

from collections.abc import Iterable

from codegen.lower.program import Op
from codegen.lower.substitution import reached, rebuilt
from codegen.reduce.closed_form_loops import Angle, Loop, Loops
from codegen.reduce.explicit_coordinates import Outright, Rates, combined
from codegen.reduce.lowered_equations import Stated

REPEATED = ("switching", "switching_rates", "gap_accelerations", "holds", "restitution")
"""Kernels whose equations are those of the machine itself, in other coordinates."""


class Places:
    """The coordinates of a scene by those that are kept.

    Attributes
    ----------
    kept, closures
        Columns of the coordinates that are left, and rows of the constraints between them.
    loops
        Those closed in closed form.
    replaced
        Value of the scene → what stands in its place.
    slopes, bends
        Column → T by the columns that are kept, and γ.
    """

    def __init__(self, scene: Stated) -> None:
        self.scene, self.graph = scene, scene.graph
        self.outright = self._outright()
        self.formulas = self.outright.formulas()
        self.loops = self._closed()
        closed = {k for loop in self.loops for k in loop.columns}
        solved = {i for loop in self.loops for i in loop.rows}
        self.kept = tuple(k for k in self.outright.coordinates if k not in closed)
        self.closures = tuple(i for i in self.outright.rows if i not in solved)
        self.slots = {k: slot for slot, k in enumerate(self.kept)}
        self.replaced: dict[int, int] = {}
        self.slopes: dict[int, dict[int, int]] = {}
        self.bends: dict[int, int] = {}
        self._place()
        self._rate()

    @property
    def angles(self) -> list[Angle]:
        """The angles in closed form."""
        return [angle for loop in self.loops for angle in loop.angles]

    def put_in(self, values: Iterable[int]) -> list[int]:
        """Values of the scene in the coordinates that are kept."""
        return rebuilt(self.graph, list(values), self.replaced)

    # -- which -------------------------------------------------------------------------------

    def _outright(self) -> Outright:
        scene = self.scene
        weightless = {k for k in range(len(scene.q)) if scene.mass[k, k] == self.graph.zero}
        return Outright(
            self.graph,
            scene.q,
            scene.phi,
            scene.entries,
            scene.nu,
            scene.gamma,
            frozenset(started(scene)),
            frozenset(weightless),
        )

    def _closed(self) -> list[Loop]:
        """The loops in closed form, of angles of which nothing else asks how often they turned."""
        left, rows = self.outright.coordinates, self.outright.rows
        first = started(self.scene)
        independent = [*(k for k in first if k in left), *(k for k in left if k not in first)]
        independent = independent[: max(len(left) - len(rows), 0)]
        values = self._asked()
        angles = [k for k in left if k not in independent and self._turns(k, values)]
        while True:
            found = Loops(
                self.graph,
                self.scene.q,
                {i: row.value for i, row in rows.items()},
                list(angles),
                len(self.scene.told.parameters),
            ).found
            wound = [
                k
                for loop in found
                for k in loop.columns
                if not self._turns(k, [r.value for i, r in rows.items() if i not in loop.rows])
            ]
            if not wound:
                return found
            angles = [k for k in angles if k not in wound]

    def _asked(self) -> list[int]:
        """All that the equations of motion and the events are made of, with what is given put in.

        Constraints are not among them: those that close a loop are solved for its angles.
        """
        scene, outright = self.scene, self.outright
        values = [*scene.forces]
        for name in (*REPEATED, "accelerations"):
            if name in scene.kernels and (name != "accelerations" or scene.rubbing):
                values += [out.value for out in scene.kernels[name].outputs]
        for row in outright.rows.values():
            values += [row.nu, row.gamma, *row.entries.values()]
        for rates in outright.rates().values():
            values += [rates.velocity, rates.acceleration, *rates.slopes.values()]
        given = {scene.q[k]: formula for k, formula in self.formulas.items()}
        return rebuilt(self.graph, values, given)

    def _turns(self, k: int, values: list[int]) -> bool:
        """Whether a coordinate is an angle of which the values take the sine and cosine alone."""
        if self.scene.told.coordinates[k][2] != "rad":
            return False
        ends = {self.graph.function(op, self.scene.q[k]): None for op in (Op.SIN, Op.COS)}
        return self.scene.q[k] not in reached(self.graph, values, ends)

    # -- where -------------------------------------------------------------------------------

    def _place(self) -> None:
        """What stands for every coordinate."""
        graph, scene, replaced = self.graph, self.scene, self.replaced
        for k, slot in self.slots.items():
            replaced[scene.q[k]] = graph.input("q", slot, scene.name(scene.q[k]))
            replaced[scene.v[k]] = graph.input("v", slot, scene.name(scene.v[k]))
        for angle in self.angles:
            s, c = rebuilt(graph, [angle.s, angle.c], replaced)
            replaced[graph.function(Op.SIN, scene.q[angle.column])] = s
            replaced[graph.function(Op.COS, scene.q[angle.column])] = c
            replaced[scene.q[angle.column]] = graph.function(Op.ATAN2, s, c)
        places = self.put_in(self.formulas.values())
        # A given angle that is one of the closed ones but for a constant keeps its sine and cosine.
        for k, formula in self.formulas.items():
            for op in (Op.SIN, Op.COS):
                end = graph.function(op, scene.q[k])
                (of_formula,) = rebuilt(graph, [end], {scene.q[k]: formula})
                (replaced[end],) = self.put_in([of_formula])
        replaced |= {scene.q[k]: place for k, place in zip(self.formulas, places, strict=True)}

    # -- how fast ----------------------------------------------------------------------------

    def _rate(self) -> None:
        """Every coordinate's rates by those that are kept."""
        graph, scene = self.graph, self.scene
        known = {k: Rates({k: graph.one}, graph.zero, graph.zero) for k in self.kept}
        for loop in self.loops:
            known |= self._of_loop(loop, known)
        rates = {
            k: combined(graph, one, known)
            for k, one in self.outright.rates().items()
            if k not in known
        }
        rates |= known
        # Velocities first, as γ is made of them.
        velocities: dict[int, int] = {}
        for k, one in rates.items():
            slopes = self.put_in(one.slopes.values())
            self.slopes[k] = dict(zip(one.slopes, slopes, strict=True))
            terms = [
                graph.mul(slope, self.replaced[scene.v[j]]) for j, slope in self.slopes[k].items()
            ]
            velocities[k] = graph.total([*terms, *self.put_in([one.velocity])])
        self.replaced |= {scene.v[k]: velocities[k] for k in rates}
        bends = self.put_in(rates[k].acceleration for k in rates)
        self.bends = dict(zip(rates, bends, strict=True))

    def _of_loop(self, loop: Loop, known: dict[int, Rates]) -> dict[int, Rates]:
        """Rates of a loop's angles: its rows solved for them."""
        graph = self.graph
        columns = loop.columns
        matrix, right = [], []
        for i in loop.rows:
            row = self.outright.rows[i]
            matrix.append([row.entries.get(k, graph.zero) for k in columns])
            others = {j: graph.neg(e) for j, e in row.entries.items() if j not in columns}
            right.append(combined(graph, Rates(others, row.nu, row.gamma), known))
        if len(columns) == 1:
            inverse = [[graph.div(graph.one, matrix[0][0])]]
        else:
            (a, b), (c, d) = matrix
            over = graph.div(graph.one, graph.sub(graph.mul(a, d), graph.mul(b, c)))
            inverse = [
                [graph.mul(over, d), graph.neg(graph.mul(over, b))],
                [graph.neg(graph.mul(over, c)), graph.mul(over, a)],
            ]
        places = dict(enumerate(right))
        return {
            k: combined(graph, Rates(dict(enumerate(line)), graph.zero, graph.zero), places)
            for k, line in zip(columns, inverse, strict=True)
        }


def started(scene: Stated) -> list[int]:
    """Columns of the coordinates whose start is fixed: first those whose velocity is."""
    told = scene.told
    fixed = {name for name, _, role in told.start if role == "fixed"}
    rates = [k for k, (_, rate, _) in enumerate(told.coordinates) if rate in fixed]
    places = [k for k, (name, *_) in enumerate(told.coordinates) if name in fixed]
    return [*rates, *(k for k in places if k not in rates)]
