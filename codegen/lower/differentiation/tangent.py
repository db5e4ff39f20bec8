"""Tangents of a lowered program: forward-mode differentiation, value by value.

A tangent is the derivative of a value along one direction of the inputs. It obeys the chain rule
over the value's arguments, so one walk over the values in their order gives it for everything that
a kernel computes: the equations, the factorization, friction's steps. The tangents are values of
the same graph: equal ones are one, what the direction does not reach is a structural zero and
costs nothing, and what the kernel computes anyway is used again.

Derivatives are those of the operations (any calculus text; Griewank and Walther, Evaluating
Derivatives, chapter 3). A choice has the tangent of the branch that its mode selects; a table that
of its next derivative, and its third, constant between two knots, has none.
"""

from collections.abc import Callable, Mapping, Sequence

from codegen.lower.graph import Graph
from codegen.lower.program import (
    LOGICAL,
    STATE,
    Input,
    Kernel,
    Lookup,
    Op,
    Program,
    Value,
)
from codegen.lower.substitution import dependencies

TINY = 1e-300
"""safety: added under a root where the root divides: √(vᵀv) has the slope 0 at v = 0, not 0/0."""

SPLINE_DEGREE = 3
"""The derivative of a table from which on there is no further one."""

Slopes = Callable[[Graph, int, Value], tuple[int, ...]]
"""(graph, number of the value, value) → its derivative by each argument, as values."""


def differentiate(graph: Graph, outputs: Sequence[int], seeds: Mapping[int, int]) -> list[int]:
    """Tangents of `outputs`, as values of `graph`.

    Parameters
    ----------
    graph
        Holds the outputs and receives their tangents.
    outputs
        Numbers of values.
    seeds
        Input → the value that is its tangent; the tangents of other inputs are zero.
    """
    known = tangents(graph, outputs, seeds)
    return [known.get(number, graph.zero) for number in outputs]


def tangents(graph: Graph, outputs: Sequence[int], seeds: Mapping[int, int]) -> dict[int, int]:
    """Value → its tangent, of all values that the outputs depend on along the seeds."""
    known = dict(seeds)
    for number in _reached(graph, outputs, seeds):
        value = graph.values[number]
        with graph.serving(value.serves):
            known[number] = _tangent(graph, number, value, known)
    return known


def _reached(graph: Graph, outputs: Sequence[int], seeds: Mapping[int, int]) -> list[int]:
    """Values that the outputs depend on, in order, without seeds, leaves and conditions."""
    needed = dependencies(graph, outputs, seeds) - seeds.keys()
    return sorted(k for k in needed if graph.values[k].args and graph.values[k].op not in LOGICAL)


def _tangent(graph: Graph, number: int, value: Value, known: Mapping[int, int]) -> int:
    parts = [known.get(a, graph.zero) for a in value.args]
    if all(part == graph.zero for part in parts):
        return graph.zero
    match value.op:
        case Op.ADD:
            return graph.add(*parts)
        case Op.SUB:
            return graph.sub(*parts)
        case Op.NEG:
            return graph.neg(parts[0])
        case Op.SELECT:
            return graph.select(value.args[0], parts[1], parts[2])
        case Op.DIV:
            rest = graph.sub(parts[0], graph.mul(number, parts[1]))
            return graph.mul(graph.div(graph.one, value.args[1]), rest)
    terms = zip(slopes_of(graph, number), parts, strict=True)
    return graph.total([graph.mul(s, part) for s, part in terms if part != graph.zero])


def slopes_of(graph: Graph, number: int) -> tuple[int, ...]:
    """Derivatives of an operation by each of its arguments; zero by an exponent that is fixed."""
    value = graph.values[number]
    if value.op is Op.POW and graph.settled[value.args[1]]:
        return _power_slope(graph, value), graph.zero
    return SLOPES[value.op](graph, number, value)


def _product(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    a, b = value.args
    return b, a


def _tan(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    return (graph.add(graph.one, graph.mul(number, number)),)


def _tanh(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    return (graph.sub(graph.one, graph.mul(number, number)),)


def _asin(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    (a,) = value.args
    return (graph.power(graph.sub(graph.one, graph.mul(a, a)), -0.5),)


def _acos(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    return (graph.neg(*_asin(graph, number, value)),)


def _atan(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    (a,) = value.args
    return (graph.div(graph.one, graph.add(graph.one, graph.mul(a, a))),)


def _atan2(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    y, x = value.args
    square = graph.add(graph.mul(x, x), graph.mul(y, y))
    inverse = graph.div(graph.one, square)
    return graph.mul(inverse, x), graph.neg(graph.mul(inverse, y))


def _log(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    return (graph.div(graph.one, value.args[0]),)


def _sqrt(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    guarded = graph.add(value.args[0], graph.constant(TINY))
    return (graph.div(graph.mul(graph.constant(0.5), number), guarded),)


def _power_slope(graph: Graph, value: Value) -> int:
    """∂(aᵇ)/∂a = b aᵇ⁻¹, by products where b - 1 allows them; without a division by a = 0."""
    a, b = value.args
    exponent = graph.number(b)
    if exponent is not None:
        return graph.mul(b, graph.power(a, exponent - 1.0))
    return graph.mul(b, graph.function(Op.POW, a, graph.sub(b, graph.one)))


def _power(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    growth = graph.mul(number, graph.function(Op.LOG, value.args[0]))
    return _power_slope(graph, value), growth


def _lookup(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
    look = value.literal
    assert isinstance(look, Lookup)
    if look.order >= SPLINE_DEGREE:
        return (graph.zero,)
    return (graph.lookup(look.table, look.order + 1, value.args[0]),)


def _counterpart(op: Op, sign: int = 1) -> Slopes:
    def slopes(graph: Graph, number: int, value: Value) -> tuple[int, ...]:
        other = graph.function(op, *value.args)
        return (other if sign > 0 else graph.neg(other),)

    return slopes


SLOPES: dict[Op, Slopes] = {
    Op.MUL: _product,
    Op.SIN: _counterpart(Op.COS),
    Op.COS: _counterpart(Op.SIN, -1),
    Op.TAN: _tan,
    Op.ASIN: _asin,
    Op.ACOS: _acos,
    Op.ATAN: _atan,
    Op.ATAN2: _atan2,
    Op.SINH: _counterpart(Op.COSH),
    Op.COSH: _counterpart(Op.SINH),
    Op.TANH: _tanh,
    Op.EXP: lambda graph, number, value: (number,),
    Op.LOG: _log,
    Op.SQRT: _sqrt,
    Op.POW: _power,
    Op.TABLE: _lookup,
}


def tangent_program(program: Program) -> Program:
    """The kernels that differentiate `accelerations` and `correction` of a scene's program.

    They read ``p`` as the scene's own kernels do: what parameters alone determine keeps its slot.
    """
    graph = Graph.of(program.values)
    kernels = {kernel.name: kernel for kernel in program.kernels}
    accelerations, correction = kernels["accelerations"], kernels["correction"]
    kernel_tangents = (
        _along(
            graph,
            accelerations,
            "(∂a/∂q) dq + (∂a/∂v) dv of a = accelerations(t, q, v, p, modes).",
            (*STATE, "modes", "dq", "dv", "da"),
            {"q": "dq", "v": "dv"},
            {"a": "da"},
        ),
        _along(
            graph,
            correction,
            "Derivatives of dq, dv of correction(t, q, v, p, w, dq, dv) along (dq_in, dv_in).",
            (*STATE, "w", "dq_in", "dv_in", "dq", "dv"),
            {"q": "dq_in", "v": "dv_in"},
            {"dq": "dq", "dv": "dv"},
        ),
    )
    return Program(tuple(graph.values), kernel_tangents, program.constants, program.weak_pivot)


def _along(
    graph: Graph,
    kernel: Kernel,
    summary: str,
    arguments: tuple[str, ...],
    directions: Mapping[str, str],
    arrays: Mapping[str, str],
) -> Kernel:
    """Tangents of the outputs that `arrays` renames, along inputs that `directions` names.

    A tangent has the name of its value with ``d_`` before it, and stands in the same step.
    """
    inputs = {n: v.literal for n, v in enumerate(graph.values) if isinstance(v.literal, Input)}
    seeds = {
        number: graph.input(directions[slot.array], slot.slot, f"d_{slot.name}")
        for number, slot in inputs.items()
        if slot.array in directions
    }
    outputs = [out for out in kernel.outputs if out.array in arrays]
    known = tangents(graph, [out.value for out in outputs], seeds)
    labels = (
        label._replace(value=known[label.value], name=f"d_{label.name}")
        for label in kernel.labels
        if label.value in known
    )
    return Kernel(
        f"{kernel.name}_tangent",
        summary,
        arguments,
        tuple(
            out._replace(array=arrays[out.array], value=known.get(out.value, graph.zero))
            for out in outputs
        ),
        labels=(*kernel.labels, *labels),
        steps=kernel.steps,
    )
