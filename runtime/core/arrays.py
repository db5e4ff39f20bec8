"""Types and views of arrays, and the precision of their numbers.

The views that compiled code makes own nothing and cost nothing. The base must outlive them, which
holds for workspaces: the caller of compiled code owns them.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from codegen.machine_code import table_values

EPS = 2.0**-52  # distance from 1.0 to the next float64, the relative spacing of numbers


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


view: Callable[[Any, int, int | tuple[int, int]], Any] = table_values.view
"""A contiguous array in a flat float64 or int64 one from element `start` on; bounds unchecked.

The last argument is its length, or its numbers of rows and columns.
"""
