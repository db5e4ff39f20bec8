"""Value numbering: what goes in, what comes out."""

import math
from collections.abc import Callable

import pytest

from codegen.lower.graph import Graph
from codegen.lower.program import Op

Build = Callable[..., int]


def shown(graph: Graph, number: int) -> str:
    """A value as text, fully bracketed."""
    value = graph.values[number]
    if value.op is Op.CONST:
        return f"{value.literal:g}"
    if value.op is Op.INPUT:
        return value.literal.name
    if value.op is Op.MODE:
        return f"mode{value.literal}"
    return f"{value.op.value}({' '.join(shown(graph, a) for a in value.args)})"


@pytest.mark.parametrize(
    ("build", "expected"),
    [
        (lambda g, x, y: g.add(x, y), "+(x y)"),
        (lambda g, x, y: g.add(y, x), "+(x y)"),
        (lambda g, x, y: g.add(x, g.zero), "x"),
        (lambda g, x, y: g.add(g.zero, x), "x"),
        (lambda g, x, y: g.add(g.constant(2), g.constant(3)), "5"),
        (lambda g, x, y: g.add(x, g.neg(y)), "-(x y)"),
        (lambda g, x, y: g.add(g.neg(x), y), "-(y x)"),
        (lambda g, x, y: g.add(x, g.constant(-2)), "-(x 2)"),
        (lambda g, x, y: g.sub(x, x), "0"),
        (lambda g, x, y: g.sub(x, g.zero), "x"),
        (lambda g, x, y: g.sub(g.zero, x), "neg(x)"),
        (lambda g, x, y: g.sub(x, g.neg(y)), "+(x y)"),
        (lambda g, x, y: g.sub(g.neg(x), y), "neg(+(x y))"),
        (lambda g, x, y: g.sub(x, g.constant(-2)), "+(x 2)"),
        (lambda g, x, y: g.sub(g.constant(-2), x), "neg(+(x 2))"),
        (lambda g, x, y: g.neg(g.neg(x)), "x"),
        (lambda g, x, y: g.neg(g.sub(x, y)), "neg(-(x y))"),
        (lambda g, x, y: g.mul(g.sub(x, y), g.sub(y, x)), "neg(*(-(x y) -(x y)))"),
        (lambda g, x, y: g.add(x, g.neg(g.sub(x, y))), "-(x -(x y))"),
        (lambda g, x, y: g.neg(g.constant(3)), "-3"),
        (lambda g, x, y: g.mul(x, g.zero), "0"),
        (lambda g, x, y: g.mul(g.zero, x), "0"),
        (lambda g, x, y: g.mul(x, g.one), "x"),
        (lambda g, x, y: g.mul(x, g.constant(-1)), "neg(x)"),
        (lambda g, x, y: g.mul(g.neg(x), y), "neg(*(x y))"),
        (lambda g, x, y: g.mul(g.neg(x), g.neg(y)), "*(x y)"),
        (lambda g, x, y: g.mul(g.constant(2), g.mul(x, g.constant(3))), "*(x 6)"),
        (lambda g, x, y: g.div(g.zero, x), "0"),
        (lambda g, x, y: g.div(x, g.constant(4)), "*(x 0.25)"),
        (lambda g, x, y: g.div(g.neg(x), y), "neg(/(x y))"),
        (lambda g, x, y: g.div(x, g.neg(y)), "neg(/(x y))"),
        (lambda g, x, y: g.div(g.constant(-2), y), "neg(/(2 y))"),
        (lambda g, x, y: g.div(x, g.zero), "*(x /(1 0))"),
        (lambda g, x, y: g.power(x, 0), "1"),
        (lambda g, x, y: g.power(x, 1), "x"),
        (lambda g, x, y: g.power(x, 2), "*(x x)"),
        (lambda g, x, y: g.power(x, 4), "*(*(x x) *(x x))"),
        (lambda g, x, y: g.power(x, -1), "/(1 x)"),
        (lambda g, x, y: g.power(x, 0.5), "sqrt(x)"),
        (lambda g, x, y: g.power(x, 1.5), "*(x sqrt(x))"),
        (lambda g, x, y: g.power(x, -0.5), "/(1 sqrt(x))"),
        (lambda g, x, y: g.power(x, 0.25), "pow(x 0.25)"),
        (lambda g, x, y: g.power(x, 100), "pow(x 100)"),
        (lambda g, x, y: g.function(Op.SIN, g.neg(x)), "neg(sin(x))"),
        (lambda g, x, y: g.function(Op.COS, g.neg(x)), "cos(x)"),
        (lambda g, x, y: g.function(Op.EXP, g.zero), "1"),
        (lambda g, x, y: g.function(Op.ATAN2, g.one, g.zero), f"{math.pi / 2:g}"),
        (lambda g, x, y: g.function(Op.LOG, g.zero), "log(0)"),
        (lambda g, x, y: g.function(Op.EXP, g.constant(1e4)), "exp(10000)"),
        (lambda g, x, y: g.total([]), "0"),
        (lambda g, x, y: g.total([x, g.zero, y]), "+(x y)"),
        (lambda g, x, y: g.negation(g.negation(g.mode(0))), "mode0"),
        (lambda g, x, y: g.logical(Op.AND, g.mode(1), g.mode(1)), "mode1"),
        (lambda g, x, y: g.select(g.mode(0), x, x), "x"),
        (lambda g, x, y: g.select(g.negation(g.mode(0)), x, y), "select(mode0 y x)"),
    ],
)
def test_folding(build: Build, expected: str) -> None:
    graph = Graph()
    x, y = graph.input("q", 0, "x"), graph.input("q", 1, "y")
    assert shown(graph, build(graph, x, y)) == expected


@pytest.mark.parametrize(
    ("build", "expected"),
    [
        (lambda g, x, y, z: g.sub(x, g.add(g.add(x, y), z)), "neg(+(y z))"),
        (lambda g, x, y, z: g.add(g.sub(y, x), g.sub(x, z)), "-(y z)"),
        (lambda g, x, y, z: g.sub(g.neg(g.add(x, y)), g.sub(z, x)), "neg(+(y z))"),
        (lambda g, x, y, z: g.add(g.sub(x, y), g.sub(y, x)), "0"),
        (lambda g, x, y, z: g.add(g.add(x, y), g.add(x, z)), "+(+(x y) +(x z))"),
    ],
)
def test_a_term_that_is_taken_back_is_left_out(build: Build, expected: str) -> None:
    graph = Graph()
    x, y, z = (graph.input("q", k, name) for k, name in enumerate("xyz"))
    with graph.cancelling():
        assert shown(graph, build(graph, x, y, z)) == expected


def test_equal_values_are_one_value() -> None:
    graph = Graph()
    x, y = graph.input("q", 0, "x"), graph.input("q", 1, "y")
    first = graph.mul(graph.function(Op.SIN, x), y)
    count = len(graph.values)
    assert graph.mul(y, graph.function(Op.SIN, x)) == first
    assert graph.neg(graph.mul(graph.neg(y), graph.function(Op.SIN, x))) == first
    assert len(graph.values) == count + 2  # -y and -(y sin x)


def test_no_negative_zero() -> None:
    graph = Graph()
    assert graph.constant(-0.0) == graph.zero
    assert math.copysign(1, graph.values[graph.zero].literal) == 1


def test_work_of_parameters_alone_is_settled() -> None:
    graph = Graph()
    p, x = graph.input("p", 0, "p"), graph.input("q", 0, "x")
    ratio = graph.div(x, p)
    assert shown(graph, ratio) == "*(x /(1 p))"
    assert graph.settled[graph.values[ratio].args[1]]
    assert not graph.settled[ratio]
    assert not graph.settled[graph.mode(0)]


def test_arguments_come_before_their_users() -> None:
    graph = Graph()
    x = graph.input("q", 0, "x")
    graph.power(graph.add(graph.function(Op.SIN, x), graph.one), 5)
    assert all(a < k for k, value in enumerate(graph.values) for a in value.args)


def test_values_are_credited_to_who_needs_them_first() -> None:
    graph = Graph()
    x = graph.input("q", 0, "x")
    with graph.serving("joint"):
        sine = graph.function(Op.SIN, x)
    with graph.serving("force"):
        assert graph.function(Op.SIN, x) == sine
        cosine = graph.function(Op.COS, x)
    assert graph.values[sine].serves == "joint"
    assert graph.values[cosine].serves == "force"
