"""Narrow functions of the position → rows of operations, which a run evaluates in intervals."""

from collections.abc import Sequence
from functools import reduce

import sympy

from codegen.declare.symbols import Parameter, t
from codegen.derive.equations import Equations
from codegen.lower.graph import Graph
from codegen.lower.program import Op, dependencies
from codegen.lower.sympy_translation import Translator
from codegen.lower.time_programs import Row, row_of

PositionProgram = tuple[tuple[int, ...], tuple[Row, ...]]  # numbers of the rows to watch, and rows

_WATCHED = frozenset({Op.EXP, Op.TANH, Op.ATAN, Op.LOG, Op.POW, Op.DIV})


def position_program(equations: Equations) -> PositionProgram | tuple[()]:
    """All narrow functions of the position as one program, or () without any."""
    functions = equations.position_functions
    if not functions:
        return ()
    graph = Graph()
    environment: dict[sympy.Expr, int] = {t: graph.input("t", 0, "t")}
    for k, p in enumerate(equations.parameters):
        frozen = equations.scene.frozen
        number = graph.constant(p.value) if frozen else graph.input("p", k, p.name)
        environment[Parameter(p.name, real=True)] = number
    for k, q in enumerate(equations.coordinates):
        environment[q] = graph.input("q", k, q.name)
    translated = Translator(graph, environment, ())
    roots = [translated(function) for function in functions]
    needed = sorted(dependencies(graph.values, [reduce(graph.add, roots)]))
    watched = [k for k in needed if k in roots or _may_bend(graph, k)]
    places = {number: place for place, number in enumerate(needed)}
    rows = tuple(row_of(graph, k, places) for k in needed)
    return tuple(places[k] for k in watched), rows


def _may_bend(graph: Graph, number: int) -> bool:
    value = graph.values[number]
    moving: Sequence[bool] = [not graph.settled[a] for a in value.args]
    return value.op in _WATCHED and moving[-1 if value.op is Op.DIV else 0]
