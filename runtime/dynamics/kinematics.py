"""Kinematic analysis: the motion of a machine whose drivers leave it no freedom."""

import time as clock

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from runtime.assembly.assemble import assemble, start_values
from runtime.assembly.redundant_kernels import sound, spared
from runtime.continuation.driven_motion import follow
from runtime.core.outcomes import Outcome
from runtime.dynamics.output_quantities import evaluate
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.progress_bar import Progress, silent
from runtime.results.assembled_state import Assembly
from runtime.results.event_records import CROSSED, LOCKED, Event
from runtime.results.result import Result
from runtime.results.singular_positions import SingularPosition
from runtime.validation.arguments import instants
from runtime.validation.contacts import require_no_rigid
from runtime.validation.parameters import parameter_values

_DIRECTIONS = {"crossing": CROSSED, "lock-up": LOCKED}


def kinematics(
    mechanism: Mechanism,
    t_eval: npt.ArrayLike,
    *,
    parameters: Values | None = None,
    guess: Values | None = None,
    t_start: float = 0.0,
    progress: Progress = silent,
    analysis: str = "kinematics",
) -> Result:
    """Positions, velocities and accelerations at the instants `t_eval`.

    Drivers would push bodies through rigid contacts, so that scenes with these are refused.

    Where the machine locks up, the result reaches to the last instant before, followed by the
    position in which it locks, where velocities are not a number; the outcome says so. Positions in
    which motions cross are passed on the branch on which the velocity is continuous. Both are
    events, and described in `Result.singular`.

    Parameters
    ----------
    t_eval
        Instants in s, increasing.
    guess
        Start values by name, over those of the scene.
    t_start
        Instant in s to which the start values belong. The machine is assembled there and followed
        to the first of `t_eval`, so that it stays on the branch on which it starts.
    """
    began = clock.perf_counter()
    require_no_rigid(mechanism, analysis)
    times = instants(t_eval)
    start = assemble(mechanism, guess, parameters, t_start)
    require_driven(mechanism, start, analysis)
    mechanism = sound(mechanism, start)
    wished = start_values(mechanism, guess).v
    p = parameter_values(mechanism, parameters)
    found = follow(mechanism, times, start, wished, p, progress)
    samples = evaluate(mechanism, p, found.t, found.q, found.v)
    instants_lost = np.flatnonzero(np.isnan(samples.a).any(axis=1))
    found.stats["singular_instants"] = len(instants_lost)
    message = found.message
    if len(instants_lost) and found.outcome is Outcome.OK:
        where = ", ".join(f"{samples.t[index]:.6g}" for index in instants_lost[:5])
        message += (
            f" At {len(instants_lost)} of the instants (t = {where} s) the position is singular: "
            f"accelerations and reactions are not a number there."
        )
    found.stats["wall_seconds"] = clock.perf_counter() - began
    return Result(
        mechanism.description,
        samples,
        p,
        analysis=analysis,
        outcome=found.outcome,
        message=message + spared(start),
        stats=found.stats,
        events=[_event(row) for row in found.singular if row.kind in _DIRECTIONS],
        not_unique=start.not_unique,
        singular=found.singular,
    )


def _event(row: SingularPosition) -> Event:
    assert row.q is not None
    assert row.v is not None
    return Event(row.title, row.time, _DIRECTIONS[row.kind], row.q, row.v)


def require_driven(mechanism: Mechanism, start: Assembly, analysis: str) -> None:
    """Refuse a machine that its drivers leave free to move."""
    free = start.degrees_of_freedom
    if free == 0:
        return
    told = mechanism.description
    drivers = ", ".join(told.drivers) or "none"
    left_out = [row.name for row in told.left_out if "driver" in row.kind]
    hint = f" Declared but left out of this scene: {', '.join(left_out)}." if left_out else ""
    raise AnalysisError(
        f"{told.title}: {analysis.replace('_', ' ')} needs a machine without freedom, and "
        f"{free} degree{'s' if free > 1 else ''} of freedom "
        f"{'are' if free > 1 else 'is'} left ({len(told.coordinates)} coordinates, drivers: "
        f"{drivers}). Add {free} driver{'s' if free > 1 else ''} to the scene, "
        f"or ask for simulate.{hint}"
    )
