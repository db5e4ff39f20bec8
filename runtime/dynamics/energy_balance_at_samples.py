"""Balance of energy between samples, for runs in reduced coordinates, whose loop knows no energy.

Where nothing but potentials acts, the energy stays. Where powers act, they are integrated between
the samples if these are the ends of steps: by Gauss' rule, on the quintic through positions,
velocities and accelerations. Scenes with switches or kinks of functions of time are not judged.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from runtime.integrate.problem import Options
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.results.samples import Samples


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
    if not rows and any(equations.velocity_rhs(float(t[0]), q[0]).tolist()):
        return ""
    find_unexplained, weights, worst = _compiled()
    v, a, energy, power = samples.v, samples.a, samples.energy, samples.power
    widths = equations.n, equations.m, len(description.powers), len(description.mass_rows)
    within, found = 2.0 if options.t_eval is None else 1.0 + steps, np.zeros(2 + worst)
    k = find_unexplained(
        equations.table, t, q, v, a, energy, power, np.zeros(0, np.int64), equations.p, equations.m,
        rows, description.mass_rows, description.mass_columns, sizes,
        options.absolute(sizes, options.rtol), options.rtol, within, weights,
        np.zeros((5, max(widths))), np.zeros(worst, np.int64), found,
    )  # fmt: skip
    if k < 0:
        return ""
    what = f"powers do {found[1]:.6g} J of work" if rows else "nothing does work"
    return (
        f"From t = {t[k]:.9g} to {t[k + 1]:.9g} s the energy changes by {found[0]:.6g} J, "
        f"and {what}."
    )


@cache
def _compiled() -> tuple[Callable[..., int], FloatArray, int]:
    """What judges samples: loaded where a run needs it, since most are judged in their loop."""
    from runtime.dynamics import energy_balance_of_intervals as compiled

    return compiled.find_unexplained, compiled.WEIGHTS_OF_ENDS, compiled.WORST
