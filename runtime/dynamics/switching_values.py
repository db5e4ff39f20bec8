"""Values of the switching functions at many states: compiled, and loaded where there are any."""

from typing import Any

from runtime.core.array_types import f8, integer_matrix, integers, matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import switching_of
from runtime.core.modes_and_event_kinds import SLIDING


@compiled(none(ADDRESSES, vector, matrix, matrix, vector, matrix))
def write_switching_values(kernels: Any, t: Any, q: Any, v: Any, p: Any, out: Any) -> None:
    """Write g at the states (t, q, v), (k,) and (k, n), into `out`, (k, s)."""
    evaluate = switching_of(kernels)
    for i in range(t.size):
        evaluate(t[i], q[i], v[i], p, out[i])


@compiled(
    none(ADDRESSES, vector, matrix, matrix, f8, integer_matrix, vector, matrix, vector, vector)
)
def measure_sides(
    kernels: Any, t: Any, q: Any, v: Any, way: Any, modes: Any, p: Any, scratch: Any,
    largest: Any, opposed: Any,
) -> None:  # fmt: skip
    """Raise `largest`, (s,), to the largest |g| at states, and `opposed` to that of a wrong sign.

    The first k states, (t, q, v), are moved along v by the time `way`, s, and `modes`, (k, s), say
    which sign is right. `scratch` has two rows, as long as g and q at least.
    """
    evaluate = switching_of(kernels)
    values, moved = scratch[0, : modes.shape[1]], scratch[1, : q.shape[1]]
    for i in range(modes.shape[0]):
        for j in range(moved.size):
            moved[j] = q[i, j] + way * v[i, j]
        evaluate(t[i] + way, moved, v[i], p, values)
        for k in range(values.size):
            side = 0 if modes[i, k] == SLIDING else 2 * modes[i, k] - 1
            largest[k] = max(largest[k], abs(values[k]))
            opposed[k] = max(opposed[k], -side * values[k])


@compiled(none(ADDRESSES, integers, vector, matrix, matrix, vector, vector, vector))
def write_changes(
    kernels: Any, switches: Any, t: Any, states: Any, changes: Any, p: Any, g: Any, out: Any
) -> None:
    """Add to `out`, (k,), by how much g of one switch each changes with all of (q, v) in turn.

    States and what each of their numbers changes by are (k, 2n); `g`, (s,), is written over.
    """
    evaluate, n = switching_of(kernels), states.shape[1] // 2
    for i in range(switches.size):
        q, v = states[i, :n], states[i, n:]
        evaluate(t[i], q, v, p, g)
        here = g[switches[i]]
        for j in range(states.shape[1]):
            before = states[i, j]
            states[i, j] = before + changes[i, j]
            evaluate(t[i], q, v, p, g)
            out[i] += abs(g[switches[i]] - here)
            states[i, j] = before
