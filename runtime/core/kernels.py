"""The kernels of a generated module as one value, and their types for compiled code.

A compiled loop that takes kernels as first-class functions declares its arguments with the types
in `TYPES`, is compiled once, and never again for a new model.
"""

from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import types

from runtime.core.jit import addresses, at, compiled

Kernel = Callable[..., Any]

SCALAR = types.float64
VECTOR = types.float64[::1]
MATRIX = types.float64[:, ::1]
MODES = types.int64[::1]
MODE_ROWS = types.int64[:, ::1]

# What holds on to its surface (absent where a scene has none such): with q̈₀ and q̈₁ of modes 0 and
# 1, a switch is held at g = 0 by q̈₀ + α (q̈₁ - q̈₀).
#   holds(p, low, high)                  bounds of α, (s,) each; [0, 1] but for static friction
#   gap_accelerations(t, q, v, a, p, out)  d²g/dt² of the rigid contacts, (r,), in order of RIGID
#   restitution(p, out)                  e of the rigid contacts, (r,)
#   contact_scale(p, out)                F0 in N, (r,): a contact's reaction in mode 0; with
#                                        α = 1 - α' it is α' F0, α' from 0 to infinity
#   switched_reactions(t, q, v, p, modes, lam, out)  the rows of REACTIONS that modes decide;
#                                        `reactions` fills the others of the same array. Between
#                                        modes they mix as q̈ and λ do.
# Of a switch in SOUGHT there is a mode 2: its friction exerts the force that stands in p behind the
# parameters, at the place that it has in SOUGHT.
SIGNATURES = {
    "constants": types.none(VECTOR),
    "constraints": types.none(SCALAR, VECTOR, VECTOR, VECTOR),
    "jacobian": types.none(SCALAR, VECTOR, VECTOR, VECTOR),
    "velocity_rhs": types.none(SCALAR, VECTOR, VECTOR, VECTOR),
    "acceleration_rhs": types.none(SCALAR, VECTOR, VECTOR, VECTOR, VECTOR),
    "mass": types.none(VECTOR, VECTOR, VECTOR),
    "applied_forces": types.none(SCALAR, VECTOR, VECTOR, VECTOR, MODES, VECTOR),
    "accelerations": types.int64(SCALAR, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR),
    "correction": types.int64(SCALAR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR),
    "potential": SCALAR(SCALAR, VECTOR, VECTOR, MODES),
    "potential_gradient": types.none(SCALAR, VECTOR, VECTOR, MODES, VECTOR),
    "kinetic_energy": SCALAR(VECTOR, VECTOR, VECTOR),
    "powers": types.none(SCALAR, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR),
    "reactions": types.none(SCALAR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR),
    "switching": types.none(SCALAR, VECTOR, VECTOR, VECTOR, VECTOR),
    "switching_rates": types.none(SCALAR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR),
    "holds": types.none(VECTOR, VECTOR, VECTOR),
    "gap_accelerations": types.none(SCALAR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR),
    "restitution": types.none(VECTOR, VECTOR),
    "contact_scale": types.none(VECTOR, VECTOR),
    "switched_reactions": types.none(SCALAR, VECTOR, VECTOR, VECTOR, MODES, VECTOR, VECTOR),
}
TYPES = {name: types.FunctionType(signature) for name, signature in SIGNATURES.items()}
FETCH = {name: at(kind, slot) for slot, (name, kind) in enumerate(TYPES.items())}
"""Kernel → what takes it, inside compiled code, out of the table of a machine's kernels."""


class Kernels(NamedTuple):
    """The compiled functions of a scene; the arguments are those of the generated module."""

    constants: Kernel
    constraints: Kernel
    jacobian: Kernel
    velocity_rhs: Kernel
    acceleration_rhs: Kernel
    mass: Kernel
    applied_forces: Kernel
    accelerations: Kernel
    correction: Kernel
    potential: Kernel
    potential_gradient: Kernel
    kinetic_energy: Kernel
    powers: Kernel
    reactions: Kernel
    switching: Kernel
    switching_rates: Kernel
    holds: Kernel
    gap_accelerations: Kernel
    restitution: Kernel
    contact_scale: Kernel
    switched_reactions: Kernel

    def table(self) -> npt.NDArray[np.int64]:
        """Addresses in the order of the fields, for compiled loops."""
        return addresses(self)


def gather(module: ModuleType) -> Kernels:
    """Take the kernels out of a loaded module; what the scene does not need becomes a no-op."""
    return Kernels(*(getattr(module, name, None) or _absent(name) for name in Kernels._fields))


def _absent(name: str) -> Kernel:
    """Stand-in of the right signature for a kernel that a scene has no use for."""
    substitutes: dict[str, Kernel] = {
        "acceleration_rhs": _not_asked_rhs,
        "accelerations": _not_asked_accelerations,
        "correction": _not_asked_correction,
        "mass": _no_mass,
        "applied_forces": _no_forces,
        "potential": _no_potential,
        "potential_gradient": _no_gradient,
        "kinetic_energy": _no_energy,
        "powers": _no_powers,
        "reactions": _no_reactions,
        "switching": _no_switching,
        "switching_rates": _no_rates,
        "holds": _plain_holds,
        "gap_accelerations": _no_rates,
        "restitution": _no_contacts,
        "contact_scale": _no_contacts,
        "switched_reactions": _no_powers,
    }
    kernel: Kernel = compiled(SIGNATURES[name])(substitutes[name])
    return kernel


def _not_asked_rhs(t: Any, q: Any, v: Any, p: Any, gamma: Any) -> None:
    gamma[:] = np.nan


def _not_asked_accelerations(t: Any, q: Any, v: Any, p: Any, modes: Any, a: Any, lam: Any) -> int:
    a[:] = np.nan
    lam[:] = np.nan
    return 0


def _not_asked_correction(t: Any, q: Any, v: Any, p: Any, w: Any, dq: Any, dv: Any) -> int:
    dq[:] = np.nan
    dv[:] = np.nan
    return 0


def _no_mass(q: Any, p: Any, values: Any) -> None:
    return


def _no_forces(t: Any, q: Any, v: Any, p: Any, modes: Any, force: Any) -> None:
    force[:] = 0.0


def _no_potential(t: Any, q: Any, p: Any, modes: Any) -> float:
    return 0.0


def _no_gradient(t: Any, q: Any, p: Any, modes: Any, g: Any) -> None:
    g[:] = 0.0


def _no_energy(q: Any, v: Any, p: Any) -> float:
    return 0.0


def _no_powers(t: Any, q: Any, v: Any, p: Any, modes: Any, lam: Any, out: Any) -> None:
    return


def _no_reactions(t: Any, q: Any, v: Any, p: Any, lam: Any, out: Any) -> None:
    return


def _no_switching(t: Any, q: Any, v: Any, p: Any, g: Any) -> None:
    return


def _no_rates(t: Any, q: Any, v: Any, a: Any, p: Any, rate: Any) -> None:
    return


def _plain_holds(p: Any, low: Any, high: Any) -> None:
    low[:] = 0.0
    high[:] = 1.0


def _no_contacts(p: Any, out: Any) -> None:
    return
