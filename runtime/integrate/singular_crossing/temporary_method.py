"""Another method for the way to and across a singular position, where the run's does not reach.

None that is implicit does: at the distance τ the derivative of the accelerations by the velocities
is 2/τ, of opposite signs on both sides, and no Newton iteration goes through that. One of low order
does not where its steps are so short that rounding rules.
"""

import numpy as np

from runtime.integrate.method import EXPLICIT, LEADING
from runtime.integrate.run_state import RunState
from runtime.integrate.singular_crossing.crossing_step import CrossingSteps
from runtime.integrate.step_control import first_step
from runtime.singularity.singular_position_near_motion import Singularity

_POOR = 10.0  # measured: error over tolerance from which on another method leads across
_LEARNING = 0.2  # measured: of the way there; the first step of the method that takes over


class MethodHandover:
    """The loan of the explicit method of highest order to a run."""

    def __init__(self, state: RunState) -> None:
        self.state, self.kept_length = state, 0.0

    def begin(
        self, steps: CrossingSteps, position: Singularity, ahead: float, usual: float
    ) -> bool:
        """Let that method step where it is needed to cross `position`, the time `ahead` from now.

        Returns whether there is way left on which to learn how long steps may be.
        """
        state, r = self.state, self.state.record
        name = state.methods[-1][1]
        if name in {LEADING, "auto"} or r["lent"]:
            return False
        if name in EXPLICIT and steps.best(position, usual).total < _POOR:
            return False
        self.kept_length = float(r["h"])
        r["lent"], r["automatic"] = 1, 0
        r["lent_until"] = position.t + max(ahead, self.kept_length)
        state.use_method(LEADING)
        first = first_step(state.table, r["t"], r["h_max"], r["rtol"], r["estimate_order"])
        way = _LEARNING * ahead
        r["usual"] = r["h"] = min(first, way) if way > 0.0 else max(first, self.kept_length)
        r["look_at"] = -np.inf
        return way > 0.0

    def end(self) -> None:
        """Go on with the method that was asked for."""
        state, r = self.state, self.state.record
        r["lent"], r["automatic"] = 0, int(state.options.method == "auto")
        r["h"] = self.kept_length
        state.use_method(state.methods[-1][1])
