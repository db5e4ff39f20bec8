"""Whether the force along a scalar s gives an impulse where s jumps with a moving place.

While s goes by Δs in a time ε its rate is Δs/ε, and the impulse is about ε f(Δs/ε): that of a
damper stays as ε vanishes, that of a force with a bound does not.
"""

from collections.abc import Callable

import numpy as np

from runtime.core.array_types import Vector
from runtime.explicit_time.function_scan import FunctionArrays
from runtime.explicit_time.instants import Kink
from runtime.mechanism.table_rows import TimeFunction

_FAST, _FASTER = 1e3, 1e12  # safety: of sizes and speeds; rates at which a force is judged
_GROWS = 1e-2  # safety: ratio of f/ṡ at these; of f ~ ṡ it is 1, of a root of ṡ 3e-5
_SLOPE = 1e-6  # accuracy: of the size; difference of coordinates by which s_q is found
_NONE = 1e-300  # safety: a divisor that is not zero
_MOVED = 1e-9  # accuracy: of the size; a smaller jump of s has no direction


def acts(place: TimeFunction, kink: Kink, q: Vector, v: Vector, p: Vector, size: float) -> bool:
    """Whether an impulse comes where `place` jumps at `kink` in the state (q, v), (n,) each.

    `p` are the parameters, `size` is the largest typical size of a coordinate.
    """
    n, fastest = len(q), size + float(np.abs(v).max(initial=0.0))
    begin = {"q": len(p), "v": len(p) + n}
    for rows in place.along:
        scalar, force = (FunctionArrays(one, begin=begin) for one in rows)

        def s(t: float, q: Vector, of: FunctionArrays = scalar) -> float:
            return of.value(t, np.concatenate([p, q, v, [0.0]]))

        moved = s(kink.after, q) - s(kink.before, q)
        ways = (np.sign(moved),) if abs(moved) > _MOVED * size else (-1.0, 1.0)
        for t in (kink.before, kink.after):
            slopes = _slopes(s, t, q, _SLOPE * size)
            # what p, q, v and the rate are, and how they change with the rate
            here = np.concatenate([p, q, v, [slopes @ v]])
            toward = np.zeros(len(here))
            toward[begin["v"] :] = *(slopes / max(float(slopes @ slopes), _NONE)), 1.0
            if any(_grows(force, t, here, way * fastest * toward) for way in ways):
                return True
    return False


def _slopes(s: Callable[[float, Vector], float], t: float, q: Vector, step: float) -> Vector:
    """s_q, (n,), by central differences."""
    ways = step * np.eye(len(q))
    return np.array([(s(t, q + way) - s(t, q - way)) / (2.0 * step) for way in ways])


def _grows(force: FunctionArrays, t: float, here: Vector, way: Vector) -> bool:
    """Whether a force grows as its rate does, or faster, towards where `way` leads."""
    rest = force.value(t, here)
    near, far = (abs(force.value(t, here + k * way) - rest) / k for k in (_FAST, _FASTER))
    return not np.isfinite(far) or far > _GROWS * near
