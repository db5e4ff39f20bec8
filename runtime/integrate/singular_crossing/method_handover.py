"""Another method for the way to and across a singular position, where the run's does not reach.

None that is implicit does: at the distance τ the derivative of the accelerations by the velocities
is 2/τ, of opposite signs on both sides, and no Newton iteration goes through that. One of low order
does not where its steps are so short that rounding rules.
"""

from typing import TYPE_CHECKING

import numpy as np

from runtime.integrate.method import EXPLICIT, LEADING
from runtime.integrate.method_change import adopt
from runtime.integrate.singular_crossing.crossing_step import Leaps
from runtime.integrate.step_control import first_step
from runtime.singularity.singular_position import Singularity

if TYPE_CHECKING:
    from runtime.integrate.run import _Run

_POOR = 10.0  # measured: error over tolerance from which on another method leads across
_LEARNING = 0.2  # measured: of the way there; the first step of the method that takes over


class Lending:
    """The loan of the explicit method of highest order to a run."""

    def __init__(self, run: "_Run", leaps: Leaps) -> None:
        self.run, self.leaps, self.kept = run, leaps, 0.0

    def lend(self, found: Singularity, ahead: float, usual: float) -> bool:
        """Let that method step where it is needed to cross `found`, the time `ahead` from now.

        Returns whether there is way left on which to learn how long steps may be.
        """
        run, r = self.run, self.run.r
        name = run.methods[-1][1]
        if name in {LEADING, "auto"} or r["lent"]:
            return False
        if name in EXPLICIT and self.leaps.best(found, usual).total < _POOR:
            return False
        self.kept = float(r["h"])
        r["lent"], r["automatic"] = 1, 0
        r["lent_until"] = found.t + max(ahead, self.kept)
        adopt(run, LEADING)
        first = first_step(run.table, r["t"], r["h_max"], r["rtol"], r["order"])
        way = _LEARNING * ahead
        r["usual"] = r["h"] = min(first, way) if way > 0.0 else max(first, self.kept)
        r["look_at"] = -np.inf
        return way > 0.0

    def end(self) -> None:
        """Go on with the method that was asked for."""
        run, r = self.run, self.run.r
        r["lent"], r["automatic"] = 0, int(run.options.method == "auto")
        r["h"] = self.kept
        adopt(run, run.methods[-1][1])
