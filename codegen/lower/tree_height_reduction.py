"""Tree-height reduction: sums and products of a kernel begin with what is known first.

A processor begins an operation once its arguments are there, and has several under way at once. In
((a - b) - c) + d, d waits for all before it, even if it alone was known from the beginning. Of the
terms of a chain, the two that are known first are joined, again and again (D. J. Kuck, The
Structure of Computers and Computations, 1978, section 2.3).
"""

from collections import Counter
from dataclasses import replace
from heapq import heapify, heappop, heappush

from codegen.lower.graph import SUMS, Graph, with_arguments
from codegen.lower.program import LEAVES, LOGICAL, Kernel, Op, dependencies

LARGEST = 4000  # measured: values of a kernel; a larger one has enough under way at once
_FUNCTION = 45  # measured: cycles of a sine, and of what is not named below
_CYCLES = {  # measured: of the other operations
    **dict.fromkeys((*LEAVES, *LOGICAL, Op.SELECT, Op.NEG), 0),
    **dict.fromkeys((Op.ADD, Op.SUB, Op.MUL), 4),
    Op.DIV: 14,
    Op.SQRT: 18,
}


def reduce_height(graph: Graph, kernel: Kernel) -> Kernel:
    """The kernel with its chains joined anew, in values of the same graph."""
    values, heights = graph.values, list[int]()  # cycles until a value is known
    needed = sorted(dependencies(values, kernel.roots))
    if len(needed) > LARGEST:
        return kernel
    uses = Counter(kernel.roots)
    for number in needed:
        uses.update(values[number].args)
    kinds = {k: Op.ADD if values[k].op in SUMS else values[k].op for k in needed}
    chained = {  # values that are part of the chain of their only user
        a
        for k in needed
        for a in values[k].args
        if uses[a] == 1 and kinds[a] == kinds[k] and kinds[k] in (Op.ADD, Op.MUL)
    }
    known: dict[int, int] = {}

    def height(number: int) -> int:
        for k in range(len(heights), len(values)):
            before = max((heights[a] for a in values[k].args), default=0)
            own = _CYCLES.get(values[k].op, _FUNCTION)
            heights.append(0 if graph.settled[k] else before + own)
        return heights[number]

    def terms(number: int) -> list[tuple[int, int]]:
        stack, found = [(number, 1)], list[tuple[int, int]]()
        while stack:
            a, sign = stack.pop()
            if a == number or a in chained:
                signs = SUMS.get(values[a].op, (1, 1))
                pairs = zip(values[a].args, signs, strict=True)
                stack += [(inner, sign * own) for inner, own in pairs][::-1]
            else:
                found.append((known[a], sign))
        return found

    def joined(number: int) -> int:
        heap = [(height(a), k, a, sign) for k, (a, sign) in enumerate(terms(number))]
        heapify(heap)
        while len(heap) > 1:
            (_, place, a, sign), (*_, b, other) = heappop(heap), heappop(heap)
            if kinds[number] is Op.MUL:
                c = graph.mul(a, b)
            elif sign == other:
                c = graph.add(a, b)
            else:
                c, sign = graph.sub(*((a, b) if sign > 0 else (b, a))), 1
            heappush(heap, (height(c), place, c, sign))
        ((*_, whole, sign),) = heap
        return whole if sign > 0 else graph.neg(whole)

    for number in needed:
        value = values[number]
        if number in chained:
            continue
        with graph.serving(value.serves):
            if kinds[number] in (Op.ADD, Op.MUL):
                known[number] = joined(number)
                continue
            args = tuple(known[a] for a in value.args)
            known[number] = number
            if args != value.args:
                known[number] = with_arguments(graph, value, args)
    return replace(
        kernel,
        outputs=tuple(out._replace(value=known[out.value]) for out in kernel.outputs),
        checks=tuple(
            check._replace(pivot=known[check.pivot], reference=known[check.reference])
            for check in kernel.checks
        ),
        labels=tuple(
            label._replace(value=known[label.value])
            for label in kernel.labels
            if label.value in known
        ),
    )
