"""Values of the switching functions at many states: compiled, loaded where modes are doubted."""

from typing import Any

from runtime.core.array_types import matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import switching_of


@compiled(none(ADDRESSES, vector, matrix, matrix, vector, matrix))
def write_switching_values(kernels: Any, t: Any, q: Any, v: Any, p: Any, out: Any) -> None:
    """Write g at the states (t, q, v), (k,) and (k, n), into `out`, (k, s)."""
    evaluate = switching_of(kernels)
    for i in range(t.size):
        evaluate(t[i], q[i], v[i], p, out[i])
