"""The assembled start of a simulation, from which several runs may be made."""

from collections.abc import Sequence
from contextlib import suppress
from copy import copy
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from codegen.errors import AssemblyError
from runtime.assembly.assemble import assemble
from runtime.assembly.start_values import start_note
from runtime.dynamics.checks.screening import exceed_bound, screen
from runtime.dynamics.continued_state import discrete_at_start
from runtime.dynamics.controllers import Functions, controllers_of
from runtime.dynamics.output_quantities import evaluate_samples
from runtime.integrate.problem import Discrete, Options, Stops
from runtime.integrate.trajectory import Trajectory
from runtime.integrate.wiring import begin_compiling
from runtime.mechanism.dense_equations import Equations, FloatArray, magnitudes
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.progress_bar import Progress
from runtime.results.assembled_state import Assembly, State
from runtime.validation.masses import require_masses
from runtime.validation.output_instants import instants, uniform
from runtime.validation.parameters import parameter_values
from runtime.validation.scene_support import refuse_massless, refuse_structure
from runtime.validation.set_valued_forces import require_apart

if TYPE_CHECKING:
    from runtime.dynamics.formulations import Coordinates
    from runtime.explicit_time.passage import Passages


def passages_of(
    equations: Equations, t_begin: float, t_end: float, sizes: FloatArray
) -> "Passages | None":
    """What explicit functions of time ask of a motion, times in s; None where there are none."""
    if not equations.description.time_functions:
        return None
    from runtime.explicit_time.passage import Passages  # compiled: other scenes do without

    return Passages(equations, t_begin, t_end, sizes)


class Handover(NamedTuple):
    """What a run with other joints hands to the one that follows it, beside its state."""

    discrete: Discrete | None
    length: float  # typical of the machine at the start of the first run, m


def lost_samples_note(lost: Sequence[str]) -> str:
    """Sentence on sampled values whose samples in delay are not known; else empty."""
    if not lost:
        return ""
    return (
        f" Samples of {', '.join(lost)} that wait for their delay do not act: a state of "
        "Result.state has them, where period and delay are those of its run."
    )


def _begin_compiling(mechanism: Mechanism) -> None:
    """Let a second process compile what a first run needs at its end, and the loop."""
    description = mechanism.description
    checks: list[Any] = [exceed_bound] if description.constraints else []
    checks += [screen] if description.switches else []
    begin_compiling(mechanism.system, [*checks, evaluate_samples])


class PreparedSimulation:
    """The start of a simulation: state, parameters and typical sizes, the same for all its runs.

    Where a law bends in the very first instant, it is just behind: by that law it moves.

    Raises AnalysisError if nothing is left to integrate, or no mass moves.
    """

    def __init__(
        self, mechanism: Mechanism, t_end: float, *, t_start: float, parameters: Values | None,
        guess: Values | None, start: Assembly | State | Values | None,
        controllers: Functions | None = None, handover: Handover | None = None,
    ) -> None:  # fmt: skip
        if not mechanism.description.has_masses:
            refuse_massless(mechanism)
        self.mechanism, self.t_end = mechanism, float(t_end)
        self.given: dict[str, Any] = {
            "t_start": t_start, "parameters": parameters, "guess": guess, "start": start,
            "controllers": controllers, "handover": handover,
        }  # fmt: skip
        self.controllers = controllers_of(mechanism, controllers)
        self.p = p = parameter_values(mechanism, parameters)  # with derived constants, (np,)
        require_masses(mechanism, p)
        given = start if not isinstance(start, Assembly) else None
        if isinstance(start, Assembly):
            begin = start
        else:
            _begin_compiling(mechanism)  # beside what assembles
            t_start = start.t if isinstance(start, State) else t_start
            begin = assemble(mechanism, guess, parameters, t_start, start_at=given)
        equations, self.given_t = Equations(mechanism, p), begin.t
        self.handover = handover
        if handover is None:
            sizes = magnitudes(equations, begin.t, begin.q)
        else:  # one tolerance for the whole motion, wherever joints come and go
            sizes = equations.scale(handover.length)
        self.passages = passages_of(equations, begin.t, self.t_end, sizes)
        if self.passages is not None and not isinstance(start, Assembly | State):
            behind = self.passages.first_instant(begin.q, begin.v)
            if behind > begin.t:
                # Start velocities that are given may fit the law before the kink alone.
                with suppress(AssemblyError):
                    begin = assemble(mechanism, guess, parameters, behind, start_at=given)
                    self.passages = passages_of(equations, behind, self.t_end, sizes)
        self.begin, self.sizes = begin, sizes
        self.discrete, lost = None if handover is None else handover.discrete, list[str]()
        if isinstance(start, State) and not handover:
            self.discrete, lost = discrete_at_start(mechanism, p, start)
        self.samples_taken = isinstance(start, State) and start.sampled and begin.t == start.t
        self.note = "" if handover else start_note(mechanism, begin, guess, given)
        self.note += lost_samples_note(lost)
        least = float(self.sizes.min(initial=1.0))
        require_apart(mechanism, p, begin.t, begin.q, begin.v, least)
        waits = any(row.reconnects for row in mechanism.description.watched)
        waits |= isinstance(start, State) and start.scene == mechanism.description.scene
        still = not equations.velocity_rhs(begin.t, begin.q).any()
        if begin.is_determined and still and not (waits or handover):
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
            other = PreparedSimulation(self.mechanism, t_end, **self.given)
            other.controllers = self.controllers
            return other
        other, equations = copy(self), Equations(self.mechanism, self.p)
        other.t_end = t_end
        other.passages = passages_of(equations, self.begin.t, t_end, self.sizes)
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
        """One integration in the coordinates `taken`; its run in all coordinates."""
        first = self.begin.t
        span = max(self.t_end - first, 1e-300)
        return taken.run(options, lambda t, steps: progress((t - first) / span))
