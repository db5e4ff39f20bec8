"""Chains of sums and products: what is known first is joined first, and the value stays."""

import random
from collections.abc import Callable

import mpmath
import pytest

from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.program import Check, Kernel, Label, Op, Output, Program, dependencies, store
from codegen.lower.tree_height_reduction import LARGEST, reduce_height

CYCLES = {Op.ADD: 4, Op.SUB: 4, Op.MUL: 4, Op.DIV: 14, Op.SQRT: 18, Op.SIN: 45}


def kernel_of(*values: int) -> Kernel:
    return Kernel("accelerations", "", ("q", "p", "a"), store("a", values, [""] * len(values)))


def height(graph: Graph, number: int) -> int:
    """Cycles until a value is known; parameters alone are known before."""
    value = graph.values[number]
    if graph.settled[number]:
        return 0
    return CYCLES.get(value.op, 0) + max((height(graph, a) for a in value.args), default=0)


def result(graph: Graph, kernel: Kernel, seed: int = 0) -> list[mpmath.mpf]:
    """What a kernel stores, in fifty digits."""
    generator = random.Random(seed)
    values = {
        name: [mpmath.mpf(generator.uniform(0.5, 2.0)) for _ in range(8)] for name in ("q", "p")
    }
    with mpmath.workdps(50):
        program = Program(tuple(graph.values), (kernel,), (), 1e-9)
        found = evaluate(program, "accelerations", values, mpmath.mp)["a"]
        return [found[k] for k in range(len(kernel.outputs))]


def test_what_is_known_last_is_added_last() -> None:
    graph = Graph()
    x, y, z = (graph.input("q", k, f"q{k}") for k in range(3))
    late = graph.function(Op.SIN, x)
    whole = graph.add(graph.sub(graph.sub(late, y), z), graph.mul(x, y))
    before = kernel_of(whole)
    after = reduce_height(graph, before)
    assert height(graph, whole) == 45 + 3 * 4
    assert height(graph, after.outputs[0].value) == 45 + 4
    assert abs(result(graph, before)[0] - result(graph, after)[0]) < 1e-40


def test_factors_of_parameters_form_one_constant() -> None:
    graph = Graph()
    a, b, c = (graph.input("p", k, f"p{k}") for k in range(3))
    x = graph.input("q", 0, "x")
    nested = graph.mul(a, graph.mul(b, graph.mul(c, x)))
    (out,) = reduce_height(graph, kernel_of(nested)).outputs
    constants = [k for k in graph.values[out.value].args if graph.settled[k]]
    assert len(constants) == 1
    assert height(graph, out.value) == 4


def test_a_law_keeps_its_inverse_root() -> None:
    """Where the root vanishes the inverse is infinite, and laws may have a value there."""
    graph = Graph()
    inverse = graph.div(graph.one, graph.function(Op.SQRT, graph.input("q", 0, "x")))
    kernel = kernel_of(graph.div(graph.one, graph.add(graph.one, inverse)))
    assert reduce_height(graph, kernel) == kernel


def test_what_others_need_stays_one_value() -> None:
    """A sum that is stored, checked or needed twice is no part of a longer one."""
    graph = Graph()
    x, y, z = (graph.input("q", k, f"q{k}") for k in range(3))
    stored = graph.add(graph.function(Op.SIN, x), y)
    outputs = (Output("a", 0, graph.add(stored, z)), Output("a", 1, stored))
    kernel = Kernel(
        "accelerations", "", ("q", "a"), outputs, (Check(stored, x, 0),),
        labels=(Label(stored, "pivot"),),
    )  # fmt: skip
    after = reduce_height(graph, kernel)
    assert after == kernel


def random_value(graph: Graph, generator: random.Random, depth: int) -> int:
    if depth == 0:
        return graph.input(generator.choice("qp"), generator.randrange(8), "x")
    kinds: list[Callable[[int, int], int]] = [graph.add, graph.sub, graph.mul, graph.mul, graph.add]
    a = random_value(graph, generator, generator.randrange(depth))
    b = random_value(graph, generator, depth - 1)
    if generator.random() < 0.2:
        b = graph.function(Op.SIN, b)
    if generator.random() < 0.1:
        b = graph.div(b, graph.add(graph.constant(40.0), graph.function(Op.SIN, a)))
    return generator.choice(kinds)(*generator.sample([a, b], 2))


@pytest.mark.parametrize("seed", range(30))
def test_random_kernels_keep_their_values_and_are_no_higher(seed: int) -> None:
    graph, generator = Graph(), random.Random(seed)
    before = kernel_of(*(random_value(graph, generator, 9) for _ in range(4)))
    after = reduce_height(graph, before)
    for one, other in zip(result(graph, before), result(graph, after), strict=True):
        assert abs(one - other) <= 1e-35 * (1 + abs(one))
    heights = [
        max(height(graph, out.value) for out in kernel.outputs) for kernel in (before, after)
    ]
    assert heights[1] <= heights[0]


def test_a_large_kernel_is_left_as_it_is() -> None:
    graph = Graph()
    x = graph.input("q", 0, "x")
    total = graph.function(Op.SIN, x)
    for k in range(LARGEST):
        total = graph.add(total, graph.constant(float(k + 1)))
    kernel = kernel_of(total)
    assert len(dependencies(graph.values, kernel.roots)) > LARGEST
    assert reduce_height(graph, kernel) is kernel
