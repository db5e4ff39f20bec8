"""Equilibrium: where the machine rests, whether it would stay there, and what its joints carry."""

import time as clock
from collections.abc import Mapping
from enum import StrEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from codegen.errors import AnalysisError
from runtime.analyses.assemble import assemble
from runtime.analyses.energy import Found, minimise, polish
from runtime.analyses.equations import Equations, FloatArray
from runtime.analyses.outputs import evaluate
from runtime.analyses.reduced import Rest
from runtime.analyses.settling import settle_down
from runtime.outcomes import Outcome
from runtime.progress import Progress, silent
from runtime.results.result import Result
from runtime.results.samples import Samples

if TYPE_CHECKING:
    from runtime.machine import Machine, Values

METHODS = ("energy", "settling")
_FLAT = 1e-8


class Stability(StrEnum):
    """What becomes of the machine after a small push."""

    STABLE = "stable"
    UNSTABLE = "unstable"
    INDIFFERENT = "indifferent"


class Equilibrium(Result):
    """A result of one instant: the rest position, with everything that a result has.

    Attributes
    ----------
    stability
        What becomes of the machine after a small push.
    frequencies
        Natural frequencies about the rest position in Hz, of the stable directions, ascending.
    stiffness
        Eigenvalues of the reduced stiffness relative to the reduced mass, in 1/s^2, ascending.
    gradient
        Largest unbalanced generalized force, as a share of the forces that act.
    """

    def __init__(
        self,
        machine: "Machine",
        samples: Samples,
        p: FloatArray,
        *,
        judged: "Judgement",
        gradient: float,
        outcome: Outcome,
        message: str,
        stats: Mapping[str, float],
    ) -> None:
        super().__init__(
            machine,
            samples,
            p,
            analysis="equilibrium",
            outcome=outcome,
            message=message,
            stats=stats,
        )
        self.stability = judged.stability
        self.stiffness = judged.stiffness
        self.frequencies = judged.frequencies
        self.gradient = gradient

    @property
    def stable(self) -> bool:
        """Whether the machine returns after a small push."""
        return self.stability is Stability.STABLE

    def __getitem__(self, name: str) -> float:
        """Value of a coordinate by name."""
        return float(self.q(name)[0])

    def about(self) -> dict[str, str]:
        """As of any result, and the stability."""
        return super().about() | {"stability": str(self.stability)}


class Judgement(NamedTuple):
    """Stability of a position and the numbers behind it."""

    stability: Stability
    stiffness: FloatArray
    frequencies: FloatArray


def equilibrium(
    machine: "Machine",
    method: str = "energy",
    *,
    guess: "Values | None" = None,
    parameters: "Values | None" = None,
    t: float = 0.0,
    progress: Progress = silent,
) -> Equilibrium:
    """Find a rest position near the start.

    Parameters
    ----------
    method
        "energy": minimum of the total potential energy. "settling": a damped motion until rest,
        which also finds the way from a start far off.
    guess
        Start values by name over those of the scene; positions that the scene fixes are free here.
    t
        Time in s at which drivers and forces are held.
    """
    began = clock.perf_counter()
    told = machine.description
    if method not in METHODS:
        raise AnalysisError(
            f"There is no equilibrium method {method!r}; there are: {', '.join(METHODS)}."
        )
    if not told.has_masses:
        raise AnalysisError(
            f"{told.title}: equilibrium needs forces on bodies with mass, and this scene has a "
            f"body without. Give every body a mass and an inertia."
        )
    start = assemble(machine, guess, parameters, t, release=True)
    if start.degrees_of_freedom == 0:
        drivers = f" (drivers: {', '.join(told.drivers)})" if told.drivers else ""
        raise AnalysisError(
            f"{told.title}: 0 degrees of freedom are left{drivers}, so there is nothing to "
            f"balance. Leave the drivers out of the scene, or ask for inverse dynamics."
        )
    p = machine.parameter_values(parameters)
    equations = Equations(machine, p)
    rest = Rest(equations, float(t), equations.scale(equations.size(t, start.q)))
    stats: dict[str, Any]
    if method == "settling":
        if np.abs(equations.velocity_rhs(t, start.q)).max(initial=0.0) > 0.0:
            raise AnalysisError(
                f"{told.title}: settling needs drivers at rest, and {', '.join(told.drivers)} "
                f'moves at t = {t:g} s. Use method="energy".'
            )
        settled = settle_down(rest, start.q, progress)
        found = polish(rest, settled.q) if np.isfinite(settled.q).all() else _nowhere(rest, start.q)
        stats = {"steps": settled.steps, "kinetic_energy_peaks": settled.peaks}
    else:
        found = minimise(rest, start.q, progress)
        stats = {"iterations": found.iterations}
    stats |= {"gradient_evaluations": rest.evaluations}
    judged = judge(rest, found)
    q = np.ascontiguousarray(found.q[None, :])
    samples = evaluate(
        machine,
        p,
        np.array([float(t)]),
        q,
        np.zeros_like(q),
        equations.rest_modes(t, found.q)[None, :],
    )
    stats["wall_seconds"] = clock.perf_counter() - began
    unbalanced = float(np.abs(found.gradient).max(initial=0.0)) / found.effort
    return Equilibrium(
        machine,
        samples,
        p,
        judged=judged,
        gradient=unbalanced,
        outcome=Outcome.OK if found.balanced else Outcome.UNBALANCED,
        message=_message(machine, found, judged, unbalanced),
        stats=stats,
    )


def _nowhere(rest: Rest, q: FloatArray) -> Found:
    """The start, where a search went off to infinity."""
    part = rest.partition(q)
    return Found(q, part, rest.gradient(q, part), max(rest.effort(q), 1e-300), 0)


def judge(rest: Rest, found: Found) -> Judgement:
    """Eigenvalues of M^-1 K over the independent coordinates; all positive means stable."""
    stiffness = rest.stiffness(found.q, found.part)
    root = np.linalg.cholesky(rest.inertia(found.q, found.part))
    matrix = np.linalg.solve(root, np.linalg.solve(root, stiffness).T).T
    asymmetry = float(np.abs(matrix - matrix.T).max(initial=0.0))
    largest = float(np.abs(matrix).max(initial=0.0))
    oscillates = False
    if asymmetry <= 1e-6 * largest:
        values = np.linalg.eigvalsh(0.5 * (matrix + matrix.T))
    else:
        pairs = np.linalg.eigvals(matrix)
        oscillates = bool(np.abs(pairs.imag).max() > 1e-6 * np.abs(pairs).max())
        values = np.sort(pairs.real)
    light = float(np.linalg.eigvalsh(root @ root.T).max())
    flat = max(_FLAT * largest, 1e-9 * found.effort / light)
    if oscillates or bool((values < -flat).any()):
        stability = Stability.UNSTABLE
    elif bool((values <= flat).any()):
        stability = Stability.INDIFFERENT
    else:
        stability = Stability.STABLE
    stiffnesses = np.array(values, dtype=np.float64)
    frequencies = np.sqrt(stiffnesses[stiffnesses > flat]) / (2.0 * np.pi)
    return Judgement(stability, stiffnesses, frequencies)


def _message(machine: "Machine", found: Found, judged: Judgement, unbalanced: float) -> str:
    """What the search found, in a sentence."""
    if not found.balanced:
        worst = int(found.part.independent[int(np.argmax(np.abs(found.gradient)))])
        name = machine.coordinates[worst].name
        return (
            f"No equilibrium found: after {found.iterations} iterations {unbalanced:.1e} of the "
            f"forces is unbalanced, most along {name} = {found.q[worst]:.6g}. Start from a guess "
            f'nearer to rest, try method="settling", or check that something holds the machine.'
        )
    notes = {
        Stability.STABLE: "Stable: it returns after a small push.",
        Stability.UNSTABLE: (
            "Unstable: the forces balance, but a small push drives it away. "
            'Start elsewhere, or use method="settling".'
        ),
        Stability.INDIFFERENT: "Indifferent: it stays where a small push leaves it.",
    }
    return f"{notes[judged.stability]} Unbalanced share of the forces {unbalanced:.1e}."
