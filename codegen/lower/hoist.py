"""What parameters alone determine is moved out of the kernels, into one that runs once a run."""

from codegen.lower.graph import Graph
from codegen.lower.program import Kernel, Output, Program

WEAK_PIVOT = 1e-9
"""A pivot of S below this part of its diagonal is weak: two constraints agree to 3e-5 rad."""


def with_constants(graph: Graph, kernels: tuple[Kernel, ...], declared: int) -> Program:
    """The program with all that parameters alone determine moved into a kernel of its own.

    These values stand in ``p`` behind the declared parameters and are computed once a run.
    """
    bare = Program(tuple(graph.values), kernels, (), WEAK_PIVOT)
    hoisted: dict[int, None] = {}
    for kernel in kernels:
        numbers = bare.reachable(kernel)
        needed = {out.value for out in kernel.outputs}
        needed |= {v for check in kernel.checks for v in (check.pivot, check.reference)}
        for number in numbers:
            if not graph.settled[number]:
                needed |= set(graph.values[number].args)
        for number in sorted(needed):
            if graph.settled[number] and graph.values[number].args:
                hoisted[number] = None
    constants = tuple(hoisted)
    first = Kernel(
        "constants",
        "What follows from the parameters alone, into p behind them.",
        ("p",),
        tuple(Output("p", declared + k, number) for k, number in enumerate(constants)),
    )
    return Program(tuple(graph.values), (first, *kernels), constants, WEAK_PIVOT)
