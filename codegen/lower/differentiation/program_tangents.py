"""Tangents of a lowered program: forward-mode differentiation, value by value.

A tangent is the derivative of a value along one direction of the inputs. It obeys the chain rule
over the value's arguments, so one walk over the values in their order gives it for everything that
a kernel computes: the equations, the factorization, friction's steps. The tangents are values of
the same graph: equal ones are one, what the direction does not reach is a structural zero and
costs nothing, and what the kernel computes anyway is used again.

Derivatives are those of the operations (any calculus text; Griewank and Walther, Evaluating
Derivatives, chapter 3). A choice has the tangent of the branch that its mode selects; a table that
of its next derivative, and its third, constant between two knots, has none.

Powers whose exponent is not whole, and their derivatives where the base is zero.

b^(n + 1/2) is computed as bⁿ √b, which the rule of products would differentiate into 0/0 at b = 0.
The rule of powers does not: its exponents fall by one with every derivative, and only those that
become negative divide by b.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from codegen.lower.graph import ARITHMETIC, Graph
from codegen.lower.program import (
    LOGICAL,
    STATE,
    Input,
    Kernel,
    Lookup,
    Op,
    Program,
    Value,
    dependencies,
)

# safety: the smallest number there is, added to a divisor: 0/0 is 0 there, and all else infinite
LEAST = 5e-324


class FractionalPower(NamedTuple):
    """sign · base ^ exponent."""

    base: int
    exponent: float
    sign: float

    def slope(self, graph: Graph) -> int:
        """d/d(base) = sign · exponent · base ^ (exponent - 1)."""
        front = graph.constant(self.sign * self.exponent)
        return graph.mul(front, graph.power(self.base, self.exponent - 1.0))

    def bend(self, graph: Graph, rate: int) -> int:
        """d²/d(base)² · rate².

        With an exponent below 2 it is a quotient, which is 0 where base and rate both are, as at
        the origin in (x² + y²)^(3/2).
        """
        front = graph.constant(self.sign * self.exponent * (self.exponent - 1.0))
        square, left = graph.mul(rate, rate), self.exponent - 2.0
        if left > 0.0:
            return graph.mul(front, graph.mul(graph.power(self.base, left), square))
        divisor = graph.add(graph.power(self.base, -left), graph.constant(LEAST))
        return graph.mul(front, graph.div(square, divisor))


def fractional_power(graph: Graph, number: int) -> FractionalPower | None:
    """The power with a broken exponent above 1 that a value is; None for other values."""
    value = graph.values[number]
    if value.op is Op.POW:
        exponent = graph.number(value.args[1])
        known = exponent is not None and exponent > 1.0 and exponent != int(exponent)
        return FractionalPower(value.args[0], exponent, 1.0) if known and exponent else None
    if value.op is not Op.MUL:
        return None
    for whole, root in (value.args, value.args[::-1]):
        if graph.values[root].op is Op.SQRT:
            base = graph.values[root].args[0]
            bare = graph.unsigned(base)
            if count := _factors(graph, whole, bare):
                return FractionalPower(base, count + 0.5, 1.0 if base == bare else (-1.0) ** count)
    return None


def _factors(graph: Graph, number: int, base: int) -> int:
    """n where a value is baseⁿ, formed of products alone; 0 for other values."""
    if number == base:
        return 1
    value = graph.values[number]
    counts = [_factors(graph, a, base) for a in value.args] if value.op is Op.MUL else [0]
    return sum(counts) if all(counts) else 0


# safety: added under a root that divides: √(vᵀv) and (vᵀv)^0.3 have the slope 0 at v = 0, not 0/0
TINY = 1e-300


def differentiate(graph: Graph, outputs: Sequence[int], seeds: Mapping[int, int]) -> list[int]:
    """Tangents of `outputs`, by those of inputs in `seeds`; others have none."""
    known = tangents(graph, outputs, seeds)
    return [known.get(number, graph.zero) for number in outputs]


def tangents(graph: Graph, outputs: Sequence[int], seeds: Mapping[int, int]) -> dict[int, int]:
    """Value → its tangent, of all values that the outputs depend on along the seeds."""
    known = dict(seeds)
    for number in sorted(dependencies(graph.values, outputs, seeds) - seeds.keys()):
        value = graph.values[number]
        if value.args and value.op not in LOGICAL:
            with graph.serving(value.serves):
                known[number] = _tangent(graph, number, value, known)
    return known


def _tangent(graph: Graph, number: int, value: Value, known: Mapping[int, int]) -> int:
    parts = [known.get(a, graph.zero) for a in value.args]
    if all(part == graph.zero for part in parts):
        return graph.zero
    if (power := fractional_power(graph, number)) is not None:
        return graph.mul(power.slope(graph), known.get(power.base, graph.zero))
    match value.op:
        case Op.ADD | Op.SUB | Op.NEG:
            return ARITHMETIC[value.op](graph, *parts)
        case Op.SELECT:
            return graph.select(value.args[0], parts[1], parts[2])
        case Op.DIV:
            rest = graph.sub(parts[0], graph.mul(number, parts[1]))
            return graph.mul(graph.div(graph.one, value.args[1]), rest)
        case Op.POW if 0.0 < (graph.number(value.args[1]) or 0.0) < 1.0:
            base, exponent = value.args
            root = graph.div(number, graph.add(base, graph.constant(TINY)))
            return graph.mul(graph.mul(exponent, root), parts[0])
    terms = zip(slopes_of(graph, number), parts, strict=True)
    return graph.total([graph.mul(s, part) for s, part in terms if part != graph.zero])


def slopes_of(graph: Graph, number: int) -> tuple[int, ...]:
    """Derivatives of an operation by each of its arguments; zero by an exponent that is fixed."""
    value = graph.values[number]
    if isinstance(value.literal, Lookup):
        table, order = value.literal
        return (graph.lookup(table, order + 1, *value.args) if order < 3 else graph.zero,)
    return SLOPES[value.op](graph, number, *value.args)


def _reciprocal_root(graph: Graph, a: int) -> int:
    """1/√(1 - a²)."""
    return graph.power(graph.sub(graph.one, graph.mul(a, a)), -0.5)


def _atan2(graph: Graph, number: int, y: int, x: int) -> tuple[int, ...]:
    inverse = graph.div(graph.one, graph.add(graph.mul(x, x), graph.mul(y, y)))
    return graph.mul(inverse, x), graph.neg(graph.mul(inverse, y))


def _power(graph: Graph, number: int, a: int, b: int) -> tuple[int, ...]:
    """b aᵇ⁻¹, by products where b - 1 allows them, without a division by a = 0; and aᵇ log a."""
    exponent = graph.number(b)
    if exponent is not None:
        lower = graph.power(a, exponent - 1.0)
    else:
        lower = graph.function(Op.POW, a, graph.sub(b, graph.one))
    slope = graph.mul(b, lower)
    if graph.settled[b]:
        return slope, graph.zero
    return slope, graph.mul(number, graph.function(Op.LOG, a))


SLOPES: dict[Op, Callable[..., tuple[int, ...]]] = {
    Op.MUL: lambda g, n, a, b: (b, a),
    Op.SIN: lambda g, n, a: (g.function(Op.COS, a),),
    Op.COS: lambda g, n, a: (g.neg(g.function(Op.SIN, a)),),
    Op.TAN: lambda g, n, a: (g.add(g.one, g.mul(n, n)),),
    Op.ASIN: lambda g, n, a: (_reciprocal_root(g, a),),
    Op.ACOS: lambda g, n, a: (g.neg(_reciprocal_root(g, a)),),
    Op.ATAN: lambda g, n, a: (g.div(g.one, g.add(g.one, g.mul(a, a))),),
    Op.ATAN2: _atan2,
    Op.SINH: lambda g, n, a: (g.function(Op.COSH, a),),
    Op.COSH: lambda g, n, a: (g.function(Op.SINH, a),),
    Op.TANH: lambda g, n, a: (g.sub(g.one, g.mul(n, n)),),
    Op.EXP: lambda g, n, a: (n,),
    Op.LOG: lambda g, n, a: (g.div(g.one, a),),
    Op.SQRT: lambda g, n, a: (g.div(g.mul(g.constant(0.5), n), g.add(a, g.constant(TINY))),),
    Op.FLOOR: lambda g, n, a: (g.zero,),
    Op.POW: _power,
}
"""Derivatives of the operation n by its arguments a and b; those of a sum and a quotient are not
asked for.
"""


TANGENTS: dict[str, tuple[str, tuple[str, ...], dict[str, str], dict[str, str]]] = {
    "accelerations": (
        "(∂a/∂q) dq + (∂a/∂v) dv of a = accelerations(t, q, v, p, modes).",
        (*STATE, "modes", "dq", "dv", "da"),
        {"q": "dq", "v": "dv"},
        {"a": "da"},
    ),
    "correction": (
        "Derivatives of dq, dv of correction(t, q, v, p, w, dq, dv) along (dq_in, dv_in).",
        (*STATE, "w", "dq_in", "dv_in", "dq", "dv"),
        {"q": "dq_in", "v": "dv_in"},
        {"dq": "dq", "dv": "dv"},
    ),
}
"""Kernel → summary and arguments of its tangent, the direction along each input, new outputs."""


def tangent_program(program: Program) -> Program:
    """The kernels that differentiate `accelerations` and `correction` of a scene's program.

    They read ``p`` as the scene's own kernels do: what parameters alone determine keeps its slot.
    """
    graph = Graph.of(program.values)
    kernels = {kernel.name: kernel for kernel in program.kernels}
    differentiated = tuple(_tangent_kernel(graph, kernels[name]) for name in TANGENTS)
    return Program(tuple(graph.values), differentiated, program.constants, program.weak_pivot)


def _tangent_kernel(graph: Graph, kernel: Kernel) -> Kernel:
    """The kernel of derivatives of a kernel's outputs along directions (`TANGENTS`), named d_x."""
    summary, arguments, directions, arrays = TANGENTS[kernel.name]
    seeds = {}
    for number, value in enumerate(tuple(graph.values)):
        slot = value.literal
        if isinstance(slot, Input) and slot.array in directions:
            seeds[number] = graph.input(directions[slot.array], slot.slot, f"d_{slot.name}")
    outputs = [out for out in kernel.outputs if out.array in arrays]
    known = tangents(graph, [out.value for out in outputs], seeds)
    labels = (
        label._replace(value=known[label.value], name=f"d_{label.name}")
        for label in kernel.labels
        if label.value in known
    )
    named = (
        out._replace(array=arrays[out.array], value=known.get(out.value, graph.zero))
        for out in outputs
    )
    return Kernel(
        f"{kernel.name}_tangent",
        summary,
        arguments,
        tuple(named),
        labels=(*kernel.labels, *labels),
        steps=kernel.steps,
    )
