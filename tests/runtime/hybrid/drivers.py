"""Ways in from Python to hybrid dynamics that compiled code alone calls; numba keeps them."""

from runtime.core.array_types import f8, i8, integers, vector
from runtime.core.jit import compiled
from runtime.hybrid import degenerate_sliding


@compiled(i8(integers, vector, vector, i8, vector, f8))
def solve_least(context, matrix, right, count, reach, slack):
    return degenerate_sliding.solve_least(context, matrix, right, count, reach, slack)
