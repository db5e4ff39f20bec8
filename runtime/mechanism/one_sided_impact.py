"""The impact of all joints, with contacts that are closed and freewheels, which only push."""

import numpy as np

from runtime.mechanism.dense_equations import Equations, FloatArray

_EXACT = 1e-12  # accuracy: of the fastest approach; slower ones are none
_REACHED = 1e-9  # accuracy: of the fastest approach; velocities that miss their conditions by more


class Contradiction(Exception):  # noqa: N818 (it is caught where joints engage)
    """Joints and contacts that permit no velocities; the message names the contacts."""


def rate_rows(equations: Equations, t: float, q: FloatArray) -> FloatArray:
    """By velocities, (s, n): derivatives of slips, and of the rates of gaps."""
    start = approaches(equations, t, q, np.zeros(equations.n))
    rows = [approaches(equations, t, q, one) - start for one in np.eye(equations.n)]
    return np.array(rows).T


def approaches(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
    """The rates of gaps, and all other switching functions as they are, (s,)."""
    found, rate = equations.switching(t, q, v), np.zeros(len(equations.description.switches))
    rigid = list(equations.mechanism.system.rigid)
    equations.kernels.switching_rates(t, q, v, np.zeros(equations.n), equations.p, rate)
    found[rigid] = rate[rigid]
    return found


def impact(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, band: float
) -> tuple[FloatArray, FloatArray]:
    """Velocities behind an impact, (n,), and the impulses Λ of the joints, (m,).

    M Δv + Φ_qᵀ Λ = Gᵀ P, Φ_q v⁺ = ν, P ≥ 0, G v⁺ ≥ 0, one of the two an equality, with the rates
    of gaps no wider than `band`, m or rad, and the slips of freewheels. Contacts that approach each
    other in that very instant rebound, ġ⁺ ≥ -e ġ⁻. Of all velocities that the conditions permit
    these are the nearest to those that the joints alone would leave, by the kinetic energy of the
    difference: C. L. Lawson and R. J. Hanson, Solving Least Squares Problems (1974), chapter 23.

    Raises
    ------
    Contradiction
        Where there are none, or the search for them does not end.
    """
    alone, multipliers = equations.impact(t, q, v)
    system, before = equations.mechanism.system, approaches(equations, t, q, v)
    gaps = equations.switching(t, q, v)
    contacts = [k for k in system.rigid if gaps[k] <= band]
    held = np.array([*contacts, *system.one_way], dtype=np.int64)
    if not len(held):
        return alone, multipliers
    restitution = np.zeros(len(system.rigid))
    equations.kernels.restitution(equations.p, restitution)
    target = np.zeros(len(before))
    target[list(system.rigid)] = -restitution * np.minimum(before[list(system.rigid)], 0.0)
    after = approaches(equations, t, q, alone)
    missing = (target - after)[held]
    fastest = float(np.abs([before[held], after[held]]).max())
    if missing.max() <= _EXACT * fastest:
        return alone, multipliers
    rows = rate_rows(equations, t, q)[held]
    change, forces = equations.responses(t, q, rows.T, np.zeros((equations.m, len(held))))
    try:
        pushes = _pushes(equations.mass(q), change, rows @ change, missing)
    except RuntimeError as found:
        names = [equations.description.switches[k].name for k in held]
        raise Contradiction(f"no impulses of {' and '.join(names)} were found with it") from found
    ended, reached = alone + change @ pushes, missing - rows @ change @ pushes
    if not reached.max() <= _REACHED * fastest:
        missed = held[~(reached <= _REACHED * fastest)]
        names = [equations.description.switches[k].name for k in missed]
        raise Contradiction(f"with it the joints move {' and '.join(names)} against what holds it")
    return ended, multipliers + forces @ pushes


def _pushes(
    mass: FloatArray, change: FloatArray, gains: FloatArray, missing: FloatArray
) -> FloatArray:
    """P ≥ 0, (k,), of the least ‖x‖ with Eᵀ x ≥ `missing`, x = E P and E = √M `change`."""
    from scipy.optimize import nnls  # other runs load none of it

    values, vectors = np.linalg.eigh(mass)
    root = vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    size = float(np.abs(missing).max())
    stacked = np.vstack([root @ change, missing / size])
    unit, _ = nnls(stacked, np.append(np.zeros(len(mass)), 1.0))
    rest = 1.0 - float(missing @ unit) / size
    pushes: FloatArray = size * unit / rest if rest > 0.0 else np.full(len(missing), np.nan)
    acting = np.flatnonzero(pushes > 0.0)
    exact = np.linalg.lstsq(gains[np.ix_(acting, acting)], missing[acting], rcond=None)[0]
    if (exact > 0.0).all():
        pushes[acting] = exact
    return pushes
