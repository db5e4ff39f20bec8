"""Tangents against complex steps: every operation, random programs, whole machines."""

import cmath
import math
from collections.abc import Callable
from itertools import product
from types import SimpleNamespace

import pytest

from codegen.lower.differentiation.program_tangents import differentiate
from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.program import LEAVES, LOGICAL, Kernel, Op, Output, Program
from codegen.tables.piecewise_cubic import fit
from tests.codegen.emit.test_random_graphs import MODES, STATES, random_program
from tests.codegen.workbench import STEP

ANALYTIC = SimpleNamespace(
    **{name: getattr(cmath, name) for name in dir(cmath)}, atan2=lambda y, x: cmath.atan(y / x)
)
"""Complex functions; `cmath` has no arc tangent of two sides, which only jumps from this one."""

ORDERS = range(4)
BUMPS = fit("bumps", [0.0, 0.5, 1.5, 2.0, 3.0], [1.0, -0.3, 2.0, 0.4, 1.0], periodic=True)

Build = Callable[[Graph, int, int], int]

SINGLE = (
    *(Op.SIN, Op.COS, Op.TAN, Op.ASIN, Op.ACOS, Op.ATAN, Op.SINH, Op.COSH, Op.TANH, Op.EXP),
    *(Op.LOG, Op.SQRT, Op.FLOOR),
)


def elementary(op: Op) -> Build:
    return lambda g, x, y: g.function(op, g.mul(x, y))


def spline(order: int) -> Build:
    return lambda g, x, y: g.lookup(BUMPS, order, g.add(x, g.mul(y, y)))


EVERY: dict[str, Build] = {
    "add": lambda g, x, y: g.add(x, y),
    "sub": lambda g, x, y: g.sub(x, y),
    "neg": lambda g, x, y: g.neg(g.mul(x, y)),
    "product": lambda g, x, y: g.mul(x, y),
    "square": lambda g, x, y: g.mul(x, x),
    "quotient": lambda g, x, y: g.div(x, y),
    "inverse": lambda g, x, y: g.div(g.constant(3.0), y),
    "atan2": lambda g, x, y: g.function(Op.ATAN2, x, y),
    "power": lambda g, x, y: g.power(x, 0.3),
    "high power": lambda g, x, y: g.power(x, 71.0),
    "powers of each other": lambda g, x, y: g.function(Op.POW, x, y),
    "exponential": lambda g, x, y: g.function(Op.POW, g.constant(2.5), y),
    "chosen": lambda g, x, y: g.select(g.mode(0), g.mul(x, y), g.function(Op.SIN, x)),
    "not chosen": lambda g, x, y: g.select(g.mode(1), g.mul(x, y), g.function(Op.SIN, x)),
    "held": lambda g, x, y: g.select(g.is_sliding(2), g.mul(x, y), g.function(Op.SIN, x)),
    "not held": lambda g, x, y: g.select(g.is_sliding(0), g.mul(x, y), g.function(Op.SIN, x)),
    "combined": lambda g, x, y: g.select(
        g.logical(Op.AND, g.negation(g.mode(1)), g.logical(Op.OR, g.mode(0), g.mode(1))), x, y
    ),
    **{op.value: elementary(op) for op in SINGLE},
    **{f"spline {order}": spline(order) for order in ORDERS},
}
IN_MODES = [1, 0, 2]


def two_inputs(build: Build) -> Program:
    """f(x, y) and its tangent along (dx, dy)."""
    graph = Graph()
    x, y = (graph.input("q", k, name) for k, name in enumerate("xy"))
    dx, dy = (graph.input("dq", k, f"d_{name}") for k, name in enumerate("xy"))
    value = build(graph, x, y)
    (tangent,) = differentiate(graph, [value], {x: dx, y: dy})
    kernels = (
        Kernel("f", "", ("q", "modes", "out"), (Output("out", 0, value),)),
        Kernel("df", "", ("q", "modes", "dq", "out"), (Output("out", 0, tangent),)),
    )
    return Program(tuple(graph.values), kernels, (), 1e-9)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("at", [(0.7, 0.9), (0.35, 1.4), (0.95, 0.2)])
def test_every_operation(name: str, at: tuple[float, float]) -> None:
    program = two_inputs(EVERY[name])
    for direction in ((1.0, 0.0), (0.0, 1.0), (0.8, -1.7)):
        moved = [a + 1j * STEP * d for a, d in zip(at, direction, strict=True)]
        moved_value = evaluate(program, "f", {"q": moved, "modes": IN_MODES}, ANALYTIC)
        expected = moved_value["out"][0].imag / STEP
        inputs = {"q": at, "modes": IN_MODES, "dq": direction}
        got = evaluate(program, "df", inputs, math)["out"][0]
        assert got == pytest.approx(expected, rel=1e-14, abs=1e-14)


def test_no_operation_is_left_out() -> None:
    met = {v.op for build in EVERY.values() for v in two_inputs(build).values}
    assert met >= set(Op) - {Op.LESS}
    assert not {op for op in Op if op not in met} - LOGICAL - LEAVES


@pytest.mark.parametrize("at", [(1.2, -0.5), (-0.3, -2.0), (-0.7, 0.4)])
def test_angle_in_every_quadrant(at: tuple[float, float]) -> None:
    test_every_operation("atan2", at)


@pytest.mark.parametrize("block", range(4))
def test_random_programs_in_every_mode(block: int) -> None:
    for seed in range(50 * block, 50 * (block + 1)):
        program = random_program(seed)
        (kernel,) = program.kernels
        graph = Graph.of(program.values)
        assert tuple(graph.values) == program.values
        inputs = [graph.input("q", k, f"q_{k}") for k in range(STATES)]
        seeds = {x: graph.input("dq", k, f"d_{k}") for k, x in enumerate(inputs)}
        tangents = differentiate(graph, [out.value for out in kernel.outputs], seeds)
        outputs = tuple(Output("out", k, x) for k, x in enumerate(tangents))
        whole = Program(tuple(graph.values), (kernel, Kernel("df", "", ("q",), outputs)), (), 1e-9)
        q, dq = [0.3, 1.7, -2.2], [0.7, -0.4, 1.1]
        moved = [a + 1j * STEP * d for a, d in zip(q, dq, strict=True)]
        for modes in product((0, 1), repeat=MODES):
            expected = evaluate(whole, "f", {"q": moved, "modes": modes})["out"]
            got = evaluate(whole, "df", {"q": q, "dq": dq, "modes": modes}, math)["out"]
            for k, value in got.items():
                exact = complex(expected[k]).imag / STEP
                assert value == pytest.approx(exact, rel=1e-12, abs=1e-12), (seed, modes)


def test_what_the_direction_does_not_reach_costs_nothing() -> None:
    graph = Graph()
    x, y = graph.input("q", 0, "x"), graph.input("q", 1, "y")
    far = graph.function(Op.SIN, graph.div(graph.mul(y, y), graph.input("p", 0, "p")))
    product_ = graph.mul(x, far)
    dx = graph.input("dq", 0, "d_x")
    count = len(graph.values)
    assert differentiate(graph, [far, product_, x, y], {x: dx}) == [
        graph.zero,
        graph.mul(dx, far),
        dx,
        graph.zero,
    ]
    assert len(graph.values) == count + 1


def test_equal_tangents_are_one_value() -> None:
    graph = Graph()
    x, y, dx = graph.input("q", 0, "x"), graph.input("q", 1, "y"), graph.input("dq", 0, "d_x")
    one, other = graph.mul(graph.function(Op.SIN, x), y), graph.mul(graph.function(Op.SIN, x), y)
    assert len(set(differentiate(graph, [one, graph.add(other, y)], {x: dx}))) == 1


def test_tangents_serve_whom_their_values_serve() -> None:
    graph = Graph()
    x, dx = graph.input("q", 0, "x"), graph.input("dq", 0, "d_x")
    with graph.serving("spring"):
        force = graph.power(x, 3)
    (tangent,) = differentiate(graph, [force], {x: dx})
    assert graph.values[tangent].serves == "spring"


@pytest.mark.parametrize(
    ("build", "slope"),
    [
        (lambda g, x, y: g.mul(x, g.function(Op.SQRT, g.add(g.mul(x, x), g.mul(y, y)))), 0.0),
        (lambda g, x, y: g.power(x, 1.5), 0.0),
        (lambda g, x, y: g.power(x, 1.3), 0.0),
        (lambda g, x, y: g.function(Op.POW, x, g.add(g.one, g.one)), 0.0),
        (lambda g, x, y: g.add(x, g.function(Op.TANH, g.mul(g.constant(1e6), x))), 1e6 + 1.0),
    ],
    ids=["drag at rest", "contact at its onset", "odd power", "whole power", "creep at rest"],
)
def test_slopes_at_rest_are_numbers(build: Build, slope: float) -> None:
    program = two_inputs(build)
    inputs = {"q": [0.0, 0.0], "modes": IN_MODES, "dq": [1.0, 0.0]}
    assert evaluate(program, "df", inputs, math)["out"][0] == slope
