"""Constant hoisting: values of parameters alone move into a kernel that runs once a run."""

from collections import Counter
from itertools import chain

from codegen.lower.graph import Graph
from codegen.lower.program import Input, Kernel, Op, Output, Program, Value

WEAK_PIVOT = 1e-9
"""accuracy: a pivot of S below this part of its diagonal is weak: two constraints agree to 3e-5
rad.
"""


def with_constants(
    graph: Graph, kernels: tuple[Kernel, ...], declared: int, weak_pivot: float = WEAK_PIVOT
) -> Program:
    """The program with all values of parameters alone in a separate kernel.

    These values stand in ``p`` behind the declared parameters and are computed once a run. Before
    them stand the stiction forces and shares of modes, which a run sets as it goes.
    """
    # What is asked of parameters once a run is no constant of its steps.
    stepping = tuple(kernel for kernel in kernels if kernel.name != "conditions")
    values, needed_by = orient_differences(graph, stepping)
    hoisted: dict[int, None] = {}
    slots: dict[int, int] = {}
    settled = {k for k, value in enumerate(graph.values) if value.args and graph.settled[k]}
    for kernel, numbers in zip(stepping, needed_by, strict=True):
        needed = settled.intersection(kernel.roots)
        for number in numbers:
            value = graph.values[number]
            if not value.args:
                if isinstance(value.literal, Input) and value.literal.array == "stiction":
                    slots[number] = value.literal.slot
            elif settled and number not in settled:
                needed.update(settled.intersection(value.args))
        hoisted |= dict.fromkeys(sorted(needed))
    forces = sorted(slots, key=slots.__getitem__)
    declared += len(forces)
    first = Kernel(
        "constants",
        "Constants that depend on the parameters alone, stored in p behind them.",
        ("p",),
        tuple(Output("p", declared + k, number) for k, number in enumerate(hoisted)),
    )
    program = Program(values, (first, *kernels), (*forces, *hoisted), weak_pivot)
    for kernel, numbers in zip(stepping, needed_by, strict=True):
        if hoisted.keys().isdisjoint(numbers):  # else what they alone take is left out
            program.note_reachable(kernel, numbers)
    return program


def orient_differences(
    graph: Graph, kernels: tuple[Kernel, ...]
) -> tuple[tuple[Value, ...], list[list[int]]]:
    """The graph's values, signs put into differences that nothing else needs; by kernel its own.

    In the graph a - b and b - a are one value and its opposite, so that what contains them is
    shared. Where only the opposite is left, the difference is written the other way round.
    """
    values = list(graph.values)
    everything = Program(tuple(values), kernels, (), WEAK_PIVOT)
    needed_by = [everything.reachable(kernel) for kernel in kernels]
    reachable = set[int]().union(*needed_by)
    uses = Counter(chain.from_iterable(values[number].args for number in reachable))
    uses.update(root for kernel in kernels for root in kernel.roots)
    oriented = set[int]()  # differences that are written the other way round
    for number in sorted(reachable):
        value = values[number]
        if value.op is Op.NEG and values[value.args[0]].op is Op.SUB and uses[value.args[0]] == 1:
            oriented.add(value.args[0])
            values[number] = value._replace(op=Op.SUB, args=values[value.args[0]].args[::-1])
    return tuple(values), [[k for k in numbers if k not in oriented] for numbers in needed_by]
