"""The kernels of a machine, declared once: names, arguments, types, and stand-ins.

Kernels reach compiled loops by their addresses, as values of a `numba.types.FunctionType`, so that
a loop is compiled once for these types and never again for another model. A kernel fits when it
was compiled with exactly the signature that follows from its line in `Kernels`.
"""
# ruff: noqa: RUF009  (`_kernel` answers with a field of the dataclass)

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache, partial
from types import ModuleType
from typing import Any

import numpy as np
from numba import types

from runtime.core.arrays import Integers, Kernel, f8, i8, integers, none, vector
from runtime.core.jit import addresses, at, compiled

SIGNATURES: dict[str, Any] = {}  # Kernel → the signature that it is compiled for

_STAND_INS: dict[str, Kernel] = {}


def _kernel(name: str, arguments: str, stand_in: Kernel, returns: Any = none) -> Kernel:
    """Declare a kernel: t is a number, modes are integers, all else is an array of floats."""
    kinds = {"t": f8, "modes": integers}
    SIGNATURES[name] = returns(*(kinds.get(argument, vector) for argument in arguments.split()))
    _STAND_INS[name] = stand_in
    made: Kernel = field(default_factory=partial(find_stand_in, name))
    return made


@cache
def find_stand_in(name: str) -> Kernel:
    """What takes the place of a kernel that a scene or a method has no use for."""
    return compiled(SIGNATURES[name])(_STAND_INS[name])


# Stand-ins that leave what they are handed as it is, by the number of their arguments.
def _skip_1(p: Any) -> None: ...
def _skip_2(p: Any, out: Any) -> None: ...
def _skip_3(q: Any, p: Any, out: Any) -> None: ...
def _skip_4(t: Any, q: Any, p: Any, out: Any) -> None: ...
def _skip_5(t: Any, q: Any, v: Any, p: Any, out: Any) -> None: ...
def _skip_6(t: Any, q: Any, v: Any, p: Any, a: Any, out: Any) -> None: ...
def _skip_7(t: Any, q: Any, v: Any, p: Any, modes: Any, lam: Any, out: Any) -> None: ...
def _skip_8(t: Any, q: Any, v: Any, p: Any, modes: Any, dq: Any, dv: Any, da: Any) -> None: ...
def _skip_9(t: Any, q: Any, v: Any, p: Any, w: Any, x: Any, y: Any, dq: Any, dv: Any) -> None: ...


def _undefined_gamma(t: Any, q: Any, v: Any, p: Any, gamma: Any) -> None:
    gamma[:] = np.nan


def _undefined_pair(t: Any, q: Any, v: Any, p: Any, choice: Any, first: Any, second: Any) -> int:
    """Two results that nothing defines; `choice` is the modes, or the weights of a correction."""
    first[:] = np.nan
    second[:] = np.nan
    return 0


def _no_forces(t: Any, q: Any, v: Any, p: Any, modes: Any, force: Any) -> None:
    force[:] = 0.0


def _no_potential(t: Any, q: Any, p: Any, modes: Any) -> float:
    return 0.0


def _no_gradient(t: Any, q: Any, p: Any, modes: Any, gradient: Any) -> None:
    gradient[:] = 0.0


def _no_energy(q: Any, v: Any, p: Any) -> float:
    return 0.0


def _no_profile(t: Any, p: Any, out: Any) -> None: ...


def _no_samples(t: Any, q: Any, v: Any, p: Any, due: Any, out: Any) -> None: ...


def _full_shares(p: Any, low: Any, high: Any) -> None:
    low[:] = 0.0
    high[:] = 1.0


@dataclass(frozen=True, eq=False)
class Kernels:
    """The compiled functions of a scene, SI units; those that it has no use for are stand-ins.

    Each writes into its last arrays and can be called from Python and from compiled code.
    `Machine.parameter_values` makes p and `Machine.initial_modes` modes; n coordinates, m
    constraints, s switches, r rigid contacts and all names are those of the machine's tables, in
    their order. docs/reference/kernels.md has an example.

    t: instant, s. q, v, a: coordinates, velocities, accelerations, (n,), of `Machine.coordinates`.
    p: parameters, then constants that follow from them, (np,). modes: (s,) int64, 0 or 1, or 2
    where a switching function stays at zero. lam: multipliers λ, (m,), of `Machine.constraints`.
    All other arrays hold float64 and are contiguous.

    constants(p)
        Writes the constants behind the parameters.
    constraints(t, q, p, phi)
        Φ, (m,), m or rad.
    jacobian(t, q, p, values)
        Structural non-zeros of Φ_q, row-major, at `description.jacobian_rows` and
        `description.jacobian_columns`.
    velocity_rhs(t, q, p, nu)
        ν = -Φ_t, (m,).
    acceleration_rhs(t, q, v, p, gamma)
        γ = -(Φ_q v)_q v - 2 Φ_qt v - Φ_tt, (m,).
    mass(q, p, values)
        Structural non-zeros of M, at `description.mass_rows`, `description.mass_columns`.
    applied_forces(t, q, v, p, modes, force)
        Generalized forces Q of the effects, (n,), without friction from reactions.
    accelerations(t, q, v, p, modes, a, lam)
        a, (n,), and λ, (m,), of M a + Φ_qᵀ λ = Q, Φ_q a = γ. Answers 0, or 1 + the row of the
        constraint whose pivot is weak.
    correction(t, q, v, p, w, dq, dv)
        Least changes dq, dv, (n,) each, in the norm of weights w, (n,), that meet Φ = 0 and
        Φ_q v = ν to first order; w = 0 holds a coordinate. Answers as `accelerations`.
    potential(t, q, p, modes)
        Answers V, J.
    potential_gradient(t, q, p, modes, gradient)
        ∂V/∂q, (n,).
    kinetic_energy(q, v, p)
        Answers T, J.
    powers(t, q, v, p, modes, lam, out)
        Power of each row of `description.powers`, W.
    reactions(t, q, v, p, lam, out)
        Each row of `description.reactions`, N or N m, of those that no mode decides.
    switched_reactions(t, q, v, p, modes, lam, out)
        The others, into the same array; between modes they mix as a and λ do.
    derived_outputs(t, q, v, a, p, reaction)
        The rows that follow from accelerations and from the other rows, into the same array.
    switching(t, q, v, p, g)
        Switching functions, (s,): a condition holds where g > 0.
    switching_rates(t, q, v, a, p, rate)
        dg/dt, (s,).
    peak_arguments(t, q, v, p, modes, u, rate)
        Arguments of the functions in PEAKS, and their rates.
    holds(p, low, high)
        Bounds of α, (s,) each: [0, 1] but for static friction. In sliding modes the acceleration
        is a₀ + α (a₁ - a₀), of modes 0 and 1. A switch in STICTION has a mode 2: its friction
        exerts the force that stands in p behind the parameters, in the order of STICTION.
    gap_accelerations(t, q, v, a, p, out)
        d²g/dt² of the rigid contacts, (r,), in the order of RIGID.
    restitution(p, out)
        Their e, (r,).
    contact_scale(p, out)
        F0, N, (r,): a contact's reaction in mode 0. With α = 1 - α' it is α' F0, α' from 0 to
        infinity.
    conditions(p, out)
        What the scene asks of its parameters, in the order of CONDITIONS.
    profiles(t, p, out)
        Functions of time that it asks something of, in the order of PROFILES.
    accelerations_tangent(t, q, v, p, modes, dq, dv, da)
        da, (n,), of `accelerations` along dq, dv, (n,) each; of a companion module.
    correction_tangent(t, q, v, p, w, dq_in, dv_in, dq, dv)
        The same of `correction`.
    dead_centres(t, q, v, p, out)
        x² of each loop in closed form, its rate, and the largest that it may be.
    samples(t, q, v, p, modes, out)
        Sampled values, of those in SAMPLED whose `modes`, here one each, is 1.
    clocks(p, out)
        Their periods and delays, s.
    watched(t, q, v, p, modes, out)
        1 where a condition of WATCHED holds, else 0.
    free_multipliers(t, q, p, out)
        Multipliers that exert no force, Φ_qᵀ λ = 0, `description.free` vectors one after the other,
        (m,) each; entries that are always 0 are not written.
    independent_constraints(t, q, p, phi)
        Φ of a scene in which constraints follow from others: independent rows in the place of all,
        and 0 in the places `description.redundant`, (m,); so the three below.
    independent_jacobian(t, q, p, values)
        Non-zeros at `description.independent_jacobian_rows` and `.independent_jacobian_columns`.
    independent_velocity_rhs(t, q, p, nu)
        ν, (m,).
    independent_acceleration_rhs(t, q, v, p, gamma)
        γ, (m,).
    """

    constants: Kernel = _kernel("constants", "p", _skip_1)
    constraints: Kernel = _kernel("constraints", "t q p phi", _skip_4)
    jacobian: Kernel = _kernel("jacobian", "t q p values", _skip_4)
    velocity_rhs: Kernel = _kernel("velocity_rhs", "t q p nu", _skip_4)
    acceleration_rhs: Kernel = _kernel("acceleration_rhs", "t q v p gamma", _undefined_gamma)
    mass: Kernel = _kernel("mass", "q p values", _skip_3)
    applied_forces: Kernel = _kernel("applied_forces", "t q v p modes force", _no_forces)
    accelerations: Kernel = _kernel("accelerations", "t q v p modes a lam", _undefined_pair, i8)
    correction: Kernel = _kernel("correction", "t q v p w dq dv", _undefined_pair, i8)
    potential: Kernel = _kernel("potential", "t q p modes", _no_potential, f8)
    potential_gradient: Kernel = _kernel("potential_gradient", "t q p modes gradient", _no_gradient)
    kinetic_energy: Kernel = _kernel("kinetic_energy", "q v p", _no_energy, f8)
    powers: Kernel = _kernel("powers", "t q v p modes lam out", _skip_7)
    reactions: Kernel = _kernel("reactions", "t q v p lam out", _skip_6)
    switching: Kernel = _kernel("switching", "t q v p g", _skip_5)
    switching_rates: Kernel = _kernel("switching_rates", "t q v a p rate", _skip_6)
    peak_arguments: Kernel = _kernel("peak_arguments", "t q v p modes u rate", _skip_7)
    holds: Kernel = _kernel("holds", "p low high", _full_shares)
    gap_accelerations: Kernel = _kernel("gap_accelerations", "t q v a p out", _skip_6)
    restitution: Kernel = _kernel("restitution", "p out", _skip_2)
    conditions: Kernel = _kernel("conditions", "p out", _skip_2)
    profiles: Kernel = _kernel("profiles", "t p out", _no_profile)
    contact_scale: Kernel = _kernel("contact_scale", "p out", _skip_2)
    switched_reactions: Kernel = _kernel("switched_reactions", "t q v p modes lam out", _skip_7)
    derived_outputs: Kernel = _kernel("derived_outputs", "t q v a p reaction", _skip_6)
    accelerations_tangent: Kernel = _kernel(
        "accelerations_tangent", "t q v p modes dq dv da", _skip_8
    )
    correction_tangent: Kernel = _kernel(
        "correction_tangent", "t q v p w dq_in dv_in dq dv", _skip_9
    )
    dead_centres: Kernel = _kernel("dead_centres", "t q v p out", _skip_5)
    samples: Kernel = _kernel("samples", "t q v p modes out", _no_samples)
    clocks: Kernel = _kernel("clocks", "p out", _skip_2)
    watched: Kernel = _kernel("watched", "t q v p modes out", _no_samples)
    free_multipliers: Kernel = _kernel("free_multipliers", "t q p out", _skip_4)
    independent_constraints: Kernel = _kernel("independent_constraints", "t q p phi", _skip_4)
    independent_jacobian: Kernel = _kernel("independent_jacobian", "t q p values", _skip_4)
    independent_velocity_rhs: Kernel = _kernel("independent_velocity_rhs", "t q p nu", _skip_4)
    independent_acceleration_rhs: Kernel = _kernel(
        "independent_acceleration_rhs", "t q v p gamma", _undefined_gamma
    )

    def table(self) -> Integers:
        """Addresses in the order of the fields, with which every function table begins.

        That of `derived_outputs` is 0 where the scene has none.
        """
        found = addresses(getattr(self, name) for name in KERNELS)
        found[DERIVED] *= self.derived_outputs is not find_stand_in("derived_outputs")
        return found


KERNELS = tuple(declared.name for declared in fields(Kernels))
"""Names of the kernels, in the order of their slots in every function table."""

DERIVED = KERNELS.index("derived_outputs")

TYPES = {name: types.FunctionType(SIGNATURES[name]) for name in KERNELS}
"""Kernel → its type as an argument of compiled code."""


def _fetcher(name: str) -> Callable[[Any], Any]:
    return at(TYPES[name], KERNELS.index(name))


# What takes a kernel out of a function table, inside compiled code.
constants_of = _fetcher("constants")
constraints_of = _fetcher("constraints")
jacobian_of = _fetcher("jacobian")
velocity_rhs_of = _fetcher("velocity_rhs")
acceleration_rhs_of = _fetcher("acceleration_rhs")
mass_of = _fetcher("mass")
applied_forces_of = _fetcher("applied_forces")
accelerations_of = _fetcher("accelerations")
correction_of = _fetcher("correction")
potential_of = _fetcher("potential")
potential_gradient_of = _fetcher("potential_gradient")
kinetic_energy_of = _fetcher("kinetic_energy")
powers_of = _fetcher("powers")
reactions_of = _fetcher("reactions")
switching_of = _fetcher("switching")
switching_rates_of = _fetcher("switching_rates")
peak_arguments_of = _fetcher("peak_arguments")
gap_accelerations_of = _fetcher("gap_accelerations")
switched_reactions_of = _fetcher("switched_reactions")
derived_outputs_of = _fetcher("derived_outputs")
accelerations_tangent_of = _fetcher("accelerations_tangent")
correction_tangent_of = _fetcher("correction_tangent")
dead_centres_of = _fetcher("dead_centres")
conditions_of = _fetcher("conditions")
profiles_of = _fetcher("profiles")
samples_of = _fetcher("samples")
watched_of = _fetcher("watched")
free_multipliers_of = _fetcher("free_multipliers")


def gather(module: ModuleType) -> Kernels:
    """Take the kernels out of a loaded module."""
    return Kernels(**{name: getattr(module, name) for name in KERNELS if hasattr(module, name)})
