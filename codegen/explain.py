"""The ledger: which part of a machine each operation of each kernel serves."""

from dataclasses import dataclass
from pathlib import Path

from codegen.derive.equations import derive
from codegen.driver import sound_scenes
from codegen.lower.kernels import lower
from codegen.lower.ledger import by_element
from codegen.modelfile import read_model

SHARED = {"factorization": "solution of M q̈ + Φ_qᵀ λ = Q", "correction": "recovery of q and q̇"}


@dataclass(frozen=True)
class Part:
    """An element of the scene, or work that all share, with its operations a kernel."""

    name: str
    kind: str
    operations: dict[str, int]


@dataclass(frozen=True)
class Ledger:
    """Operations of a scene by part and kernel; each operation stands in one part."""

    model: str
    scene: str
    kernels: tuple[str, ...]
    parts: tuple[Part, ...]
    totals: dict[str, int]
    left_out: tuple[tuple[str, str], ...]


def explain(model: str | Path, scene: str | None = None) -> tuple[Ledger, ...]:
    """Ledgers of one scene of a model, or of all.

    Raises
    ------
    InputError
        As `build` does.
    """
    declared = read_model(model).model
    ledgers = []
    for chosen in sound_scenes(declared, scene):
        equations = derive(declared, chosen)
        program = lower(equations).program
        counts = {k.name: by_element(program, k) for k in program.kernels}
        kinds = {c.name: c.kind for c in equations.constraints}
        kinds |= {e.name: e.kind for e in equations.effects}
        names = [*kinds, *sorted({name for c in counts.values() for name in c} - set(kinds))]
        parts = tuple(
            Part(
                name or "sums",
                kinds.get(name, SHARED.get(name, "shared")),
                {kernel: c[name] for kernel, c in counts.items() if c[name]},
            )
            for name in names
        )
        totals = {kernel: sum(c.values()) for kernel, c in counts.items()}
        ledgers.append(
            Ledger(
                equations.model,
                chosen.name,
                tuple(k for k in counts if totals[k]),
                parts,
                totals,
                equations.left_out,
            )
        )
    return tuple(ledgers)
