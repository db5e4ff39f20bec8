"""Balance of energy between samples, for runs in reduced coordinates, whose loop knows no energy.

Where nothing but potentials acts, the energy stays. Where powers act, they are integrated between
the samples if these are the ends of steps: by Gauss' rule, on the quintic through positions,
velocities and accelerations. Scenes with switches or kinks of functions of time are not judged.
"""

import numpy as np
from numpy.polynomial import polynomial

from runtime.dynamics.output_quantities import evaluate
from runtime.integrate.energy_tolerances import CERTAIN, ERRORS, PART, ROUNDING
from runtime.integrate.problem import Options
from runtime.integrate.sampling import NODES, WEIGHTS
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.samples import Samples

_WAYS = (1e-9, 1e-6)  # measured: of coordinates' sizes, at which rounding is looked for
_WORST = 3  # safety: changes that are judged, the largest of a run


def describe_unexplained_energy(
    equations: Equations, samples: Samples, sizes: FloatArray, options: Options, steps: int
) -> str:
    """A sentence on a change of energy that the tolerances do not permit; empty for none.

    Between two samples lie `steps` steps at most, or one where the samples are the ends of steps.
    """
    description, t, q = equations.description, samples.t, samples.q
    rows = description.balanced_rows
    if len(t) < 2 or rows < 0 or description.switches:
        return ""
    if rows and (options.t_eval is not None or description.time_functions):
        return ""
    if not rows and equations.velocity_rhs(float(t[0]), q[0]).any():
        return ""
    within = 2 if options.t_eval is None else 1 + steps
    change, power = np.diff(samples.energy.sum(axis=1)), samples.power[:, :rows].sum(axis=1)
    left = np.abs(change - 0.5 * np.diff(t) * (power[1:] + power[:-1]))
    for k in np.sort(np.argsort(left)[-_WORST:]):
        ends, work = (k, k + 1), 0.0
        permitted = within * max(_permit(equations, samples, i, sizes, options) for i in ends)
        if abs(left[k]) <= permitted:
            continue
        permitted += CERTAIN * max(_rounding(equations, samples, i, sizes) for i in ends)
        if rows:
            (work, size), (rougher, _) = (_work(equations, samples, k, m) for m in (3, 2))
            permitted += abs(work - rougher) + PART * (size + abs(change[k]))
        if abs(change[k] - work) > permitted:  # what is no number is not judged
            what = f"powers do {work:.6g} J of work" if rows else "nothing does work"
            return (
                f"From t = {t[k]:.9g} to {t[k + 1]:.9g} s the energy changes by {change[k]:.6g} J, "
                f"and {what}."
            )
    return ""


def _work(equations: Equations, samples: Samples, k: int, known: int) -> tuple[float, float]:
    """Work of the powers from a sample to the next, and what they exchange, J.

    The path fits the first `known` of positions, velocities and accelerations at both ends.
    """
    pair, description = slice(k, k + 2), equations.description
    h = float(samples.t[k + 1] - samples.t[k])
    unit = np.eye(2 * known)
    fits = [
        polynomial.polyval(x, polynomial.polyder(unit, d)) for x in (0, 1) for d in range(known)
    ]
    ends = [samples.q[pair], h * samples.v[pair], h * h * samples.a[pair]][:known]
    path = np.linalg.solve(np.array(fits), np.concatenate(np.stack(ends, axis=1)))
    x = 0.5 * (1.0 + np.array(NODES))
    q, v = (polynomial.polyval(x, c).T for c in (path, polynomial.polyder(path) / h))
    modes = np.repeat(samples.modes[k : k + 1], len(x), axis=0)
    t = samples.t[k] + x * h
    powers = evaluate(equations.mechanism, equations.p, t, q, v, modes).power
    power = 0.5 * h * powers[:, : description.balanced_rows].sum(axis=1)
    return float(WEIGHTS @ power), float(WEIGHTS @ np.abs(power))


def _permit(
    equations: Equations, samples: Samples, k: int, sizes: FloatArray, options: Options
) -> float:
    """By how much the tolerances permit the energy of a sample to err in a step, J."""
    t, q, v, modes = float(samples.t[k]), samples.q[k], samples.v[k], samples.modes[k]
    atol = options.atol_q, options.atol_v
    of_q, of_v = (options.rtol * np.minimum(1.0, sizes) if x is None else x for x in atol)
    mass, errors = equations.mass(q), of_v + options.rtol * np.abs(v)
    least, kinetic = 0.5 * float(errors @ mass @ errors), float(samples.energy[k, 0])
    gradient = np.abs(equations.potential_gradient(t, q, modes))
    error = 2.0 * np.sqrt(least * kinetic) + least
    error += float(gradient @ (of_q + options.rtol * np.abs(q)))
    return float(ERRORS * error + ROUNDING * np.abs(samples.energy[k]).sum())


def _rounding(equations: Equations, samples: Samples, k: int, sizes: FloatArray) -> float:
    """By how much the potential misses its slope along short ways from a sample, J."""
    t, q, modes = float(samples.t[k]), samples.q[k], samples.modes[k]
    slope, missed = equations.potential_gradient(t, q, modes), 0.0
    for way in _WAYS:
        for part in (-3.0, -2.0, -1.0, 1.0, 2.0, 3.0):
            there = q + part * way * sizes
            between = 0.5 * (slope + equations.potential_gradient(t, there, modes))
            rise = equations.potential(t, there, modes) - equations.potential(t, q, modes)
            missed = max(missed, abs(rise - float(between @ (there - q))))
    return missed
