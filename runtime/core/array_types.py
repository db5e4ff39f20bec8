"""Types of what compiled code hands on: arrays for readers and type checkers, and for numba."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Integers = NDArray[np.int64]
IntegerMatrix = NDArray[np.int64]
Kernel = Callable[..., Any]
Context = Any  # a function table in compiled code: numbers by their slots, arrays by their names

f8 = types.float64
i8 = types.int64
none = types.none
vector = types.Array(f8, 1, "C")
matrix = types.Array(f8, 2, "C")
integers = types.Array(i8, 1, "C")
integer_matrix = types.Array(i8, 2, "C")
tuple_type: Callable[..., Any] = types.Tuple
named_tuple_type: Callable[..., Any] = types.NamedTuple  # its members, and the Python class
