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
from runtime.core.workspace import run_record

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

# Functions of a method and parts of the loop. `machine` is the table of `slots`, `w` the workspace
# of `workspace`, `sw` its rows for switching functions, `run` the record of the run.
STAGES = i8(integers, f8, f8, vector, run_record, vector, integers, vector)
# machine t h w run p modes lam; Newton iterations, negative where one failed
ERROR = f8(integers, f8, f8, vector)  # machine h rtol w; over the tolerance, root mean square
DENSE = i8(integers, f8, f8, vector, vector, integers, vector)  # machine t h w p modes lam
PROPOSE = f8(integers, f8, vector, run_record)  # machine h w run; ratio of two steps' lengths
HOOK = i8(integers, f8, f8, vector, run_record)  # machine t h w run; 1: another method is due
DIFFERENTIATE = i8(
    integers, f8, i8, vector, run_record, vector, integers, vector
)  # machine t state w run p modes lam
CORRECT = i8(integers, f8, i8, i8, vector, vector)  # machine t row weighing w p
SLOPE = i8(integers, f8, i8, i8, vector, vector, integers, vector)
FIELD = i8(integers, f8, vector, vector, vector, integers, vector, vector)
# machine t q v p modes a lam; as ACCELERATIONS
IMPACT = f8(
    integers, i8, f8, i8, vector, vector, vector, integers, vector
)  # machine first t state w sw p modes lam; time of the next flight, infinite where it goes on
RETURN_HELD = i8(
    integers, f8, i8, vector, vector, integers, vector
)  # machine t state w p modes lam
TRANSITION = i8(
    integers,
    i8,
    f8,
    f8,
    vector,
    vector,
    run_record,
    vector,
    integers,
    integers,
    vector,
    vector,
    integer_matrix,
    matrix,
)  # machine crossing t h w sw run p modes scratch lam event_t event_kind event_y
LIMIT = f8(integers, f8, vector, vector, vector, vector, i8)  # machine t q v p lam k
REACTIONS = none(f8, vector, vector, vector, vector, vector)  # t q v p lam out
SWITCHED_REACTIONS = none(
    f8, vector, vector, vector, integers, vector, vector
)  # t q v p modes lam out
ATTEMPT = i8(integers, f8, f8, vector, run_record, vector, integers, vector)
# machine t h w run p modes lam
REPARTITION = i8(integers, f8, i8, vector, run_record, vector)  # machine t state w run p
LOCATE = f8(integers, f8, f8, i8, integers)  # machine t h dense_rows found
SAMPLED = f8(integers, f8, f8, f8, i8, i8)  # machine t h x k dense_rows
MARGINS = none(integers, f8, i8, i8)  # machine t state slot
SETTLE = i8(
    integers, i8, f8, f8, i8, i8, vector, vector, vector, integers, integers, vector
)  # machine first t d state slot w sw p modes scratch lam
FIRST_STEP = f8(
    integers, f8, f8, f8, i8, vector, vector, integers, vector
)  # machine t h_max rtol order w p modes lam
EMIT = i8(
    integers, f8, f8, f8, i8, vector, run_record, vector, integers, vector, vector, vector, matrix,
    integer_matrix,
)  # machine t t1 h dense_ready w run p modes lam t_eval out_t out_y out_modes  # fmt: skip
WATCH = i8(
    integers, f8, f8, f8, vector, vector, run_record, vector, integers, vector
)  # machine t h t1 w sw run p modes lam
VANISHING = f8(integers, f8, f8, i8, vector, run_record, vector)  # machine t h state w run p
PASSED = i8(integers, f8, f8, vector, run_record, vector)  # machine t h w run p

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
Stages = types.FunctionType(STAGES)
Error = types.FunctionType(ERROR)
Dense = types.FunctionType(DENSE)
Propose = types.FunctionType(PROPOSE)
Hook = types.FunctionType(HOOK)
Correct = types.FunctionType(CORRECT)
Slope = types.FunctionType(SLOPE)
Field = types.FunctionType(FIELD)
Impact = types.FunctionType(IMPACT)
ReturnHeld = types.FunctionType(RETURN_HELD)
Transition = types.FunctionType(TRANSITION)
Limit = types.FunctionType(LIMIT)
Reactions = types.FunctionType(REACTIONS)
SwitchedReactions = types.FunctionType(SWITCHED_REACTIONS)
Attempt = types.FunctionType(ATTEMPT)
Repartition = types.FunctionType(REPARTITION)
Locate = types.FunctionType(LOCATE)
Sampled = types.FunctionType(SAMPLED)
Margins = types.FunctionType(MARGINS)
Settle = types.FunctionType(SETTLE)
FirstStep = types.FunctionType(FIRST_STEP)
Emit = types.FunctionType(EMIT)
Watch = types.FunctionType(WATCH)
Vanishing = types.FunctionType(VANISHING)
Passed = types.FunctionType(PASSED)


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
