"""Types of everything that compiled code of the runtime hands on as a first-class function.

Kernels of generated modules and the functions of an integration method travel as values of a
`numba.types.FunctionType`. The integrator is therefore compiled once, for these types, and never
again for another model. A kernel fits when it was compiled with exactly the signature named here.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from runtime.core.jit import compiled

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Integers = NDArray[np.int64]
IntegerMatrix = NDArray[np.int64]
Kernel = Callable[..., Any]

f8 = types.float64
i8 = types.int64
none = types.none
vector = types.Array(f8, 1, "C")
matrix = types.Array(f8, 2, "C")
integers = types.Array(i8, 1, "C")
integer_matrix = types.Array(i8, 2, "C")

# Kernels of a generated module. Names of the arguments are in the comment.
ACCELERATIONS = i8(f8, vector, vector, vector, integers, vector, vector)  # t q v p modes a lam
CORRECTION = i8(f8, vector, vector, vector, vector, vector, vector)  # t q v p w dq dv
JACOBIAN = none(f8, vector, vector, vector)  # t q p values
SWITCHING = none(f8, vector, vector, vector, vector)  # t q v p g
SWITCHING_RATES = none(f8, vector, vector, vector, vector, vector)  # t q v a p rate
RIGHT_SIDE = none(f8, vector, vector, vector)  # t q p phi; velocity_rhs alike
STATE_RIGHT_SIDE = none(f8, vector, vector, vector, vector)  # t q v p gamma
MASS = none(vector, vector, vector)  # q p values
APPLIED_FORCES = none(f8, vector, vector, vector, integers, vector)  # t q v p modes Q
ACCELERATIONS_TANGENT = none(
    f8, vector, vector, vector, integers, vector, vector, vector
)  # t q v p modes dq dv da
CORRECTION_TANGENT = none(
    f8, vector, vector, vector, vector, vector, vector, vector, vector
)  # t q v p w dq_in dv_in dq dv
REACTIONS = none(f8, vector, vector, vector, vector, vector)  # t q v p lam out
SWITCHED_REACTIONS = none(
    f8, vector, vector, vector, integers, vector, vector
)  # t q v p modes lam out

Accelerations = types.FunctionType(ACCELERATIONS)
Correction = types.FunctionType(CORRECTION)
Jacobian = types.FunctionType(JACOBIAN)
Switching = types.FunctionType(SWITCHING)
SwitchingRates = types.FunctionType(SWITCHING_RATES)
RightSide = types.FunctionType(RIGHT_SIDE)
StateRightSide = types.FunctionType(STATE_RIGHT_SIDE)
Mass = types.FunctionType(MASS)
AppliedForces = types.FunctionType(APPLIED_FORCES)
AccelerationsTangent = types.FunctionType(ACCELERATIONS_TANGENT)
CorrectionTangent = types.FunctionType(CORRECTION_TANGENT)
Reactions = types.FunctionType(REACTIONS)
SwitchedReactions = types.FunctionType(SWITCHED_REACTIONS)


@compiled(SWITCHING)
def no_switching(t: float, q: Vector, v: Vector, p: Vector, g: Vector) -> None:
    """Stand in for `switching` where a model has no switching function."""


@compiled(SWITCHING_RATES)
def no_switching_rates(t: float, q: Vector, v: Vector, a: Vector, p: Vector, rate: Vector) -> None:
    """Stand in for `switching_rates` where a model has no switching function."""


@compiled(RIGHT_SIDE)
def no_right_side(t: float, q: Vector, p: Vector, phi: Vector) -> None:
    """Stand in for a kernel that a method does not use."""


@compiled(STATE_RIGHT_SIDE)
def no_state_right_side(t: float, q: Vector, v: Vector, p: Vector, gamma: Vector) -> None:
    """Stand in for a kernel that a method does not use."""


@compiled(MASS)
def no_mass(q: Vector, p: Vector, values: Vector) -> None:
    """Stand in for a kernel that a method does not use."""


@compiled(APPLIED_FORCES)
def no_forces(t: float, q: Vector, v: Vector, p: Vector, modes: Integers, force: Vector) -> None:
    """Stand in for a kernel that a method does not use."""


@compiled(ACCELERATIONS_TANGENT)
def no_accelerations_tangent(
    t: float,
    q: Vector,
    v: Vector,
    p: Vector,
    modes: Integers,
    dq: Vector,
    dv: Vector,
    da: Vector,
) -> None:
    """Stand in for the derivatives where the method is explicit."""


@compiled(CORRECTION_TANGENT)
def no_correction_tangent(
    t: float,
    q: Vector,
    v: Vector,
    p: Vector,
    w: Vector,
    dq_in: Vector,
    dv_in: Vector,
    dq: Vector,
    dv: Vector,
) -> None:
    """Stand in for the derivatives where the method is explicit."""


@compiled(REACTIONS)
def no_reactions(t: float, q: Vector, v: Vector, p: Vector, lam: Vector, out: Vector) -> None:
    """Stand in where nobody asks for reactions."""


@compiled(SWITCHED_REACTIONS)
def no_switched_reactions(
    t: float, q: Vector, v: Vector, p: Vector, modes: Integers, lam: Vector, out: Vector
) -> None:
    """Stand in where no mode decides on a reaction."""


def plain_holds(p: Vector, low: Vector, high: Vector) -> None:
    """Bounds of shares between two fields: 0 and 1."""


def no_restitution(p: Vector, e: Vector) -> None:
    """Stand in where there is no rigid contact."""
