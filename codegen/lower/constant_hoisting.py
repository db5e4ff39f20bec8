"""Constant hoisting: values of parameters alone move into a kernel that runs once a run."""

from collections.abc import Sequence

import numpy as np

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
    settled = {k for k, known in enumerate(graph.settled) if known and graph.values[k].args}
    for kernel, numbers in zip(stepping, needed_by, strict=True) if settled else ():
        needed = settled.intersection(kernel.roots)
        for number in numbers:
            if number not in settled:
                needed.update(settled.intersection(graph.values[number].args))
        hoisted |= dict.fromkeys(sorted(needed))
    forces = _stiction_forces(graph, needed_by)
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


def _stiction_forces(graph: Graph, needed_by: list[list[int]]) -> list[int]:
    """The stiction forces and shares of modes that kernels take, in the order of their slots."""
    slots = {
        k: literal.slot
        for k in graph.moving_inputs
        if isinstance(literal := graph.values[k].literal, Input) and literal.array == "stiction"
    }
    taken = slots.keys() & set[int]().union(*needed_by) if slots else ()
    return sorted(taken, key=slots.__getitem__)


def orient_differences(
    graph: Graph, kernels: tuple[Kernel, ...]
) -> tuple[tuple[Value, ...], list[list[int]]]:
    """The graph's values, signs put into differences that nothing else needs; by kernel its own.

    In the graph a - b and b - a are one value and its opposite, so that what contains them is
    shared. Where only the opposite is left, the difference is written the other way round.
    """
    values = list(graph.values)
    takers, uses = _takers(values, kernels)
    oriented = list[int]()  # differences that are written the other way round
    for number, by in enumerate(takers):
        value = values[number]
        if value.op is Op.NEG and by:
            (inner,) = value.args
            if values[inner].op is Op.SUB and uses[inner] == 1:
                oriented.append(inner)
                values[number] = value._replace(op=Op.SUB, args=values[inner].args[::-1])
    for number in oriented:
        takers[number] = 0
    bits = np.array(takers, dtype=np.int64)
    needed_by = [np.flatnonzero(bits & (1 << at)).tolist() for at in range(len(kernels))]
    return tuple(values), needed_by


def _takers(values: Sequence[Value], kernels: tuple[Kernel, ...]) -> tuple[list[int], list[int]]:
    """Value → the kernels that compute it, as bits, and how often they take or store it."""
    takers, uses = [0] * len(values), [0] * len(values)
    for at, kernel in enumerate(kernels):
        for root in kernel.roots:
            takers[root] |= 1 << at
            uses[root] += 1
    for number in range(len(values) - 1, -1, -1):
        by = takers[number]
        if by:
            for a in values[number].args:
                takers[a] |= by
                uses[a] += 1
    return takers, uses
