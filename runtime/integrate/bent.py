"""The field where it is not the machine's own: along surfaces of switching conditions."""

from runtime.compiled import compiled
from runtime.integrate.signatures import FIELD, Integers, Vector
from runtime.integrate.slots import accelerations_of


@compiled(FIELD)
def bent(
    machine: Integers,
    t: float,
    q: Vector,
    v: Vector,
    p: Vector,
    modes: Integers,
    a: Vector,
    lam: Vector,
) -> int:
    """Accelerations and multipliers; as `accelerations`."""
    return int(accelerations_of(machine)(t, q, v, p, modes, a, lam))
