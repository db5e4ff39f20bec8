"""Explicit functions of time → rows of operations, which a run evaluates in intervals.

A polynomial, or a polynomial in sines of a t + b, hides nothing between two steps, and is left out;
so are the pieces of effects, whose conditions are switching functions of the run.
"""

from functools import partial
from typing import Any

import sympy

from codegen.declare.symbols import SPEED, Parameter, t
from codegen.derive.equations import Equations
from codegen.derive.piecewise_conditions import as_pieces
from codegen.lower.graph import Graph
from codegen.lower.program import LOGICAL, Input, Lookup, Op, dependencies
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
    for function in equations.time_functions:
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
    for element, table, at, low, high in equations.table_ranges:
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
    """The values among `needed` that may bend sharply between two steps.

    Of sums and products it is enough to look at those of what is not smooth itself.
    """
    bent, watched = set[int](), []
    for k in needed:
        value = graph.values[k]
        moving = [a for a in value.args if not graph.settled[a]]
        bending = bent & set(moving)
        if value.op not in _SMOOTH and moving and not _is_plain_sine(graph, k):
            bent.add(k)
            watched.append(k)
        elif bending:
            bent.add(k)
            alone = value.op is Op.MUL and len(moving) == 2
            if alone or (value.op in _SUMS and len(bending) == 2):
                watched.append(k)
    return watched


def _is_plain_sine(graph: Graph, number: int) -> bool:
    """Whether a value is a sine or cosine of a t + b."""
    value = graph.values[number]
    return value.op in (Op.SIN, Op.COS) and _degree(graph, value.args[0]) <= 1


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
