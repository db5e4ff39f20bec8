"""The cost of a program: operations of each kernel, and the element that each serves."""

from collections import Counter
from collections.abc import Sequence

from codegen.lower.constant_hoisting import with_constants
from codegen.lower.graph import Graph
from codegen.lower.program import FUNCTIONS, LEAVES, LOGICAL, Kernel, Op, Program

WEIGHTS = {Op.DIV: 5, Op.SQRT: 5, Op.NEG: 0, Op.SELECT: 1}
"""Operations whose time is far from that of a product; elementary functions count 20."""

_FREE = LEAVES | LOGICAL  # operations that are none of arithmetic


def operations(program: Program, kernel: Kernel) -> int:
    """Arithmetic operations of a kernel, each counted once."""
    return sum(count for op, count in program.counts(kernel).items() if op not in _FREE)


def by_element(program: Program, kernel: Kernel) -> Counter[str]:
    """Operations of a kernel by the element for which they were first needed."""
    counts: Counter[str] = Counter()
    hoisted, values = program.hoisted(kernel), program.values
    for number in program.reachable(kernel):
        if number not in hoisted and values[number].op not in _FREE:
            counts[values[number].serves] += 1
    return counts


def cost(graph: Graph, kernel: Kernel) -> int:
    """Weighted operations of a kernel by itself, to compare two for the same question."""
    return weighted_operations(with_constants(graph, (kernel,), declared=0), kernel)


def cheapest(graph: Graph, kernels: Sequence[Kernel]) -> Kernel:
    """The first of the kernels that cost least; one alone is not counted."""
    one, *others = kernels
    return min(kernels, key=lambda kernel: cost(graph, kernel)) if others else one


def weighted_operations(program: Program, kernel: Kernel) -> int:
    """Operations of a program's kernel, weighted by their time."""
    slow = FUNCTIONS - {Op.SQRT}
    weights = {op: 20 if op in slow else WEIGHTS.get(op, 1) for op in Op if op not in _FREE}
    counts = program.counts(kernel).items()
    return sum(weights.get(op, 0) * count for op, count in counts) + 2 * len(kernel.checks)
