"""The passes that are left give the machine code that all of numba's give."""

import re
from typing import Any

import numba
import numpy as np
import pytest

from codegen.scalar_compiler import ScalarCompiler

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}, "_nrt": False}


def norm_of_rows(x: Any, out: Any) -> int:
    """Loops, choices, calls of elementary functions, early returns."""
    for i in range(x.shape[0]):
        total = 0.0
        for j in range(x.shape[1]):
            if x[i, j] != x[i, j]:
                return i + 1
            total += x[i, j] * x[i, j]
        out[i] = np.sqrt(total) if total > 1.0 else min(total, -total)
    return 0


def machine_code(**options: object) -> str:
    compiled = numba.njit("i8(f8[:, ::1], f8[::1])", **OPTIONS, **options)(norm_of_rows)
    (text,) = compiled.inspect_asm().values()
    return re.sub(r"norm_of_rowsB?\d*B?v?\d*", "f", text)


def test_the_machine_code_is_that_of_all_passes() -> None:
    assert machine_code(pipeline_class=ScalarCompiler) == machine_code()


def test_code_that_makes_arrays_of_whole_arrays_does_not_compile() -> None:
    def doubled(x: Any) -> Any:
        return [2.0 * y for y in x]

    with pytest.raises(numba.core.errors.NumbaError):
        numba.njit("f8[::1](f8[::1])", pipeline_class=ScalarCompiler, **OPTIONS)(doubled)
