"""How far friction in a joint is off its law, while other functions slide, stick or are closed.

Forces that keep a function at zero are found by superposition. The friction of a joint that slides
meanwhile is no linear function of them, since its normal force is the length of a reaction.
"""

import numpy as np

from runtime.core.modes_and_event_kinds import SLIDING
from runtime.integrate.problem import Options
from runtime.mechanism.dense_equations import Equations
from runtime.results.samples import Samples

_OFF = 1e-9  # accuracy: of a force of friction; with less it is on its law, however fine rtol is
_TOLERANCES = 10.0  # safety: of a run, by which a force may be off


def describe_superposed_friction(equations: Equations, samples: Samples, options: Options) -> str:
    """A sentence on each friction whose force is not μ N at a sample; empty for none."""
    description, count = equations.description, samples.modes.shape[1]
    if not description.friction_limits or not len(samples.t):
        return ""
    low, high = np.zeros((2, count))
    equations.kernels.holds(equations.p, low, high)
    resting, text = samples.modes == SLIDING, ""
    for k, row, limit in description.friction_limits:
        law = samples.reaction[:, limit] / (2.0 * high[k] - 1.0)  # μ N of μ_s N
        beside = resting.any(axis=1) & ~resting[:, k] & np.isfinite(law)
        off = np.where(beside, np.abs(np.abs(samples.reaction[:, row]) - law), 0.0)
        worst = int(np.argmax(off))
        if off[worst] > max(_OFF, _TOLERANCES * options.rtol) * np.nanmax(law, initial=0.0):
            unit = description.reactions[row].unit
            others = [description.switches[j].name for j in np.flatnonzero(resting[worst])]
            text += (
                f" At t = {samples.t[worst]:.6g} s friction {description.switches[k].name} is "
                f"{off[worst]:.3g} {unit} off its law, {law[worst]:.3g}, "
                f"since forces are superposed while {', '.join(others)} slides, sticks or is "
                "closed; the motion errs with it. Give that effect creep= or stiffness=."
            )
    return text
