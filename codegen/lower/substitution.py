"""Substitution in a graph: outputs with other values in the place of some.

Every operation is built by the graph again, so that new constants fold, new zeros annihilate,
and values that become equal are one. A sine of a sum whose second
term does not move, such as the angle of a body that is fixed to another, becomes the sum of
products of what is known and the sine and cosine of the first.
"""

from collections.abc import Callable, Mapping, Sequence

from codegen.lower.graph import Graph
from codegen.lower.program import Lookup, Op, Value, dependencies


def substitute(graph: Graph, outputs: Sequence[int], replaced: Mapping[int, int]) -> list[int]:
    """The outputs with each value in `replaced` replaced, as values of the same graph."""
    known = dict(replaced)
    for number in sorted(dependencies(graph.values, outputs, replaced) - replaced.keys()):
        value = graph.values[number]
        args = tuple(known[a] for a in value.args)
        known[number] = number
        if args != value.args:
            with graph.serving(value.serves):
                known[number] = _with_arguments(graph, value, args)
    return [known[number] for number in outputs]


def _with_arguments(graph: Graph, value: Value, args: tuple[int, ...]) -> int:
    if value.op in ARITHMETIC:
        return ARITHMETIC[value.op](graph, *args)
    if value.op in (Op.SIN, Op.COS):
        return expand_sine(graph, value.op, *args)
    if value.op is Op.POW and (exponent := graph.number(args[1])) is not None:
        return graph.power(args[0], exponent)
    if isinstance(value.literal, Lookup):
        return graph.lookup(value.literal.table, value.literal.order, *args)
    return graph.function(value.op, *args)


def expand_sine(graph: Graph, op: Op, angle: int) -> int:
    """sin or cos of an angle; of a sum with a constant angle by the addition theorems."""
    value = graph.values[angle]
    if value.op is Op.NEG:
        same = expand_sine(graph, op, value.args[0])
        return graph.neg(same) if op is Op.SIN else same
    if value.op not in (Op.ADD, Op.SUB) or graph.settled[angle]:
        return graph.function(op, angle)
    moving, fixed = value.args
    moving_sign, fixed_sign = 1, -1 if value.op is Op.SUB else 1
    if graph.settled[moving]:
        moving, fixed, moving_sign, fixed_sign = fixed, moving, fixed_sign, 1
    if not graph.settled[fixed]:
        return graph.function(op, angle)
    s, c = expand_sine(graph, Op.SIN, moving), expand_sine(graph, Op.COS, moving)
    fixed_s, fixed_c = graph.function(Op.SIN, fixed), graph.function(Op.COS, fixed)
    s = s if moving_sign > 0 else graph.neg(s)
    fixed_s = fixed_s if fixed_sign > 0 else graph.neg(fixed_s)
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
    Op.LESS: Graph.is_less,
    Op.SELECT: Graph.select,
}
