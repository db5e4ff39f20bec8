"""The tables of a generated module: plain values, for the runtime and for readers.

Explicit functions of time → rows of operations, which a run evaluates in intervals.

A polynomial, or a polynomial in sines of a t + b, hides nothing between two steps, and is left out;
so are the pieces of effects, whose conditions are switching functions of the run.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import sympy

from codegen.declare.symbols import SPEED, Parameter, dotted, t
from codegen.derive.equations import Equations
from codegen.derive.piecewise_conditions import as_pieces
from codegen.derive.switching_functions import Switch
from codegen.derive.watched_functions import PeakedFunction, table_ranges, time_functions
from codegen.lower.graph import Graph
from codegen.lower.program import LOGICAL, Input, Lookup, Op, dependencies
from codegen.lower.scene_graph import Reaction, SceneGraph
from codegen.lower.sympy_translation import Translator

Row = tuple[Any, ...]  # (operation, numbers of the rows that it takes ..., literal): see `_row`
# (element, role, numbers of the rows that may bend sharply, rows; the last row is f). Of a place
# there follow the rows of each scalar that it is in and those of the force along this.
TimeProgram = tuple[Any, ...]
# (element, table, what it is taken at, its first and last point, rows of operations)
RangeProgram = tuple[str, str, str, float, float, tuple[Row, ...]]

_SUMS = frozenset({Op.ADD, Op.SUB, Op.NEG})
_SMOOTH = frozenset({Op.CONST, Op.INPUT, Op.MUL, Op.SELECT, Op.FLOOR, *_SUMS, *LOGICAL})


def time_programs(equations: Equations) -> tuple[TimeProgram, ...]:
    """The explicit functions of time that a run must look at."""
    programs: dict[TimeProgram, None] = {}
    for function in time_functions(equations):
        lowered = partial(_lowered, equations, function.element)
        graph, root = lowered(function.expression, ())
        needed = sorted(dependencies(graph.values, [root]))
        watched = _watched(graph, needed)
        stepping = {Op.FLOOR} if function.role == "effect" else {Op.FLOOR, Op.LESS}
        if watched or any(graph.values[k].op in stepping for k in needed):
            named = function.element, function.role, tuple(map(needed.index, watched))
            along = (_rows(*lowered(e, None)) for pair in function.along for e in pair)
            programs[(*named, _rows(graph, root), *along)] = None
    return tuple(programs)


def range_programs(equations: Equations) -> tuple[RangeProgram, ...]:
    """The tables that a motion may leave, and the operations of what they are taken at."""
    programs = []
    for element, table, at, low, high in table_ranges(equations):
        rows = _rows(*_lowered(equations, element, at, None))
        programs.append((element, table, str(at), low, high, rows))
    return tuple(programs)


def _lowered(
    equations: Equations, element: str, expression: sympy.Expr, switches: tuple[()] | None
) -> tuple[Graph, int]:
    """A graph of an expression's own and its value there; with None it may compare coordinates."""
    graph, parameters = Graph(), equations.parameters
    environment: dict[sympy.Expr, int] = {t: graph.input("t", 0, "t")}
    for k, p in enumerate(parameters):
        frozen = equations.scene.frozen
        number = graph.constant(p.value) if frozen else graph.input("p", k, p.name)
        environment[Parameter(p.name, real=True)] = number
    if switches is None:
        environment[SPEED] = graph.input("v", len(equations.coordinates), SPEED.name)
        for k, q in enumerate(equations.coordinates):
            environment[q] = graph.input("q", k, q.name)
            environment[q.rate] = graph.input("v", k, q.rate.name)
    with graph.serving(element):
        return graph, Translator(graph, environment, switches)(as_pieces(expression))


def _rows(graph: Graph, root: int) -> tuple[Row, ...]:
    """The operations that a value takes, which is the last of them."""
    needed = sorted(dependencies(graph.values, [root]))
    places = {number: place for place, number in enumerate(needed)}
    return tuple(_row(graph, k, places) for k in needed)


def _watched(graph: Graph, needed: list[int]) -> list[int]:
    """The values among `needed` that may bend sharply between two steps, not being smooth."""
    bent, watched = set[int](), []
    for k in needed:
        value = graph.values[k]
        moving = [a for a in value.args if not graph.settled[a]]
        bending = bent & set(moving)
        plain = value.op in (Op.SIN, Op.COS) and _degree(graph, value.args[0]) <= 1  # of a t + b
        if value.op not in _SMOOTH and moving and not plain:
            bent.add(k)
            watched.append(k)
        elif bending:
            bent.add(k)
            alone = value.op is Op.MUL and len(moving) == 2
            if alone or (value.op in _SUMS and len(bending) == 2):
                watched.append(k)
    return watched


def _degree(graph: Graph, number: int) -> int:
    """Degree of a polynomial in t; of all else, a large number."""
    value = graph.values[number]
    if graph.settled[number]:
        return 0
    if value.op is Op.INPUT:
        return 1
    if value.op in _SUMS:
        return max(_degree(graph, a) for a in value.args)
    return sum(_degree(graph, a) for a in value.args) if value.op is Op.MUL else 99


def _row(graph: Graph, number: int, places: dict[int, int]) -> Row:
    """An operation, the rows that it takes, and the literal of a constant, parameter or table."""
    value = graph.values[number]
    literal, args = value.literal, tuple(places[a] for a in value.args)
    if isinstance(literal, Input):
        return ("t",) if literal.array == "t" else (literal.array, literal.slot)
    if value.op is Op.CONST:
        return ("const", literal)
    if isinstance(literal, Lookup):
        return ("table", *args, literal)
    return (value.op.value, *args)


@dataclass(frozen=True)
class Pattern:
    """Where the structural non-zeros of a matrix stand."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]

    @classmethod
    def of(cls, entries: Mapping[tuple[int, int], int]) -> "Pattern":
        """The pattern of (row, column) → value."""
        return cls(tuple(i for i, _ in entries), tuple(k for _, k in entries))

    def tables(self, stem: str) -> dict[str, tuple[int, ...]]:
        """The two tables of a module."""
        return {f"{stem}_ROWS": self.rows, f"{stem}_COLUMNS": self.columns}


@dataclass(frozen=True)
class Description:
    """The tables of one scene."""

    model: str
    scene: str
    analysis: str
    bodies: tuple[str, ...]
    coordinates: tuple[tuple[str, str, str], ...]  # (name, name of the velocity, unit)
    constraints: tuple[tuple[str, str, str], ...]  # (element, kind, row), one an equation
    # (name, default, unit, sign rule) of those that a run may change, and, folded, of those that a
    # frozen scene holds as numbers
    parameters: tuple[tuple[str, float, str, str], ...]
    folded: tuple[tuple[str, float, str, str], ...]
    effects: tuple[tuple[str, str], ...]  # (name, kind)
    left_out: tuple[tuple[str, str], ...]  # (name, kind) of declared elements that do not act
    unused: tuple[str, ...]  # parameters on which nothing that takes part depends
    outputs: tuple[str, ...] | None  # in addition to the motion; None means all
    recovered: tuple[int, ...]  # constraints whose multipliers `accelerations` answers
    redundant: tuple[int, ...]  # constraints in whose places no independent row stands
    free: int | None  # number of vectors that `free_multipliers` writes, if there is this kernel
    drivers: tuple[str, ...]  # the drivers among the constraints
    switches: tuple[
        tuple[str, ...], ...
    ]  # (effect, condition[, kind]), kind "condition" by default
    rigid: tuple[tuple[str, int], ...]  # (effect, number of its switch) of each rigid contact
    # (effect, number of its switch) of each friction whose stiction force a run determines; these
    # forces stand in `p` behind the parameters
    stiction: tuple[tuple[str, int], ...]
    # the same of contacts and frictions whose share of both modes stands there, behind these
    shares: tuple[tuple[str, int], ...]
    reactions: tuple[tuple[str, str, str], ...]  # (element, component, unit) of each entry
    powers: tuple[tuple[str, str], ...]  # (source, "effect" or "driver") of each entry
    # (coordinate or velocity, value, role): "fixed", "guess", or before these "neutral", where the
    # neutral pose is not at zero
    start: tuple[tuple[str, float, str], ...]
    time_functions: tuple[TimeProgram, ...]  # those that a run looks at before its first step
    table_ranges: tuple[RangeProgram, ...]  # of the tables that a motion may leave
    # (element, kind, exponent) of each function of the position that may peak within a step; of a
    # kink the kind of place and the function besides
    peaks: tuple[tuple[Any, ...], ...]
    # (element, sentence, least, whether that is too small, largest, count of numbers) of what is
    # asked of parameters, and (curve, whether it is convex) of profiles that depend on them, with 1
    # of one that touches the next from outside, -1 from inside, and the joint that shows where
    conditions: tuple[tuple[Any, ...], ...]
    profiles: tuple[tuple[Any, ...], ...]
    # (name, column of its integral, unit, nominal size) of each state
    states: tuple[tuple[str, int, str, float], ...]
    sampled: tuple[str, ...]  # the states that a clock renews
    triggers: tuple[int, ...]  # of each of SAMPLED its condition in WATCHED, -1: a clock
    # (name, action, target, scene) of the conditions that a run watches
    watched: tuple[tuple[str, str, str, str], ...]
    # (joints, scene) of several joints that may come or go at one instant
    together: tuple[tuple[tuple[str, ...], str], ...]
    controllers: tuple[str, ...]  # those whose samples a run brings
    # effects whose values are sought: parameters, whose values a run gives as weights
    unknown: tuple[str, ...]
    turning: tuple[tuple[str, int], ...]  # (body in space, column of e0)
    # (joint, column of e0 of body i, vector, column of body j, vector) of vectors that bodies in
    # space share; the ground has the column -1
    facing: tuple[tuple[Any, ...], ...]
    jacobian: Pattern  # pattern of Φ_q
    independent_jacobian: Pattern | None  # of the independent rows, where some follow from others
    mass: Pattern  # pattern of M


def describe(
    scene: SceneGraph, independent: SceneGraph, powers: list[tuple[str, str, int]],
    reported: Sequence[Reaction], recovered: tuple[int, ...],
    peaks: tuple[PeakedFunction, ...] = (), free: int = 0,
) -> Description:  # fmt: skip
    """The tables of a scene, with its powers, reported reactions, recovered multipliers, peaks."""
    equations, named = scene.equations, scene.equations.scene
    coordinates, constraints = equations.coordinates, equations.constraints
    fixed = {s.name: s.start for s in equations.states} | dict(named.start)
    drawn = {q: q.measure.neutral for q in coordinates}
    for body in equations.turning:
        first = scene.columns[body.p[0]] - 3
        drawn |= zip(coordinates[first:], body.pose, strict=False)
    start = (
        *((dotted(q), value, "neutral") for q, value in drawn.items() if value),
        *((name, value, "fixed") for name, value in fixed.items()),
        *((name, value, "guess") for name, value in named.guess if name not in fixed),
    )
    triggers = tuple(s.watched for s in equations.sampled)
    parameters = tuple((p.name, p.value, p.unit, p.sign) for p in equations.parameters)
    return Description(
        model=equations.model,
        scene=named.name,
        analysis=named.analysis,
        bodies=equations.bodies,
        coordinates=tuple((dotted(q), dotted(q.rate), q.unit) for q in coordinates),
        constraints=tuple((c.name, c.kind, row) for c in constraints for row in c.statement.rows),
        parameters=() if named.frozen else parameters,
        folded=parameters if named.frozen else (),
        # what follows from a joint's reaction is friction in it, whatever its author calls it
        effects=tuple(
            (e.name, "friction" if e.terms.friction else e.kind)
            for e in equations.effects
            if e.terms.watched is None
        ),
        left_out=equations.left_out,
        unused=equations.unused,
        outputs=named.outputs,
        recovered=recovered,
        redundant=tuple(sorted({*range(scene.m)} - {*independent.stated})),
        free=free or None,
        drivers=tuple(c.name for c in constraints if c.driver),
        switches=tuple(
            (s.effect, s.text) if (word := _kind(s)) == "condition" else (s.effect, s.text, word)
            for s in equations.switches
        ),
        rigid=tuple((contact.effect, contact.switch) for contact in equations.contacts),
        stiction=equations.stiction,
        shares=equations.shares,
        reactions=tuple(row[:3] for row in reported),
        powers=tuple((source, kind) for source, kind, _ in powers),
        start=start,
        time_functions=time_programs(equations),
        table_ranges=range_programs(equations),
        peaks=tuple((*peak[:3], *peak.place) for peak in peaks),
        conditions=tuple(
            (*row[:6], *filter(None, row[6:]))
            for row in (one.condition.row(one.element) for one in equations.conditions)
        ),
        profiles=tuple((*one.row[:2], *filter(None, one.row[2:])) for one in equations.profiles),
        states=tuple(
            (s.name, scene.columns[s.integral], s.unit, s.nominal) for s in equations.states
        ),
        sampled=tuple(s.name for s in equations.sampled),
        triggers=triggers if any(k >= 0 for k in triggers) else (),
        watched=tuple((one.name, one.action, one.target, one.scene) for one in equations.watched),
        together=equations.together,
        controllers=tuple(s.name for s in equations.sampled if s.sample is None),
        unknown=named.unknown,
        turning=tuple((body.name, scene.columns[body.p[0]]) for body in equations.turning),
        facing=tuple(_facing(scene)),
        jacobian=Pattern.of(scene.jacobian),
        independent_jacobian=None
        if independent is scene
        else Pattern.of(
            {(independent.stated[i], k): entry for (i, k), entry in independent.jacobian.items()}
        ),
        mass=Pattern.of(scene.mass),
    )


def _facing(scene: SceneGraph) -> Iterator[tuple[Any, ...]]:
    """The vectors that bodies share, joint by joint, with the columns of e0 of the bodies."""
    for joint in scene.equations.constraints:
        for e0_i, of_i, e0_j, of_j in joint.facing:
            i, j = (scene.columns.get(e0, -1) for e0 in (e0_i, e0_j))
            yield joint.name, i, of_i, j, of_j


def _kind(switch: Switch) -> str:
    """The kind of a switch, and of a condition that is more than g > 0, what it is at g = 0."""
    return f"{switch.at_zero} {switch.kind}" if switch.at_zero else switch.kind
