"""A scene's kernels as the system that the integrator asks for, in all coordinates or in fewer."""

from runtime.core.kernels import Kernels
from runtime.core.signatures import Integers
from runtime.core.system import System
from runtime.mechanism.description import Description


def system(
    told: Description,
    kernels: Kernels,
    jacobian: tuple[Integers, Integers],
    coordinates: int,
    constraints: int,
) -> System:
    """What is the same in every formulation.

    Parameters
    ----------
    jacobian
        Rows and columns of the structural non-zeros of the Jacobian.
    coordinates, constraints
        How many there are.
    """
    rows, columns = jacobian
    return System(
        accelerations=kernels.accelerations,
        correction=kernels.correction,
        jacobian=kernels.jacobian,
        jacobian_rows=rows,
        jacobian_columns=columns,
        coordinates=coordinates,
        constraint_count=constraints,
        switches=len(told.switches),
        switching=kernels.switching,
        switching_rates=kernels.switching_rates,
        constraints=kernels.constraints,
        velocity_rhs=kernels.velocity_rhs,
        acceleration_rhs=kernels.acceleration_rhs,
        mass=kernels.mass,
        applied_forces=kernels.applied_forces,
        gap_accelerations=kernels.gap_accelerations,
        holds=kernels.holds,
        restitution=kernels.restitution,
        rigid=tuple(contact.switch for contact in told.rigid),
        sticking=tuple(k for k, row in enumerate(told.switches) if row.kind == "friction"),
    )
