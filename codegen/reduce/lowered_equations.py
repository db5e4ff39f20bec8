"""The equations of a lowered scene as values of a graph that goes on from its program."""

from dataclasses import dataclass

from codegen.lower.graph import Graph
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.module_tables import Description
from codegen.lower.program import Input, Kernel


@dataclass(frozen=True)
class Stated:
    """What a scene states in all its coordinates.

    Attributes
    ----------
    t, q, v, a
        Inputs.
    kernels
        Kernels of the scene's program, by name.
    phi, nu, gamma, entries
        Φ, ν, γ, and the structural non-zeros of Φ_q by (row, column).
    mass, forces
        M by (row, column), the whole diagonal and what else is not zero; Q with Q_v.
    rubbing
        Whether friction follows from reactions, so that Q is not all that acts.
    """

    told: Description
    graph: Graph
    kernels: dict[str, Kernel]
    t: int
    q: list[int]
    v: list[int]
    a: list[int]
    phi: list[int]
    nu: list[int]
    gamma: list[int]
    entries: dict[tuple[int, int], int]
    mass: dict[tuple[int, int], int]
    forces: list[int]
    rubbing: bool

    def name(self, number: int) -> str:
        """Name of an input."""
        literal = self.graph.values[number].literal
        assert isinstance(literal, Input)
        return literal.name

    def row_names(self, rows: tuple[int, ...]) -> list[str]:
        """Names of constraints."""
        return [f"{self.told.constraints[i][0]}_{self.told.constraints[i][2]}" for i in rows]


def stated(lowered: Lowered) -> Stated:
    """Take the equations of motion out of a scene's program."""
    told, program = lowered.description, lowered.program
    graph = Graph.of(program.values)
    kernels = {kernel.name: kernel for kernel in program.kernels}

    def outputs(kernel: str, count: int) -> list[int]:
        values = [graph.zero] * count
        for out in kernels[kernel].outputs:
            values[out.slot] = out.value
        return values

    there = {
        (value.literal.array, value.literal.slot): number
        for number, value in enumerate(graph.values)
        if isinstance(value.literal, Input)
    }

    def inputs(array: str, named: list[str]) -> list[int]:
        return [
            there[array, k] if (array, k) in there else graph.input(array, k, name)
            for k, name in enumerate(named)
        ]

    n, m = len(told.coordinates), len(told.constraints)
    names = [name.replace(".", "_") for name, *_ in told.coordinates]
    rates = [rate.replace(".", "_") for _, rate, _ in told.coordinates]
    places = zip(told.jacobian.rows, told.jacobian.columns, strict=True)
    heavy = zip(told.mass.rows, told.mass.columns, strict=True)
    return Stated(
        told=told,
        graph=graph,
        kernels=kernels,
        t=graph.input("t", 0, "t"),
        q=inputs("q", names),
        v=inputs("v", rates),
        a=inputs("a", [f"{rate}_rate" for rate in rates]),
        phi=outputs("constraints", m),
        nu=outputs("velocity_rhs", m),
        gamma=outputs("acceleration_rhs", m),
        entries=dict(zip(places, outputs("jacobian", len(told.jacobian.rows)), strict=True)),
        mass=dict(zip(heavy, outputs("mass", len(told.mass.rows)), strict=True)),
        forces=outputs("applied_forces", n),
        rubbing=lowered.rubbing,
    )
