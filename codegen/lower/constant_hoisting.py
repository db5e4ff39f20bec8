"""What parameters alone determine is moved out of the kernels, into one that runs once a run."""

from collections import Counter
from dataclasses import replace

from codegen.lower.graph import Graph
from codegen.lower.program import Input, Kernel, Op, Output, Program, Value

WEAK_PIVOT = 1e-9
"""accuracy: a pivot of S below this part of its diagonal is weak: two constraints agree to 3e-5
rad.
"""


def with_constants(graph: Graph, kernels: tuple[Kernel, ...], declared: int) -> Program:
    """The program with all that parameters alone determine moved into a kernel of its own.

    These values stand in ``p`` behind the declared parameters and are computed once a run. Before
    them stand the forces of what is held, which a run sets as it goes.
    """
    bare = Program(turned_about(graph, kernels), kernels, (), WEAK_PIVOT)
    hoisted: dict[int, None] = {}
    inputs: set[int] = set()
    for kernel in kernels:
        numbers = bare.reachable(kernel)
        inputs |= {number for number in numbers if _is_given(graph, number)}
        needed = {out.value for out in kernel.outputs}
        needed |= {v for check in kernel.checks for v in (check.pivot, check.reference)}
        for number in numbers:
            if not graph.settled[number]:
                needed |= set(graph.values[number].args)
        for number in sorted(needed):
            if graph.settled[number] and graph.values[number].args:
                hoisted[number] = None
    forces = tuple(sorted(inputs, key=lambda number: graph.values[number].literal.slot))  # type: ignore[union-attr]
    declared += len(forces)
    first = Kernel(
        "constants",
        "Constants that depend on the parameters alone, stored in p behind them.",
        ("p",),
        tuple(Output("p", declared + k, number) for k, number in enumerate(hoisted)),
    )
    return Program(bare.values, (first, *kernels), (*forces, *hoisted), WEAK_PIVOT)


def turned_about(graph: Graph, kernels: tuple[Kernel, ...]) -> tuple[Value, ...]:
    """The graph's values, signs put into differences that nothing else needs.

    In the graph a - b and b - a are one value and its opposite, so that what contains them is
    shared. Where only the opposite is left, the difference is written the other way round.
    """
    values = list(graph.values)
    everything = Program(tuple(values), kernels, (), WEAK_PIVOT)
    reached = {number for kernel in kernels for number in everything.reachable(kernel)}
    uses = Counter(a for number in reached for a in values[number].args)
    for kernel in kernels:
        uses.update(out.value for out in kernel.outputs)
        uses.update(v for check in kernel.checks for v in (check.pivot, check.reference))
    for number in sorted(reached):
        value = values[number]
        if value.op is Op.NEG and values[value.args[0]].op is Op.SUB and uses[value.args[0]] == 1:
            values[number] = replace(value, op=Op.SUB, args=values[value.args[0]].args[::-1])
    return tuple(values)


def _is_given(graph: Graph, number: int) -> bool:
    literal = graph.values[number].literal
    return isinstance(literal, Input) and literal.array == "held"
