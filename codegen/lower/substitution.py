"""Values built anew with others in the place of some: substitution in a graph.

Every operation is asked of the graph again, so that what a substitution makes constant is folded,
what it makes zero annihilates, and what it makes equal is one value. A sine of a sum whose second
term does not move, such as the angle of a body that is fixed to another, becomes the sum of
products of what is known and the sine and cosine of the first.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from codegen.lower.graph import Graph
from codegen.lower.program import Lookup, Op, Value


def reached(graph: Graph, roots: Iterable[int], stop: Mapping[int, object] = {}) -> set[int]:
    """Numbers of the values that the roots are made of, not looking below those in `stop`."""
    stack, numbers = list(roots), set[int]()
    while stack:
        number = stack.pop()
        if number not in numbers:
            numbers.add(number)
            if number not in stop:
                stack.extend(graph.values[number].args)
    return numbers


def rebuilt(graph: Graph, outputs: Sequence[int], replaced: Mapping[int, int]) -> list[int]:
    """The outputs with values replaced, as values of the same graph.

    Parameters
    ----------
    replaced
        Number of a value, an input or a function of one, → what stands in its place.
    """
    known = dict(replaced)
    for number in sorted(reached(graph, outputs, replaced)):
        if number in known:
            continue
        value = graph.values[number]
        args = tuple(known[a] for a in value.args)
        if args == value.args:
            known[number] = number
            continue
        with graph.serving(value.serves):
            known[number] = _again(graph, value, args)
    return [known[number] for number in outputs]


def _again(graph: Graph, value: Value, args: tuple[int, ...]) -> int:
    if value.op in ARITHMETIC:
        return ARITHMETIC[value.op](graph, *args)
    if value.op in (Op.SIN, Op.COS):
        return turned(graph, value.op, *args)
    if value.op is Op.POW:
        exponent = graph.number(args[1])
        if exponent is not None:
            return graph.power(args[0], exponent)
    if value.op is Op.TABLE:
        assert isinstance(value.literal, Lookup)
        return graph.lookup(value.literal.table, value.literal.order, *args)
    return graph.function(value.op, *args)


def turned(graph: Graph, op: Op, angle: int) -> int:
    """sin or cos of an angle; of a sum with a constant angle by the angle's own."""
    value = graph.values[angle]
    if value.op is Op.NEG:
        same = turned(graph, op, value.args[0])
        return graph.neg(same) if op is Op.SIN else same
    if value.op not in (Op.ADD, Op.SUB) or graph.settled[angle]:
        return graph.function(op, angle)
    moving, fixed = value.args
    turns, offset = 1, -1 if value.op is Op.SUB else 1
    if graph.settled[moving]:
        moving, fixed, turns, offset = fixed, moving, offset, 1
    if not graph.settled[fixed]:
        return graph.function(op, angle)
    s, c = turned(graph, Op.SIN, moving), turned(graph, Op.COS, moving)
    fixed_s, fixed_c = graph.function(Op.SIN, fixed), graph.function(Op.COS, fixed)
    if turns < 0:
        s = graph.neg(s)
    if offset < 0:
        fixed_s = graph.neg(fixed_s)
    if op is Op.SIN:
        return graph.add(graph.mul(fixed_c, s), graph.mul(fixed_s, c))
    return graph.sub(graph.mul(fixed_c, c), graph.mul(fixed_s, s))


ARITHMETIC: dict[Op, Callable[..., int]] = {
    Op.ADD: Graph.add,
    Op.SUB: Graph.sub,
    Op.MUL: Graph.mul,
    Op.DIV: Graph.div,
    Op.NEG: Graph.neg,
    Op.NOT: Graph.negation,
    Op.AND: lambda graph, a, b: graph.logical(Op.AND, a, b),
    Op.OR: lambda graph, a, b: graph.logical(Op.OR, a, b),
    Op.SELECT: Graph.select,
}
