"""A scene's kernels, and their exact derivatives, as the system that the integrator takes."""

from types import ModuleType
from typing import NamedTuple

from runtime.core.arrays import Integers, Kernel
from runtime.core.kernel_abi import Kernels
from runtime.core.kinds import PeakKind
from runtime.core.system import System
from runtime.mechanism.module_tables import Description


class Tangents(NamedTuple):
    """The compiled derivatives of a scene, along one direction (dq, dv) a call."""

    # (t, q, v, p, modes, dq, dv, da): da = (∂a/∂q) dq + (∂a/∂v) dv of what `accelerations` returns,
    # the modes fixed. All of q, v, dq, dv, da have shape (n,), SI units.
    accelerations_tangent: Kernel
    # (t, q, v, p, w, dq_in, dv_in, dq, dv): the same for both answers of `correction`. At a state
    # on the constraints, with w = 0 on the independent coordinates: e_k plus dq along (e_k, 0) is
    # the column H e_k of δq = H δq_independent, in which the dependent rows are -Φ_u⁻¹ Φ_v (R. A.
    # Wehage and E. J. Haug, Journal of Mechanical Design 104, 1982, 247-255); dv along (H e_k, 0)
    # is what that does to the dependent velocities.
    correction_tangent: Kernel


def gather_tangents(module: ModuleType) -> Tangents:
    """Take the derivatives out of a loaded module that has them."""
    return Tangents(*(getattr(module, name) for name in Tangents._fields))


def common_system(
    description: Description, kernels: Kernels, rows: Integers, columns: Integers, n: int, m: int
) -> System:
    """The entries common to all formulations; `rows`, `columns`: of the Jacobian's non-zeros."""
    sampled = description.sampled
    return System(
        **vars(kernels),
        jacobian_rows=rows,
        jacobian_columns=columns,
        coordinates=n,
        constraint_count=m,
        switches=len(description.switches),
        rigid=tuple(contact.switch for contact in description.rigid),
        sticking=tuple(k for k, row in enumerate(description.switches) if row.sticks),
        one_way=tuple(k for k, row in enumerate(description.switches) if row.one_way),
        boundaries=tuple(description.boundaries.tolist()),
        table_parts=description.table_parts,
        states=description.state_columns,
        sampled=description.sampled_columns,
        sampled_names=sampled,
        triggers=description.triggers or (-1,) * len(sampled),
        watches=tuple(int(row.action != "sample") for row in description.watched),
        controllers=tuple(map(sampled.index, description.controllers)),
        peaks=tuple((PeakKind[kind.upper()], exponent) for _, kind, exponent in description.peaks),
    )
