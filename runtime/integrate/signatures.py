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

from runtime.compiled import compiled

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

Accelerations = types.FunctionType(ACCELERATIONS)
Correction = types.FunctionType(CORRECTION)
Jacobian = types.FunctionType(JACOBIAN)
Switching = types.FunctionType(SWITCHING)
SwitchingRates = types.FunctionType(SWITCHING_RATES)

# Newton's return onto the constraints, `constraints.correction.correct`: t row weighing w p.
CORRECT = i8(Correction, f8, i8, i8, vector, vector)
Correct = types.FunctionType(CORRECT)

# Functions of an explicit method; `w` is the workspace laid out in `workspace`.
STAGES = i8(
    Accelerations, Correction, Correct, f8, f8, vector, vector, integers, vector, i8
)  # t h w p modes lam each_stage; Newton iterations, negative where one failed
ERROR = f8(f8, f8, vector)  # h rtol w; the error over the tolerance, root mean square
DENSE = i8(
    Accelerations, Correction, Correct, f8, f8, vector, vector, integers, vector, i8
)  # t h w p modes lam each_stage; as STAGES

Stages = types.FunctionType(STAGES)
Error = types.FunctionType(ERROR)
Dense = types.FunctionType(DENSE)


@compiled(SWITCHING)
def no_switching(t: float, q: Vector, v: Vector, p: Vector, g: Vector) -> None:
    """Stand in for `switching` where a model has no switching function."""


@compiled(SWITCHING_RATES)
def no_switching_rates(t: float, q: Vector, v: Vector, a: Vector, p: Vector, rate: Vector) -> None:
    """Stand in for `switching_rates` where a model has no switching function."""
