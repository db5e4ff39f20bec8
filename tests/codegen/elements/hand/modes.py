"""What the two modes of a friction or contact give, and what lies between them."""

from pathlib import Path

import numpy as np

from codegen.reading.model_file import read_model
from tests.codegen.workbench import Interpreted, State


def hard(root: Path, name: str, scene: str) -> Interpreted:
    """A scene of one of the library's hard machines."""
    return Interpreted(read_model(root / "models" / "hard" / f"{name}.py").model, scene)


def reported(
    machine: Interpreted, s: State, lam: np.ndarray, mode: int, force: float = 0.0
) -> dict[str, float]:
    """The rows of REACTIONS, of both kernels together; `force` is exerted in mode 2."""
    told = machine.lowered.description.reactions
    names = {k.name for k in machine.program.kernels}
    found = {}
    for kernel in {"reactions", "switched_reactions"} & names:
        slots = machine.slots(kernel, s, lam=lam, modes=[mode] * machine.s, stiction=[force])
        assert not set(slots) & set(found)
        found |= slots
    assert sorted(found) == list(range(len(told)))
    return {f"{told[k][0]}.{told[k][1]}": x for k, x in found.items()}


def mixed(machine: Interpreted, s: State, alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """q̈ and λ between the two modes."""
    zero, one = (machine.solution(s, modes=[mode] * machine.s) for mode in (0, 1))
    return tuple(x + alpha * (y - x) for x, y in zip(zero, one, strict=True))


def held(machine: Interpreted, s: State) -> float:
    """The α with which dg/dt = 0."""
    rates = []
    for mode in (0, 1):
        a, _ = machine.solution(s, modes=[mode] * machine.s)
        rates.append(machine.vector("switching_rates", s, a=a)[0])
    return rates[0] / (rates[0] - rates[1])
