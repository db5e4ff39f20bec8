"""Inverse dynamics: the forces and torques that a prescribed motion takes.

The motion is that of kinematics; the multipliers of the drivers are the forces and torques that
produce it. A driver's reaction is what it exerts on the body that it moves. Rigid contacts, whose
state is not decided here, and friction that does not slip, whose force the motion does not
determine, are refused.
"""

import numpy.typing as npt

from codegen.errors import AnalysisError
from runtime.dynamics.kinematics import kinematics
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result
from runtime.validation.contacts import require_slip
from runtime.validation.masses import require_masses
from runtime.validation.parameters import parameter_values


def inverse_dynamics(
    mechanism: Mechanism,
    t_eval: npt.ArrayLike,
    *,
    parameters: Values | None = None,
    guess: Values | None = None,
    t_start: float = 0.0,
    progress: Progress = silent,
) -> Result:
    """Motion, reactions, drives and powers at the instants `t_eval`; see `kinematics`."""
    description = mechanism.description
    if not description.has_masses:
        raise AnalysisError(
            f"{description.title}: inverse dynamics needs masses, and this scene has a body "
            f"without. Give every body a mass and an inertia, or ask for kinematics."
        )
    p = parameter_values(mechanism, parameters)
    require_masses(mechanism, p)
    result = kinematics(
        mechanism,
        t_eval,
        parameters=parameters,
        guess=guess,
        t_start=t_start,
        progress=progress,
        analysis="inverse dynamics",
    )
    require_slip(mechanism, p, result.samples)
    return result
