"""Values and changes of the switching functions: compiled, loaded where modes are doubted."""

from typing import Any

from runtime.core.array_types import f8, i8, matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import switching_of
from runtime.dynamics.end_check_screening import change_of_switch


@compiled(none(ADDRESSES, vector, matrix, matrix, vector, matrix))
def write_switching_values(kernels: Any, t: Any, q: Any, v: Any, p: Any, out: Any) -> None:
    """Write g at the states (t, q, v), (k,) and (k, n), into `out`, (k, s)."""
    evaluate = switching_of(kernels)
    for i in range(t.size):
        evaluate(t[i], q[i], v[i], p, out[i])


@compiled(f8(ADDRESSES, i8, f8, vector, vector, vector, vector))
def measure_change_of_switch(
    kernels: Any, k: Any, t: Any, state: Any, change: Any, p: Any, g: Any
) -> float:
    """By how much g of the switch number k changes with all of (q, v), (2n,), in turn.

    The state is put back; `g`, (s,), is written over.
    """
    return float(change_of_switch(kernels, k, t, state, change, p, g))
