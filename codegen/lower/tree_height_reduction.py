"""Tree-height reduction: sums and products of a kernel begin with the values known first.

A processor begins an operation once its arguments are there, and has several under way at once. In
((a - b) - c) + d, d waits for all before it, even if it alone was known from the beginning. Of the
terms of a chain, the two that are known first are joined, again and again (D. J. Kuck, The
Structure of Computers and Computations, 1978, section 2.3). Of a loop in closed form, 1/√S becomes
√S/S, whose root and quotient are taken at once.
"""

from collections import Counter
from dataclasses import replace
from heapq import heapify, heappop, heappush

from codegen.lower.graph import SUMS, Graph, with_arguments
from codegen.lower.program import LEAVES, LOGICAL, Kernel, Op, dependencies

LARGEST = 4000  # measured: values of a kernel; a larger one keeps the processor busy in any order
_FUNCTION = 45  # measured: cycles of a sine, and of all operations not named below
_CYCLES = {  # measured: of the other operations
    **dict.fromkeys((*LEAVES, *LOGICAL, Op.SELECT, Op.NEG), 0),
    Op.ADD: 4, Op.SUB: 4, Op.MUL: 4, Op.DIV: 14, Op.SQRT: 18,
}  # fmt: skip
_SIGNS = {**SUMS, Op.MUL: (1, 1)}  # of the arguments of what forms chains


def reduce_height(graph: Graph, kernel: Kernel) -> Kernel:
    """The kernel with its chains joined anew, in values of the same graph."""
    values, heights, known = graph.values, list[int](), dict[int, int]()
    needed = sorted(dependencies(values, kernel.roots))
    if len(needed) > LARGEST:
        return kernel
    uses = Counter(kernel.roots)
    for number in needed:
        uses.update(values[number].args)

    inside = {  # values that are part of the chain of their only user
        a for k in needed if values[k].op in _SIGNS for a in values[k].args
        if values[a].op in _SIGNS and uses[a] == 1
        and (values[a].op is Op.MUL) == (values[k].op is Op.MUL)
    }  # fmt: skip

    def height(number: int) -> int:
        """Cycles until a value is known."""
        for k in range(len(heights), len(values)):
            before = max((heights[a] for a in values[k].args), default=0)
            heights.append(0 if graph.settled[k] else before + _CYCLES.get(values[k].op, _FUNCTION))
        return heights[number]

    def joined(chain: int) -> int:
        stack, terms = [(chain, 1)], list[tuple[int, int, int, int]]()
        while stack:
            a, sign = stack.pop()
            if a == chain or a in inside:
                pairs = zip(values[a].args, _SIGNS[values[a].op], strict=True)
                stack += [(inner, sign * own) for inner, own in pairs][::-1]
            else:
                terms.append((height(known[a]), len(terms), known[a], sign))
        heapify(terms)
        while len(terms) > 1:
            (_, place, a, sign), (*_, b, other) = heappop(terms), heappop(terms)
            if values[chain].op is Op.MUL:
                c = graph.mul(a, b)
            elif sign == other:
                c = graph.add(a, b)
            else:
                c, sign = graph.sub(*((a, b) if sign > 0 else (b, a))), 1
            heappush(terms, (height(c), place, c, sign))
        ((*_, whole, sign),) = terms
        return whole if sign > 0 else graph.neg(whole)

    for number in needed:
        value = values[number]
        with graph.serving(value.serves):
            if value.op in _SIGNS:
                if number not in inside:
                    known[number] = joined(number)
                continue
            args = tuple(known[a] for a in value.args)
            factor, root = _root(graph, args[1]) if value.op is Op.DIV else (graph.one, None)
            # Laws may have a value where a root of theirs vanishes, and its inverse is infinite.
            if root is not None and value.serves == "reduction":
                inverse = graph.div(graph.one, values[root].args[0])
                quotient = graph.div(args[0], factor)
                known[number] = graph.mul(quotient, graph.mul(root, inverse))
            else:
                same = args == value.args
                known[number] = number if same else with_arguments(graph, value, args)
    return replace(
        kernel,
        outputs=tuple(x._replace(value=known[x.value]) for x in kernel.outputs),
        checks=tuple(
            x._replace(pivot=known[x.pivot], reference=known[x.reference]) for x in kernel.checks
        ),
        labels=tuple(x._replace(value=known.get(x.value, x.value)) for x in kernel.labels),
    )


def _root(graph: Graph, a: int) -> tuple[int, int | None]:
    """c and √S of a = c √S, c known before the run; None where it has another form."""
    op, args = graph.values[a].op, graph.values[a].args
    if op is Op.ADD and args[0] == args[1]:
        factor, root = _root(graph, args[0])
        return graph.add(factor, factor), root
    for c, rest in (args, args[::-1]) if op is Op.MUL else ():
        if graph.settled[c] and graph.values[rest].op is Op.SQRT:
            return c, rest
    return graph.one, a if op is Op.SQRT else None
