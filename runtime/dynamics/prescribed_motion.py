"""Kinematics and inverse dynamics: the motion of a machine that its drivers leave no freedom.

Inverse dynamics adds the forces and torques that the motion takes: the multipliers of the drivers
produce it. A driver's reaction is what it exerts on the body that it moves. Rigid contacts, whose
state is not decided here, and friction that does not slip, whose force the motion does not
determine, are refused.
"""

import time as clock
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from runtime.assembly.assemble import assemble
from runtime.assembly.kernels_for_redundant_constraints import redundancy_note, with_redundancy
from runtime.assembly.masses_far_apart import suited_to_masses
from runtime.assembly.start_values import start_note, start_values
from runtime.core.kinds import Direction
from runtime.core.outcomes import Outcome
from runtime.dynamics.checks.end_checks import check_result
from runtime.dynamics.driven_motion_past_kinks import follow_past_kinks
from runtime.dynamics.motion_at_instants import DrivenMotionAtInstants
from runtime.dynamics.output_quantities import evaluate
from runtime.integrate.problem import Options
from runtime.mechanism.dense_equations import Equations, magnitudes
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.progress_bar import Progress, silent
from runtime.results.assembled_state import Assembly
from runtime.results.event_records import Event, SingularPosition
from runtime.results.result import Result
from runtime.validation.masses import require_masses
from runtime.validation.output_instants import instants
from runtime.validation.parameters import parameter_values
from runtime.validation.set_valued_forces import require_no_rigid, require_slip
from runtime.validation.table_ranges import name_left_tables

_DIRECTIONS = {"crossing": int(Direction.CROSSED), "lock-up": int(Direction.LOCKED)}


def kinematics(
    mechanism: Mechanism, t_eval: npt.ArrayLike, *, parameters: Values | None = None,
    guess: Values | None = None, start: Values | None = None, t_start: float = 0.0,
    progress: Progress = silent, analysis: str = "kinematics",
) -> Result:  # fmt: skip
    """Kinematics of `Machine.kinematics`; `analysis` names the analysis in messages."""
    began = clock.perf_counter()
    require_no_rigid(mechanism, analysis)
    times = instants(t_eval)
    begin = assemble(mechanism, guess, parameters, t_start, start_at=start)
    require_driven(mechanism, begin, analysis)
    p = parameter_values(mechanism, parameters)
    mechanism = suited_to_masses(with_redundancy(mechanism, begin), begin.t, begin.q, p)
    preferred = start_values(mechanism, guess, start).v
    motion, kinks = follow_past_kinks(Equations(mechanism, p), times, begin, preferred, progress)
    samples = evaluate(mechanism, p, motion.t, motion.q, motion.v)
    singular = np.flatnonzero(np.isnan(samples.a).any(axis=1))
    motion.stats["singular_instants"] = len(singular)
    message = motion.message
    if len(singular) and motion.outcome is Outcome.OK:
        where = ", ".join(f"{samples.t[index]:.6g}" for index in singular[:5])
        message += (
            f" At {len(singular)} of the instants (t = {where} s) the position is singular: "
            f"accelerations and reactions are not a number there."
        )
    crossed = [_event(row) for row in motion.singular if row.kind in _DIRECTIONS]
    motion.stats["wall_seconds"] = clock.perf_counter() - began
    result = Result(
        mechanism.description, samples, p, analysis=analysis, outcome=motion.outcome,
        message=message + start_note(mechanism, begin, guess, start) + redundancy_note(begin),
        stats=motion.stats,
        events=sorted([*crossed, *kinks], key=lambda event: event.time),
        not_unique=begin.not_unique, singular=motion.singular,
    )  # fmt: skip
    result._mechanism = mechanism
    result._motion = DrivenMotionAtInstants(mechanism, p, begin, preferred, times)
    equations = Equations(mechanism, p)
    name_left_tables(result, equations, every=True)
    check_result(result, equations, magnitudes(equations, begin.t, begin.q), Options(rtol=0.0))
    return result


def inverse_dynamics(
    mechanism: Mechanism, t_eval: npt.ArrayLike, *, parameters: Values | None = None, **options: Any
) -> Result:
    """Motion, reactions, drives and powers at the instants `t_eval`; options as `kinematics`."""
    description = mechanism.description
    if not description.has_masses:
        raise AnalysisError(description.need_masses("inverse dynamics", ", or ask for kinematics"))
    p = parameter_values(mechanism, parameters)
    require_masses(mechanism, p)
    options |= {"parameters": parameters, "analysis": "inverse dynamics"}
    result = kinematics(mechanism, t_eval, **options)
    require_slip(mechanism, p, result.samples)
    return result


def _event(row: SingularPosition) -> Event:
    assert row.q is not None
    assert row.v is not None
    return Event(row.title, row.time, _DIRECTIONS[row.kind], row.q, row.v)


def require_driven(mechanism: Mechanism, start: Assembly, analysis: str) -> None:
    """Refuse a machine that its drivers leave free to move."""
    free = start.degrees_of_freedom
    if free == 0:
        return
    description = mechanism.description
    drivers = ", ".join(description.drivers) or "none"
    left_out = [row.name for row in description.left_out if "driver" in row.kind]
    hint = f" Declared but left out of this scene: {', '.join(left_out)}." if left_out else ""
    raise AnalysisError(
        f"{description.title}: {analysis.replace('_', ' ')} needs a machine without freedom, and "
        f"{free} degree{'s' if free > 1 else ''} of freedom "
        f"{'are' if free > 1 else 'is'} left ({len(description.positions)} coordinates, drivers: "
        f"{drivers}). Add {free} driver{'s' if free > 1 else ''} to the scene, or the joint "
        "that is missing (`linkwright check` names the bodies that one joint alone holds), or ask "
        f"for simulate.{hint}"
    )
