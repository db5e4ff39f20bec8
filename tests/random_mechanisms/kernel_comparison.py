"""The generated kernels of a random mechanism, as Python runs them, against the dense equations."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.codegen.workbench import Interpreted, python_functions
from tests.random_mechanisms.dense_dynamics import Dense
from tests.random_mechanisms.generator import RandomMechanism


class Generated:
    """The text of a scene's module, run by Python itself."""

    def __init__(self, machine: RandomMechanism) -> None:
        self.module = python_functions(Interpreted(machine.model()).text())
        self.names = [row[0] for row in self.module["COORDINATES"]]
        self.rows = [row[:2] for row in self.module["CONSTRAINTS"]]
        self.p = np.zeros(len(self.module["CONSTANTS"]))
        self.call("constants", self.p)

    def call(self, kernel: str, *arguments: Any) -> Any:
        """Run a kernel, if the module has it."""
        with np.errstate(all="ignore"):
            return self.module[kernel](*arguments) if kernel in self.module else None


@dataclass(frozen=True)
class Difference:
    """The largest difference of each quantity, relative to the largest of its kind."""

    accelerations: float
    multipliers: float
    reactions: float
    residuals: float
    energies: float

    @property
    def worst(self) -> float:
        """The largest of all."""
        return max(self.__dict__.values())


def differences(
    machine: RandomMechanism, generated: Generated, dense: Dense, q: Any, v: Any, t: float
) -> Difference:
    """How far the two are apart at a state."""
    order = [dense.names.index(name) for name in generated.names]
    n, m = len(order), len(generated.rows)
    ours = dense.solve(q, v, t)
    e = dense.equations(q, v, t)
    a, lam, phi, gamma, nu = (np.zeros(k) for k in (n, m, m, m, m))
    state = t, q[order], v[order], generated.p
    modes = _modes(generated, state)
    generated.call("accelerations", *state, modes, a, lam)
    generated.call("constraints", t, q[order], generated.p, phi)
    generated.call("velocity_rhs", t, q[order], generated.p, nu)
    generated.call("acceleration_rhs", *state, gamma)
    reactions = np.zeros(len(generated.module["REACTIONS"]))
    generated.call("reactions", *state, lam, reactions)
    if "switched_reactions" in generated.module:
        generated.call("switched_reactions", *state, modes, lam, reactions)
    length, time = machine.scales.length, machine.scales.time
    sizes = dense.sizes[order]
    steep = np.array([np.max(np.abs(row.by_q) * dense.sizes) for row in e.rows])
    energy = machine.scales.mass * length**2 / time**2
    potential = generated.call("potential", t, q[order], generated.p, modes) or 0.0
    kinetic = generated.call("kinetic_energy", q[order], v[order], generated.p)
    moving = 0.5 * float(np.sum(dense.masses * v**2))
    return Difference(
        _apart(a / sizes, ours.a[order] / sizes, 1.0 / time**2),
        _apart(lam * steep, ours.lam * steep, energy),
        _reactions_apart(machine, generated, ours.reactions, reactions),
        max(
            _apart(phi / steep, e.phi / steep, 1.0),
            _apart(nu / steep, e.nu / steep, 1.0 / time),
            _apart(gamma / steep, e.gamma / steep, 1.0 / time**2),
        ),
        max(
            _apart(np.array([potential]), np.array([e.works.potential]), energy),
            _apart(np.array([kinetic]), np.array([moving]), energy),
        ),
    )


def _modes(generated: Generated, state: Any) -> Any:
    """Each switching function by its sign."""
    g = np.zeros(len(generated.module["SWITCHES"]))
    generated.call("switching", *state, g)
    return (g > 0).astype(int)


def _apart(one: Any, other: Any, least: float) -> float:
    """The largest difference, relative to the largest of the values, or to a typical size."""
    if not len(one):
        return 0.0
    size = max(float(np.max(np.abs(other))), least)
    apart = float(np.max(np.abs(one - other))) / size
    return apart if np.isfinite(apart) else np.inf


def _reactions_apart(
    machine: RandomMechanism, generated: Generated, ours: dict[tuple[str, str], float], theirs: Any
) -> float:
    """Forces beside forces, and torques beside torques over a typical length."""
    length = machine.scales.length
    rows = generated.module["REACTIONS"]
    scale = np.array([1.0 / length if row[2] == "N m" else 1.0 for row in rows])
    found = [ours.get((row[0], row[1])) for row in rows]
    known = [k for k, value in enumerate(found) if value is not None]
    force = machine.scales.mass * length / machine.scales.time**2
    mine = np.array([found[k] for k in known], dtype=float)
    return _apart(theirs[known] * scale[known], mine * scale[known], force)
