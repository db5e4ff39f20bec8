"""Ways in from Python to the return and the partition, which only compiled code calls."""

import numpy as np

from runtime.constraints import newton_return, partitioning, repartitioning
from runtime.core.arrays import Vector, f8, i8, integers, vector
from runtime.core.jit import compiled
from runtime.core.kernel_abi import SIGNATURES
from runtime.core.system import System
from runtime.core.workspace_rows import PARTITION, PROJECTION, ROWS, SIZE
from runtime.integrate.wiring import Wiring, wire
from tests.runtime.integrate.systems import PENDULUM, PENDULUM_P


@compiled(i8(integers, f8, i8, i8))
def return_to_constraints(context, t, row, weighing):
    return newton_return.return_to_constraints(context, t, row, weighing)


@compiled(i8(integers, f8, i8))
def repartition(context, t, state):
    return repartitioning.repartition(context, t, state)


@compiled(i8(integers, f8))
def is_poorly_chosen(context, t):
    return int(repartitioning.is_poorly_chosen(context, t))


@compiled(i8(integers, f8, vector))
def choose_independent(context, t, q):
    return partitioning.choose_independent(context, t, q)


@compiled(f8(integers, f8, i8))
def column_norm(context, t, independent):
    return partitioning.column_norm(context, t, independent)


@compiled(SIGNATURES["correction"])
def lever(t, q, v, p, w, dq, dv):
    """Coordinates a, b, c with b = 2 a - 0.5 c + 3 t, of which b is dependent."""
    dq[0], dq[1], dq[2] = 0.0, 2.0 * q[0] - 0.5 * q[2] + 3.0 * t - q[1], 0.0
    dv[0], dv[1], dv[2] = 0.0, 2.0 * v[0] - 0.5 * v[2] + 3.0 - v[1], 0.0
    return 0


SCALE = np.array([1.0, 1.0, 10.0])


def wired(
    system: System = PENDULUM, p: Vector = PENDULUM_P, scale: Vector = SCALE
) -> tuple[Wiring, Vector]:
    """The table of a run, and its workspace as (rows, 2, n), with sizes and scales written."""
    wiring = wire(system, "dopri5", p, 8)
    rows = wiring.arrays["workspace"].reshape(ROWS, 2, -1)
    rows[SIZE] = 1.0
    rows[PARTITION, 1] = scale
    rows[PROJECTION, 0] = scale**2
    return wiring, rows
