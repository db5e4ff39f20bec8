"""Equilibrium: where the machine rests, whether it would stay there, and what its joints carry."""

import time as clock
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from codegen.errors import AnalysisError
from runtime.assembly.assemble import assemble
from runtime.assembly.redundant_kernels import sound, spared
from runtime.core.outcomes import Outcome
from runtime.dynamics.output_quantities import evaluate
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.description import Description
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.statics.energy_minimisation import Found, here, minimise, polish
from runtime.statics.reduced_gradient import Rest
from runtime.statics.stability import Judgement, Stability, judge
from runtime.validation.contacts import require_no_rigid, require_no_sticking
from runtime.validation.masses import require_masses
from runtime.validation.parameters import parameter_values

METHODS = ("energy", "settling")
_TURNED = 25.0  # safety: rad after which nothing holds a machine whose forces do not balance
_FAR = 1e6  # safety: scaled length after which nothing does


class Equilibrium(Result):
    """A result of one instant: the rest position, with everything that a result has.

    Attributes
    ----------
    stability
        What becomes of the machine after a small push.
    frequencies
        Natural frequencies about the rest position in Hz, of the stable directions, ascending;
        none where the stiffness is known on one side only.
    stiffness
        Eigenvalues of the reduced stiffness relative to the reduced mass, in 1/s^2, ascending;
        of complex ones the real part.
    gradient
        Largest unbalanced generalized force, as a share of the forces that act.
    """

    def __init__(
        self,
        description: Description,
        samples: Samples,
        p: FloatArray,
        *,
        judged: Judgement,
        gradient: float,
        outcome: Outcome,
        message: str,
        stats: Mapping[str, float],
        not_unique: Sequence[str] = (),
    ) -> None:
        super().__init__(
            description,
            samples,
            p,
            analysis="equilibrium",
            outcome=outcome,
            message=message,
            stats=stats,
            not_unique=not_unique,
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


def equilibrium(
    mechanism: Mechanism,
    method: str = "energy",
    *,
    guess: Values | None = None,
    parameters: Values | None = None,
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
    description = mechanism.description
    if method not in METHODS:
        raise AnalysisError(
            f"There is no equilibrium method {method!r}; there are: {', '.join(METHODS)}."
        )
    if not description.has_masses:
        raise AnalysisError(
            f"{mechanism.title}: equilibrium needs forces on bodies with mass, and this scene has "
            f"a body without. Give every body a mass and an inertia."
        )
    require_no_rigid(mechanism, "equilibrium")
    require_no_sticking(mechanism, "equilibrium")
    p = parameter_values(mechanism, parameters)
    require_masses(mechanism, p)
    start = assemble(mechanism, guess, parameters, t, release=True)
    if start.degrees_of_freedom == 0:
        drivers = f" (drivers: {', '.join(description.drivers)})" if description.drivers else ""
        raise AnalysisError(
            f"{description.title}: 0 degrees of freedom are left{drivers}, so there is nothing to "
            f"balance. Leave the drivers out of the scene, or ask for inverse dynamics."
        )
    mechanism = sound(mechanism, start)
    equations = Equations(mechanism, p)
    _require_finite(equations, float(t), start.q)
    rest = Rest(equations, float(t), equations.scale(equations.size(t, start.q)))
    stats: dict[str, Any]
    if method == "settling":
        if np.abs(equations.velocity_rhs(t, start.q)).max(initial=0.0) > 0.0:
            raise AnalysisError(
                f"{mechanism.title}: settling needs drivers at rest, and "
                f"{', '.join(description.drivers)} "
                f'moves at t = {t:g} s. Use method="energy".'
            )
        from runtime.statics.kinetic_damping import settle_down  # compiles where it is used

        settled = settle_down(rest, start.q, progress)
        stats = {"steps": settled.steps, "kinetic_energy_peaks": settled.peaks}
        known = np.isfinite(settled.q).all()
        found = polish(rest, settled.q) if known else here(rest, start.q)
        ran = _ran(mechanism, rest, start.q, settled.q)
    else:
        found = minimise(rest, start.q, progress)
        stats = {"iterations": found.iterations}
        ran = _ran(mechanism, rest, start.q, found.q)
    if found.balanced:
        ran = []
    if ran:
        found = here(rest, start.q, found.iterations)
    stats |= {"gradient_evaluations": rest.evaluations}
    judged = judge(rest, found)
    q = np.ascontiguousarray(found.q[None, :])
    samples = evaluate(
        mechanism,
        p,
        np.array([float(t)]),
        q,
        np.zeros_like(q),
        equations.rest_modes(t, found.q)[None, :],
    )
    stats["wall_seconds"] = clock.perf_counter() - began
    return Equilibrium(
        description,
        samples,
        p,
        judged=judged,
        gradient=found.unbalanced,
        outcome=Outcome.OK if found.balanced else Outcome.UNBALANCED,
        message=_message(mechanism, found, judged, ran) + spared(start),
        stats=stats,
        not_unique=start.not_unique,
    )


def _ran(mechanism: Mechanism, rest: Rest, start: FloatArray, end: FloatArray) -> list[str]:
    """Coordinates that went so far from the start that nothing can be holding them."""
    moved = np.abs((end - start) / rest.scale)
    moved[~np.isfinite(moved)] = np.inf
    turned = mechanism.description.is_angle & (moved > _TURNED)
    far = (turned | (moved > _FAR)) & (moved >= 1e-3 * moved.max())
    return [mechanism.description.coordinates[int(index)].name for index in np.flatnonzero(far)]


def _edges(mechanism: Mechanism, found: Found) -> str:
    """The conditions at whose boundary a position lies."""
    switches = mechanism.description.switches
    return ", ".join(
        f"{switches[k].condition} of {switches[k].name}" for k in found.stiffness.edges
    )


def _message(mechanism: Mechanism, found: Found, judged: Judgement, ran: list[str]) -> str:
    """What the search found, in a sentence."""
    edges = _edges(mechanism, found)
    if ran:
        return (
            f"No equilibrium found: nothing holds the machine in {', '.join(ran)}, which ran away "
            f"without end; the position given is the start. Hold it by a joint, a driver or a "
            f"spring, or start from a guess nearer to rest."
        )
    if not found.balanced:
        shares = np.abs(found.gradient) / found.effort
        worst = int(found.part.independent[int(np.argmax(shares))])
        name = mechanism.description.coordinates[worst].name
        if edges:
            return (
                f"No equilibrium found: the search ended at {name} = {found.q[worst]:.6g} on the "
                f"boundary of {edges}, where the forces jump; on neither side of it they balance. "
                f"If the machine is meant to stand there, hold it by a constraint, or let the "
                f"force rise over a short distance."
            )
        return (
            f"No equilibrium found: after {found.iterations} iterations {found.unbalanced:.1e} of "
            f"the forces is unbalanced, most along {name} = {found.q[worst]:.6g}. Start from a "
            f'guess nearer to rest, try method="settling", or check that something holds the '
            f"machine."
        )
    notes = {
        Stability.STABLE: "Stable: it returns after a small push.",
        Stability.UNSTABLE: (
            "Unstable: the forces balance, but a small push drives it away"
            f"{', in oscillations that grow (flutter)' if judged.flutter else ''}. "
            'Start elsewhere, or use method="settling".'
        ),
        Stability.INDIFFERENT: "Indifferent: it stays where a small push leaves it.",
        Stability.UNKNOWN: (
            f"Stability unknown: the forces balance on the boundary of {edges}, so the stiffness "
            f"is that of one side only."
        ),
    }
    return f"{notes[judged.stability]} Unbalanced share of the forces {found.unbalanced:.1e}."


def _require_finite(equations: Equations, t: float, q: FloatArray) -> None:
    """Refuse a start where forces have no value."""
    modes, still = equations.rest_modes(t, q), np.zeros(len(q))
    force = equations.forces(t, q, still, modes) + equations.potential_gradient(t, q, modes)
    if np.isfinite(force).all():
        return
    description = equations.description
    lost = [
        row.name
        for row, f in zip(description.coordinates, force, strict=True)
        if not np.isfinite(f)
    ]
    effects = ", ".join(row.name for row in description.effects) or "none"
    raise AnalysisError(
        f"{description.title}: at the start position the forces along {', '.join(lost)} are not "
        f"finite (effects: {effects}). Look for a spring whose ends coincide, a division by zero "
        "or a table asked beyond its ends, and start elsewhere: give guess= or a guess in the "
        "scene."
    )
