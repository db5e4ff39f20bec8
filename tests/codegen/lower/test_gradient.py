"""Walks back and forward through values, against complex steps and against each other."""

import math
from types import SimpleNamespace

import pytest

from codegen.lower.constant_hoisting import orient_differences
from codegen.lower.differentiation.derivative_along_motion import Direction
from codegen.lower.differentiation.gradient import Slopes
from codegen.lower.differentiation.program_tangents import differentiate
from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.operation_count import operations
from codegen.lower.program import Kernel, Op, Output, Program, store
from tests.codegen.lower.test_tangent import ANALYTIC, EVERY, IN_MODES
from tests.codegen.workbench import STEP

DIRECTION = (0.8, -1.7)
NO_ERROR = SimpleNamespace(sqrt=lambda x: math.sqrt(x) if x >= 0.0 else math.nan)
"""As machine code has it."""
TWICE = sorted(EVERY.keys() - {"spline 2", "spline 3"})
"""Splines have a third derivative that jumps, and none after it."""


def derivatives(name: str) -> Program:
    """f, its slopes, and its first and second derivative along DIRECTION."""
    graph = Graph()
    x, y = (graph.input("q", k, letter) for k, letter in enumerate("xy"))
    value = graph.mul(graph.constant(1.5), EVERY[name](graph, x, y))
    slopes = Slopes(graph, (x, y)).gradient({value: graph.constant(-2.0)})
    rates = {x: graph.constant(DIRECTION[0]), y: graph.constant(DIRECTION[1])}
    jet = Direction(graph, rates).jet(value)
    (tangent,) = differentiate(graph, [value], rates)
    named = {
        "f": [value],
        "slopes": [slopes.get(k, graph.zero) for k in (x, y)],
        "jet": [jet.first.value(), jet.second.value()],
        "tangent": [tangent],
    }
    kernels = tuple(
        Kernel(kernel, "", ("q", "modes", "out"), store("out", values, [""] * len(values)))
        for kernel, values in named.items()
    )
    return Program(tuple(graph.values), kernels, (), 1e-9)


def out(program: Program, kernel: str, q: list[complex], functions: object = math) -> list[complex]:
    found = evaluate(program, kernel, {"q": q, "modes": IN_MODES}, functions)["out"]
    return [found[k] for k in range(len(found))]


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("at", [(0.7, 0.9), (0.35, 1.4), (0.95, 0.2)])
def test_slopes_of_every_operation(name: str, at: tuple[float, float]) -> None:
    program = derivatives(name)
    for k, got in enumerate(out(program, "slopes", list(at))):
        moved = [a + 1j * STEP * (j == k) for j, a in enumerate(at)]
        (value,) = out(program, "f", moved, ANALYTIC)
        assert got == pytest.approx(-2.0 * complex(value).imag / STEP, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("name", TWICE)
@pytest.mark.parametrize("at", [(0.7, 0.9), (0.35, 1.4), (0.95, 0.2)])
def test_both_derivatives_along_a_line(name: str, at: tuple[float, float]) -> None:
    program = derivatives(name)
    first, second = out(program, "jet", list(at))
    moved = [a + 1j * STEP * d for a, d in zip(at, DIRECTION, strict=True)]
    (value,), (tangent,) = (out(program, k, moved, ANALYTIC) for k in ("f", "tangent"))
    assert first == pytest.approx(complex(value).imag / STEP, rel=1e-13, abs=1e-13)
    assert second == pytest.approx(complex(tangent).imag / STEP, rel=1e-12, abs=1e-12)


def turning_twice() -> tuple[Graph, int, list[int], list[int]]:
    """x component of A(φ) A(θ) s."""
    graph = Graph()
    phi, theta = (graph.input("q", k, f"q_{k}") for k in range(2))
    rates = [graph.input("v", k, f"v_{k}") for k in range(2)]
    (c, s), (d, e) = ((graph.function(Op.COS, k), graph.function(Op.SIN, k)) for k in (phi, theta))
    value = graph.sub(graph.mul(c, d), graph.mul(s, e))
    return graph, value, [phi, theta], rates


def test_two_turns_are_one_by_the_sum_of_their_rates() -> None:
    graph, value, angles, rates = turning_twice()
    second = Direction(graph, dict(zip(angles, rates, strict=True))).jet(value).second.value()
    kernel = Kernel("f", "", ("q", "v"), (Output("out", 0, value), Output("out", 1, second)))
    program = Program(tuple(graph.values), (kernel,), (), 1e-9)
    # 4 functions, 2 products and a difference; then the sum, its square, a product, a sign
    assert operations(program, kernel) == 11
    found = evaluate(program, "f", {"q": [0.3, 1.1], "v": [2.0, -0.5]}, math)["out"]
    assert found[1] == pytest.approx(-(1.5**2) * math.cos(1.4), rel=1e-14)


def test_a_difference_that_only_its_opposite_needs_is_turned_about() -> None:
    graph = Graph()
    x, y = (graph.input("q", k, letter) for k, letter in enumerate("xy"))
    opposite = graph.neg(graph.sub(x, y))
    for outputs, expected in (([opposite], 1), ([opposite, graph.sub(x, y)], 2)):
        kernel = Kernel("f", "", ("q", "out"), store("out", outputs, [""] * len(outputs)))
        program = Program(orient_differences(graph, (kernel,))[0], (kernel,), (), 1e-9)
        assert operations(program, kernel) == expected
        found = evaluate(program, "f", {"q": [3.0, 5.0]}, math)["out"]
        assert [found[k] for k in range(len(outputs))] == [2.0, -2.0][: len(outputs)]


@pytest.mark.parametrize("sine_first", [True, False])
@pytest.mark.parametrize("turned", [True, False])
def test_a_difference_of_products_with_sine_and_cosine_in_both(
    sine_first: bool, turned: bool
) -> None:
    """sin θ cos θ - x y cos θ is no component of a turned vector's usual form."""
    graph = Graph()
    angle, x, y = inputs = [graph.input("q", k, letter) for k, letter in enumerate("axy")]
    ops = (Op.SIN, Op.COS) if sine_first else (Op.COS, Op.SIN)
    made = {op: graph.function(op, angle) for op in ops}
    pair = [graph.mul(made[Op.SIN], made[Op.COS]), graph.mul(made[Op.COS], graph.mul(x, y))]
    value = graph.sub(*(pair[::-1] if turned else pair))
    slopes = Slopes(graph, inputs).gradient({value: graph.one})
    kernel = Kernel("f", "", ("q",), store("out", [slopes[k] for k in inputs], [""] * 3))
    found = evaluate(
        Program(tuple(graph.values), (kernel,), (), 1e-9), "f", {"q": [0.7, 1.3, -0.4]}, math
    )["out"]
    sign = -1.0 if turned else 1.0
    exact = (math.cos(1.4) + 1.3 * -0.4 * math.sin(0.7), 0.4 * math.cos(0.7), -1.3 * math.cos(0.7))
    assert [found[k] for k in range(3)] == pytest.approx([sign * e for e in exact], rel=1e-14)


@pytest.mark.parametrize(("mode", "size"), [(1, 1.0), (0, 0.0)])
def test_slopes_that_are_no_number_where_a_choice_does_not_hold(mode: int, size: float) -> None:
    """3 δ^1.5 in contact, 0 without, δ = x y + z below zero: a walk back is no product with nan."""
    graph = Graph()
    x, y, z = inputs = [graph.input("q", k, letter) for k, letter in enumerate("xyz")]
    depth = graph.add(graph.mul(x, y), z)
    energy = graph.mul(depth, graph.function(Op.SQRT, depth))
    value = graph.mul(graph.constant(3.0), graph.select(graph.mode(0), energy, graph.zero))
    slopes = Slopes(graph, inputs).gradient({value: graph.one})
    kernel = Kernel("f", "", ("q", "modes"), store("out", [slopes[k] for k in inputs], [""] * 3))
    program = Program(tuple(graph.values), (kernel,), (), 1e-9)
    arguments = {"q": [2.0, 1.5 if mode else -1.5, 0.25], "modes": [mode]}
    found = evaluate(program, "f", arguments, NO_ERROR)["out"]
    force = 4.5 * math.sqrt(3.25) * size
    assert [found[k] for k in range(3)] == pytest.approx([1.5 * force, 2.0 * force, force])
