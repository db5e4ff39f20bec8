"""The assembled start of a simulation, from which several runs may be made.

A run that starts from a state of another one takes over its clocks and watched conditions by their
names: samples that wait for their delay act when they would have acted, and a condition that holds
does not begin to hold again. What the two runs do not have in common begins anew.
"""

from collections.abc import Sequence
from contextlib import suppress
from copy import copy
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from codegen.errors import AssemblyError
from runtime.assembly.assemble import assemble
from runtime.assembly.start_values import start_note
from runtime.dynamics.checks.screening import exceed_bound, screen
from runtime.dynamics.controllers import Functions, controllers_of
from runtime.dynamics.output_quantities import evaluate_samples
from runtime.integrate.checkpoints import Checkpoints
from runtime.integrate.clocks import queue_length, read_clocks, set_clocks
from runtime.integrate.problem import Discrete, Options, Stops, Trajectory
from runtime.integrate.wiring import begin_compiling
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Numbers
from runtime.progress_bar import Progress
from runtime.results.assembled_state import Assembly, DiscreteState, State
from runtime.validation.arguments import instants, parameter_values, require_masses, uniform
from runtime.validation.scene_support import refuse_massless, refuse_structure, require_apart

if TYPE_CHECKING:
    from runtime.dynamics.formulations import Coordinates
    from runtime.explicit_time.passage import Passages

Row = TypeVar("Row")


def passages_of(
    equations: Equations, t_begin: float, t_end: float, sizes: FloatArray
) -> "Passages | None":
    """What explicit functions of time ask of a motion, times in s; None where there are none."""
    if not equations.description.time_functions:
        return None
    from runtime.explicit_time.passage import Passages  # compiled: other scenes do without

    return Passages(equations, t_begin, t_end, sizes)


def discrete_state(
    mechanism: Mechanism, p: FloatArray, stand: Discrete | None
) -> DiscreteState | None:
    """Where clocks and conditions of a run with the parameters p, (np,), stand, by their names."""
    if stand is None:
        return None
    description = mechanism.description
    return DiscreteState(
        description.scene, description.sampled, read_clocks(mechanism.system, p),
        tuple(row[:3] for row in description.watched), stand,
    )  # fmt: skip


def _discrete_at_start(
    mechanism: Mechanism, p: FloatArray, start: State, goes_on: bool
) -> tuple[Discrete | None, list[str]]:
    """What a run takes over from the state, and values whose waiting samples it does not.

    A run that `goes_on` with other joints is part of that to which the state belongs.
    """
    description, given = mechanism.description, start.discrete
    clocks = read_clocks(mechanism.system, p)
    if given is None:
        waits = [clock[1] > 0.0 for clock in clocks]
        return None, [name for name, w in zip(description.sampled, waits, strict=True) if w]
    if not (description.sampled or description.watched):
        return None, []
    count, queue = len(clocks), queue_length(clocks)
    ticks, waiting, lost = np.zeros((count, 2), np.int64), np.zeros((count, queue)), list[str]()
    rows = {key: j for j, key in enumerate(_numbered(given.sampled))}
    for k, key in enumerate(_numbered(description.sampled)):
        j = rows.get(key)
        taken = start.sampled and j is not None
        set_clocks(start.t, clocks[k : k + 1], ticks[k], taken=taken)
        if j is None:
            continue
        following, acting = given.stand.ticks.reshape(-1, 2)[j]
        if goes_on or np.array_equal(clocks[k], given.clocks[j]):
            ticks[k] = following, acting
            for number in range(acting, following):
                sample = given.stand.waiting[j, number % given.stand.waiting.shape[1]]
                waiting[k, number % queue] = sample
        elif acting < following:
            lost.append(description.sampled[k])
    held = dict(zip(_numbered(given.watched), given.stand.held.tolist(), strict=True))
    goes_on |= given.scene == description.scene  # else with other joints, which come or go anew
    keys = _numbered([row[:3] for row in description.watched])
    holds = [
        held.get(key, 0.0) if goes_on or not row.reconnects else 0.0
        for key, row in zip(keys, description.watched, strict=True)
    ]
    return Discrete(ticks.ravel(), waiting, np.array(holds, np.float64)), lost


def _numbered(rows: Sequence[Row]) -> list[tuple[Row, int]]:
    """Each row, with how often it stood there before: a latch has two of its name."""
    return [(row, rows[:k].count(row)) for k, row in enumerate(rows)]


def _fits_better(equations: Equations, state: State, later: float) -> bool:
    """Whether the velocities of a state are rather those of a later instant, s, than of its own."""
    n = equations.jacobian(state.t, state.q) @ state.v
    own, there = (abs(n - equations.velocity_rhs(t, state.q)).max() for t in (state.t, later))
    return bool(there < own)


class PreparedSimulation:
    """The start of a simulation: state, parameters and typical sizes, the same for all its runs.

    Where a law bends in the very first instant, it is just behind: by that law it moves. A run that
    goes on from another one, perhaps with other joints, takes over its typical `length`, m.

    Raises AnalysisError if nothing is left to integrate, or no mass moves.
    """

    def __init__(
        self, mechanism: Mechanism, t_end: float, *, t_start: float = 0.0,
        parameters: Numbers | None = None, guess: Numbers | None = None,
        start: Assembly | State | Numbers | None = None,
        controllers: Functions | None = None, length: float | None = None,
    ) -> None:  # fmt: skip
        if not mechanism.description.has_masses:
            refuse_massless(mechanism)
        self.mechanism, self.t_end, self.given_length = mechanism, float(t_end), length
        self.given: dict[str, Any] = {
            "t_start": t_start, "parameters": parameters, "guess": guess, "start": start,
            "controllers": controllers,
        }  # fmt: skip
        self.controllers = controllers_of(mechanism, controllers)
        self.p = p = parameter_values(mechanism, parameters)  # with derived constants, (np,)
        self.equations = equations = Equations(mechanism, p)
        require_masses(mechanism, p)
        state = start if isinstance(start, State) else None
        given = None if isinstance(start, Assembly) else start
        if isinstance(start, Assembly):
            begin = start
        else:
            # Beside what assembles, a second process compiles the loop and what looks at its end.
            checks: list[Any] = [exceed_bound] if mechanism.description.constraints else []
            checks += [screen] if mechanism.description.switches else []
            begin_compiling(mechanism.system, [*checks, evaluate_samples])
            t_start = t_start if state is None else state.t
            begin = assemble(equations, t_start, guess, given)
        self.given_t, goes_on = begin.t, length is not None
        # one tolerance for the whole motion, wherever joints come and go
        sizes = equations.scale(equations.length(begin.t, begin.q) if length is None else length)
        self.passages = passages_of(equations, begin.t, self.t_end, sizes)
        if self.passages is not None and not isinstance(start, Assembly):
            behind = self.passages.first_instant(begin.q, begin.v)
            if behind > begin.t and (state is None or _fits_better(equations, state, behind)):
                # Start velocities that are given may fit the law before the kink alone.
                with suppress(AssemblyError):
                    begin = assemble(equations, behind, guess, given)
                    self.passages = passages_of(equations, behind, self.t_end, sizes)
        self.begin, self.sizes = begin, sizes
        self.discrete, lost = None, list[str]()
        if state is not None:
            self.discrete, lost = _discrete_at_start(mechanism, p, state, goes_on)
        self.samples_taken = state is not None and state.sampled and self.given_t == state.t
        self.note = "" if goes_on else start_note(mechanism, begin, guess, given)
        if lost and not goes_on:
            self.note += (
                f" Samples of {', '.join(lost)} that wait for their delay do not act: a state of "
                "Result.state has them, where period and delay are those of its run."
            )
        least = float(self.sizes.min(initial=1.0))
        require_apart(mechanism, p, begin.t, begin.q, begin.v, least)
        waits = goes_on or any(row.reconnects for row in mechanism.description.watched)
        waits |= state is not None and state.scene == mechanism.description.scene
        if begin.is_determined and not waits and equations.is_scleronomic:
            refuse_structure(mechanism)

    @property
    def length(self) -> float:
        """The length to which tolerances of lengths are relative, m; 1 where nothing is one."""
        lengths = self.sizes[self.mechanism.description.is_length]
        return float(lengths.max(initial=0.0)) or 1.0

    def until(self, t_end: float) -> "PreparedSimulation":
        """The same start, of runs to another end, s."""
        if self.begin.t > self.given_t and not isinstance(self.given["start"], Assembly):
            # Behind a kink, by a distance that depends on the end.
            other = PreparedSimulation(
                self.mechanism, t_end, **self.given, length=self.given_length
            )
            other.controllers = self.controllers
            return other
        other = self.again(t_end)
        other.passages = passages_of(other.equations, self.begin.t, t_end, self.sizes)
        return other

    def again(self, t_end: float) -> "PreparedSimulation":
        """The same start to another end, s, with parameters of its own: runs write some of them."""
        other = copy(self)
        other.t_end, other.p = float(t_end), self.p.copy()
        other.equations = Equations(self.mechanism, other.p)
        return other

    @property
    def stops(self) -> Stops | None:
        """Instants at which the steps of a run end, known before it gets there."""
        return None if self.passages is None else self.passages.stops()

    def instants(self, t_eval: ArrayLike | int | str | None) -> FloatArray | None:
        """The instants of the samples, s, those asked for at the start where that begins.

        So many, by default 501, or those of an array; None: the end of every step.
        """
        if isinstance(t_eval, str):  # "steps"
            return None
        if t_eval is None or isinstance(t_eval, int):
            if self.t_end < self.given_t:
                return None  # the run is refused
            times = uniform(self.given_t, self.t_end, t_eval)
        else:
            times = instants(t_eval)
        return np.where(times == self.given_t, self.begin.t, times)

    def run(self, taken: "Coordinates", options: Options, progress: Progress) -> Trajectory:
        """Integrate in the coordinates `taken`; returns the trajectory in all coordinates."""
        first, made = self.begin.t, Checkpoints()
        span = max(self.t_end - first, 1e-300)
        path = taken.run(
            options, made, progress=lambda t, steps: progress((t - first) / span), again=False
        )
        return path._replace(checkpoints=made)
