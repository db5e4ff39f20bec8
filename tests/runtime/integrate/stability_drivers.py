"""Ways in from Python to the stability limit, which compiled code alone calls."""

from runtime.core.arrays import f8, vector
from runtime.core.jit import compiled
from runtime.integrate import stability_limit


@compiled(f8(vector, f8, f8, f8))
def amplification(powers, h, k, c):
    return stability_limit.amplification(powers, h, k, c)


@compiled(f8(vector, vector, f8))
def stable_length(memory, powers, h):
    return stability_limit.stable_length(memory, powers, h)
