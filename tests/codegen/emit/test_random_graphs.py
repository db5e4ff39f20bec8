"""Random programs: what is written must compute what the program says, in every mode."""

import math
from itertools import product

import numpy as np
import pytest

from codegen.emit.kernel import Arguments, KernelText
from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.program import Kernel, Op, Output, Program

MODES, STATES = 4, 3
Q = [0.3, 1.7, -2.2]


def random_program(seed: int) -> Program:
    """Sums, products, sines and choices of each other, with compound conditions."""
    random = np.random.default_rng(seed)
    graph = Graph()
    values = [graph.input("q", k, f"q_{k}") for k in range(STATES)]
    conditions = [graph.mode(k) for k in range(MODES)]

    def some(items: list[int]) -> int:
        return items[int(random.integers(len(items)))]

    for _ in range(int(random.integers(4))):
        kind = random.integers(5)
        if kind == 0:
            conditions.append(graph.negation(some(conditions)))
        else:
            op = Op.AND if kind < 3 else Op.OR
            conditions.append(graph.logical(op, some(conditions), some(conditions)))
    for _ in range(int(random.integers(2, 14))):
        kind, a, b = random.random(), some(values), some(values)
        if kind < 0.45:
            values.append(graph.select(some(conditions), a, b))
        elif kind < 0.6:
            values.append(graph.add(a, b))
        elif kind < 0.7:
            values.append(graph.sub(a, b))
        elif kind < 0.85:
            values.append(graph.mul(a, b))
        else:
            values.append(graph.function(Op.SIN, a))
    wanted = [values[-1], *(some(values) for _ in range(int(random.integers(3))))]
    outputs = tuple(Output("out", k, value) for k, value in enumerate(wanted))
    kernel = Kernel("f", "A random kernel.", ("q", "modes", "out"), outputs)
    return Program(tuple(graph.values), (kernel,), (), 1e-9)


@pytest.mark.parametrize("block", range(20))
def test_text_and_program_agree_in_every_mode(block: int) -> None:
    for seed in range(100 * block, 100 * (block + 1)):
        program = random_program(seed)
        (kernel,) = program.kernels
        lines = KernelText(program, kernel, Arguments(0)).lines()
        text = "\n".join(line for line in lines if not line.startswith("@"))
        namespace = {"math": math}
        exec(compile(text, f"<seed {seed}>", "exec"), namespace)
        function = namespace["f"]
        assert callable(function)
        for modes in product((0, 1), repeat=MODES):
            out = [math.nan] * len(kernel.outputs)
            function(Q, modes, out)
            expected = evaluate(program, "f", {"q": Q, "modes": modes}, math)["out"]
            assert out == [expected[k] for k in range(len(out))], (seed, modes, text)
