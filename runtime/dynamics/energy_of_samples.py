"""Balance of energy between samples, for runs in reduced coordinates, whose loop knows no energy.

Where nothing but potentials acts, the energy stays; other scenes are not judged here.
"""

import numpy as np

from runtime.integrate.problem import Options
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.samples import Samples

_ERRORS = 50.0  # measured: tolerances of a step by which its energy may err, as in the loop
_ROUNDING = 1e-13  # accuracy: of an energy; rounding of the sums that it is made of
_CERTAIN = 16.0  # measured: times the rounding at a few states that two values may be apart
_WAYS = (1e-9, 1e-6)  # measured: of coordinates' sizes, at which rounding is looked for
_WORST = 3  # safety: changes that are judged, the largest of a run


def describe_unexplained_energy(
    equations: Equations, samples: Samples, sizes: FloatArray, options: Options, steps: int
) -> str:
    """A sentence on a change of energy that the tolerances do not permit; empty for none.

    Between two samples lie `steps` steps at most, or one where the samples are the ends of steps.
    """
    description, t, q = equations.description, samples.t, samples.q
    if len(t) < 2 or description.balanced_rows != 0 or description.switches:
        return ""
    moves = equations.potential(t[0] + 0.7, q[0], samples.modes[0]) != samples.energy[0, 1]
    if moves or equations.velocity_rhs(float(t[0]), q[0]).any():
        return ""
    within = 2 if options.t_eval is None else 1 + steps
    change = np.diff(samples.energy.sum(axis=1))
    for k in np.sort(np.argsort(np.abs(change))[-_WORST:]):
        ends = (k, k + 1)
        permitted = within * max(_permit(equations, samples, i, sizes, options) for i in ends)
        if abs(change[k]) <= permitted:
            continue
        permitted += _CERTAIN * max(_rounding(equations, samples, i, sizes) for i in ends)
        if abs(change[k]) > permitted:
            return (
                f"From t = {t[k]:.9g} to {t[k + 1]:.9g} s the energy changes by {change[k]:.6g} J, "
                "and nothing does work."
            )
    return ""


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
    return float(_ERRORS * error + _ROUNDING * np.abs(samples.energy[k]).sum())


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
