"""Equilibrium: a rest position, its stability, and the reactions there."""

import time as clock
from typing import Any

import numpy as np

from codegen.errors import AnalysisError
from codegen.readers.calls import checked_class
from runtime.assembly.assemble import assemble
from runtime.assembly.far_starts import TURNED
from runtime.assembly.mirrored_joints import mirror_note
from runtime.assembly.redundancy import redundancy_note, suited_equations
from runtime.core.outcomes import Outcome
from runtime.dynamics.checks.finite_results import end_before_infinite
from runtime.dynamics.checks.kinks import kink_at_rest
from runtime.dynamics.output_quantities import evaluate
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Numbers
from runtime.mechanism.module_tables import Description
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result
from runtime.results.samples import plain
from runtime.statics.energy_minimisation import RestPosition, StaticEquations, minimise, polish
from runtime.statics.rest_stability import Judgement, Stability, judge
from runtime.statics.states_at_rest import StatesAtRest, find_rest, free_states, require_expressions
from runtime.validation.arguments import parameter_values, require_masses
from runtime.validation.finite_equations import left_tables, name_left_tables
from runtime.validation.scene_support import require_no_rigid, require_no_sticking

METHODS = "energy", "settling"
_TURNED = 25.0  # safety: rad after which nothing holds a machine whose forces do not balance
_FAR = 1e6  # safety: scaled length after which nothing does
_LATER = (0.123, 1.37, 17.3, 1e3)  # safety: s; where forces that depend on t are others
_ELSEWHERE = (
    "Give the table points further out, beyond=, or another start: guess=, or a guess in the scene."
)


@checked_class
class Equilibrium(Result):
    """A result of one instant: the rest position, with everything that a result has.

    Attributes
    ----------
    stability
        Whether the machine returns after a small push; unknown if the forces do not balance.
    frequencies
        Natural frequencies about the rest position in Hz, of the stable directions, ascending; none
        if the stiffness is known on one side only. `natural_frequencies` are the same in rad/s.
    eigenvalues
        Those of M⁻¹ K, the squared natural frequencies ω², in 1/s^2, ascending; of complex ones the
        real part. A negative one means that the machine moves away in its direction. With states
        they are nan, since their stability is not judged.
    stiffness_matrix
        K, the reduced stiffness, in the coordinates `independent`: the change of the force along
        one of them for a unit change of another, while joints and states are kept. Shape (f, f), in
        N/m, N or N m/rad.
    independent
        Names of these coordinates.
    gradient
        Largest unbalanced generalized force, as a share of the forces that act.
    """

    stability: Stability
    frequencies: FloatArray
    natural_frequencies: FloatArray
    eigenvalues: FloatArray
    stiffness_matrix: FloatArray
    independent: tuple[str, ...]
    gradient: float

    def __init__(
        self, *samples: Any, judged: Judgement, statics: StaticEquations, position: RestPosition,
        **outcome: Any,
    ) -> None:  # fmt: skip
        super().__init__(*samples, analysis="equilibrium", **outcome)
        self.stability, self.gradient = judged.stability, position.unbalanced
        self.eigenvalues, self.natural_frequencies = judged.eigenvalues, judged.frequencies
        self.frequencies = judged.frequencies / (2.0 * np.pi)
        columns, names = position.part.independent, self.description.coordinates.names
        scale = statics.scale[columns]
        self.stiffness_matrix = position.stiffness / np.outer(scale, scale)
        self.independent = tuple(names[k] for k in columns)

    @property
    def stable(self) -> bool:
        """Whether the machine returns after a small push."""
        return self.stability is Stability.STABLE

    def __repr__(self) -> str:
        """As of any result, and the stability."""
        found = ", ".join(f"{f:.6g}" for f in self.frequencies)
        tail = f"; natural frequencies {found} Hz" if found else ""
        return f"{super().__repr__()}\n  equilibrium  {self.stability}{tail}"

    def __getitem__(self, name: str) -> float:  # type: ignore[override]
        """A number in SI units, that of a series by name; methods return arrays of one value."""
        return float(self.series(name)[0][0])

    def facts(self) -> dict[str, Any]:
        """As of any result, and the stability."""
        frequencies = plain(list(self.frequencies))
        return super().facts() | {"stability": str(self.stability), "frequencies": frequencies}


def equilibrium(
    mechanism: Mechanism, method: str = "energy", *, guess: Numbers | None = None,
    parameters: Numbers | None = None, t: float = 0.0, progress: Progress = silent,
) -> Equilibrium:  # fmt: skip
    """Find a rest position near the start; see `Machine.equilibrium`."""
    began = clock.perf_counter()
    description = mechanism.description
    if method not in METHODS:
        raise AnalysisError(
            f"There is no equilibrium method {method!r}; there are: {', '.join(METHODS)}."
        )
    if not description.has_masses:
        raise AnalysisError(description.need_masses("equilibrium"))
    require_no_rigid(mechanism, "equilibrium")
    require_no_sticking(mechanism, "equilibrium")
    p = parameter_values(mechanism, parameters)
    require_masses(mechanism, p)
    require_expressions(description)
    equations = Equations(mechanism, p)
    start = assemble(equations, t, guess, release=True)
    with_states = bool(free_states(description))
    if start.degrees_of_freedom == 0 and not with_states:
        extra = ", ".join(description.drivers) or "a joint (without=[...])"
        raise AnalysisError(
            f"{description.title}: 0 degrees of freedom are left, so there is nothing to balance. "
            f"Leave {extra} out of the scene, or ask for inverse dynamics."
        )
    equations = suited_equations(equations, start)
    columns = [state.column for state in description.states]
    equations.still[columns] = start.v[columns]
    _require_finite(equations, float(t), start.q)
    statics = StaticEquations(equations, float(t), equations.scale(equations.size(t, start.q)))
    equations.widen_bands(float(t), start.q, statics.scale)
    position, end, stats = _search(method, statics, start.q, progress)
    states = None
    if with_states:
        position, states = _with_states(statics, position, start.q)
        end = position.q
    ran = [] if position.balanced else _runaways(statics, start.q, end)
    if ran:
        position = statics.position(start.q, position.iterations)
    stats["gradient_evaluations"] = statics.evaluations
    if states is None and position.balanced:
        judged = judge(statics, position)
    else:  # with states M, C and K alone do not determine the motion after a push
        judged = Judgement(Stability.UNKNOWN, np.full(len(position.gradient), np.nan))
    modes = equations.rest_modes(t, position.q)[None, :]
    v = equations.at_rest(float(t), position.q)[None].copy()
    samples = evaluate(equations, np.array([float(t)]), position.q[None], v, modes)
    stats["wall_seconds"] = clock.perf_counter() - began
    at_rest = states is None or states.balanced
    if states is not None and position.balanced:
        message = _states_message(equations, states, position)
    else:
        kink = "" if position.balanced else kink_at_rest(equations, start, end)
        text = f"No equilibrium found. {kink}"
        message = text if kink else _message(description, method, position, judged, ran)
    moved = zip(description.coordinates, np.abs(position.q - start.q), strict=True)
    turns = ((turn, row.name.rpartition(".")[0]) for row, turn in moved if row.is_angle)
    turn = max(turns, default=(0.0, ""))
    if turn[0] > TURNED and method == "energy":
        message += f" {turn[1]} turned by {np.degrees(turn[0]):.0f}° from its guess; another rest "
        message += 'may be nearer: method="settling".'
    if mirrored := mirror_note(description, position.q):
        message += f" {mirrored}"
    message += _time_note(statics, position.q)
    result = Equilibrium(
        description, samples, p, judged=judged, statics=statics, position=position,
        outcome=Outcome.OK if position.balanced and at_rest else Outcome.UNBALANCED,
        message=message + redundancy_note(start), stats=stats, not_unique=start.not_unique,
    )  # fmt: skip
    result._mechanism = equations.whole.mechanism
    end_before_infinite(result, equations)
    name_left_tables(result, equations)
    return result


def _search(
    method: str, statics: StaticEquations, start: FloatArray, progress: Progress
) -> tuple[RestPosition, FloatArray, dict[str, Any]]:
    """The rest position, the end of the search or of the damped motion, and counts."""
    if method == "energy":
        position = minimise(statics, start, progress)
        return position, position.q, {"iterations": position.iterations}
    description = statics.equations.description
    if description.states:
        raise AnalysisError(
            f"{description.title}: settling moves positions alone, and the scene has the states "
            f'{", ".join(description.states.names)}. Use method="energy".'
        )
    if np.abs(statics.equations.velocity_rhs(statics.t, start)).max(initial=0.0) > 0.0:
        raise AnalysisError(
            f"{description.title}: settling needs drivers at rest, and "
            f"{', '.join(description.drivers) or 'a law of time'} moves at t = {statics.t:g} s. "
            'Use method="energy".'
        )
    from runtime.statics.kinetic_damping import settle_down  # compiles where it is used

    end, counts = settle_down(statics, start, progress)
    finite = np.isfinite(end).all()
    if not finite and description.table_ranges:  # it left one; a search ends where that does
        position = minimise(statics, start, progress)
        return position, position.q, counts
    return polish(statics, end) if finite else statics.position(start), end, counts


def _with_states(
    statics: StaticEquations, position: RestPosition, start: FloatArray
) -> tuple[RestPosition, StatesAtRest]:
    """Rest of positions and states, from the rest with the states at their start values."""
    begun, still = position.q if position.balanced else start, statics.equations.still
    first = still.copy()
    states = find_rest(statics, begun)
    if not states.balanced and begun is not start:
        still[:] = first
        states = find_rest(statics, start)
    return statics.position(states.q, position.iterations), states


def _time_note(statics: StaticEquations, q: FloatArray) -> str:
    """A sentence where forces depend on t; empty otherwise."""
    equations, t = statics.equations, statics.t
    state = q, equations.at_rest(t, q), equations.rest_modes(t, q)
    if len({equations.forces(t + later, *state).tobytes() for later in (0.0, *_LATER)}) == 1:
        return ""
    return f" Forces depend on t, and are those of t = {t:g} s; give t= for another instant."


def _states_message(equations: Equations, states: StatesAtRest, position: RestPosition) -> str:
    """The outcome of the search for positions and states whose forces balance, in a sentence."""
    rows = equations.description.states
    values = ", ".join(
        f"{row.name} = {equations.still[row.column]:.6g} {row.unit}".rstrip() for row in rows
    )
    if states.balanced:
        return (
            f"At rest with {values}. Whether it returns after a small push is not judged where "
            f"states take part. Unbalanced share of the forces {position.unbalanced:.1e}."
        )
    worst = max(states.unbalanced, key=lambda name: states.unbalanced[name])
    return (
        f"No equilibrium found: the search ended with {values}, where the rate of {worst}, or what "
        f"a sample would change it by, is not zero (unbalanced share "
        f"{states.unbalanced[worst]:.1e}). Give other values to begin with, guess=, or check that "
        "something brings it to rest."
    )


def _runaways(statics: StaticEquations, start: FloatArray, end: FloatArray) -> list[str]:
    """Coordinates so far from the start that no force can be restoring them."""
    coordinates = statics.equations.description.coordinates
    moved = np.abs((end - start) / statics.scale)
    moved[~np.isfinite(moved)] = np.inf
    bounds = [_TURNED if row.is_angle else _FAR for row in coordinates]
    far = (moved > bounds) & (moved >= 1e-3 * moved.max())
    return [coordinates[int(index)].name for index in np.flatnonzero(far)]


def _message(
    description: Description, method: str, position: RestPosition, judged: Judgement,
    ran: list[str],
) -> str:  # fmt: skip
    """The outcome of the search, in a sentence."""
    searched, other = f"after {position.iterations} iterations", ' or try method="settling"'
    if method == "settling":
        searched, other = "where the damped motion ended,", ""
    touched = (description.switches[k] for k in position.edges)
    edges = ", ".join(f"{switch.condition} of {switch.name}" for switch in touched)
    if ran:
        return (
            f"No equilibrium found: nothing holds the machine in {', '.join(ran)}, which ran away "
            f"without end; the position given is the start. Hold it by a joint, a driver or a "
            f"spring, or start from a guess nearer to rest."
        )
    if not position.balanced:
        shares = np.abs(position.gradient) / position.effort
        worst = int(position.part.independent[int(np.argmax(shares))])
        name = description.coordinates[worst].name
        if edges:
            return (
                f"No equilibrium found: the search ended at {name} = {position.q[worst]:.6g} on "
                f"the boundary of {edges}, where the forces jump; on neither side of it they "
                "balance. If the machine is meant to stand there, hold it by a constraint, or let "
                f"the force rise over a short distance."
            )
        return (
            f"No equilibrium found: {searched} {position.unbalanced:.1e} of the forces is "
            f"unbalanced, most along {name} = {position.q[worst]:.6g}. Start from a guess nearer "
            f"to rest{other.replace(' or', ',')}, or check that something holds the machine."
        )
    notes = {
        Stability.STABLE: "Stable: it returns after a small push.",
        Stability.UNSTABLE: (
            "Unstable: the forces balance, but a small push drives it away"
            f"{', in oscillations that grow (flutter)' if judged.flutter else ''}"
            f"{', since forces that depend on velocities feed its motion' if judged.fed else ''}. "
            f"Start elsewhere{other}."
        ),
        Stability.INDIFFERENT: (
            f"Indifferent: it stays where a small push leaves {', '.join(judged.loose) or 'it'}."
        ),
        Stability.UNKNOWN: (
            f"Stability unknown: the forces balance on the boundary of {edges}, so the stiffness "
            f"is that of one side only."
        ),
    }
    return f"{notes[judged.stability]} Unbalanced share of the forces {position.unbalanced:.1e}."


def _require_finite(equations: Equations, t: float, q: FloatArray) -> None:
    """Refuse a start where forces have no value."""
    description, modes = equations.description, equations.rest_modes(t, q)
    forces = equations.forces(t, q, equations.at_rest(t, q), modes)
    finite = np.isfinite(forces) & np.isfinite(equations.potential_gradient(t, q, modes))
    if finite.all():
        return
    if left := left_tables(equations, t, q, equations.still):
        raise AnalysisError(f"{description.title}: at the start position {left} {_ELSEWHERE}")
    lost = [description.coordinates[int(k)].name for k in np.flatnonzero(~finite)]
    effects = ", ".join(row.name for row in description.effects) or "none"
    raise AnalysisError(
        f"{description.title}: at the start position the forces along {', '.join(lost)} are not "
        f"finite (effects: {effects}). Look for a spring whose ends coincide, a division by zero "
        "or a table evaluated beyond its ends, and start elsewhere: give guess= or a guess in the "
        "scene."
    )
