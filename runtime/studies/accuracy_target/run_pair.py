"""Two runs with tolerances far apart, and the error of one that their difference shows."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.integrate.problem import Options
from runtime.integrate.trajectory import Trajectory
from runtime.studies.accuracy_target.run_difference import DIVERGED, Difference

FloatArray = npt.NDArray[np.float64]

SAFE_POWER = 0.75  # measured: power of rtol with which errors fall at least
_ROUNDING = 2e-13  # accuracy: rtol from which on rounding keeps errors from falling
_LEAST_SHARE = 0.1  # safety: least share of a difference where the motions diverge later


@dataclass(frozen=True)
class Run:
    """A run: its number, options, trajectory and values.

    Attributes
    ----------
    values : (k, c)
        Of the quantities.
    wholes : (c,)
        Magnitudes of the wholes that they are parts of.
    seconds
        Processor time.
    """

    number: int
    options: Options
    path: Trajectory
    values: FloatArray
    wholes: FloatArray
    seconds: float

    @property
    def t(self) -> FloatArray:
        """Output instants that it reached, s, (k,)."""
        return self.path.t


@dataclass(frozen=True)
class Compared:
    """Two runs, the second with the tighter tolerance, and their difference.

    A vibration that the loose run does not resolve at all makes a difference of its own size, which
    shows nothing about the tight run.
    """

    loose: Run
    tight: Run
    difference: Difference
    resolved: bool

    @property
    def tight_fails(self) -> bool:
        """Whether the tighter run fails before the end of the looser one."""
        failed = self.tight.path.outcome is not Outcome.OK
        return failed and len(self.tight.t) < len(self.loose.t)

    @property
    def conclusive(self) -> bool:
        """Whether all of the tighter run was compared with a run that resolves all motions."""
        whole = len(self.loose.t) >= len(self.tight.t)
        return self.resolved and not self.tight_fails and whole

    @property
    def share(self) -> float:
        """Share of the difference that the error of the tighter run is estimated to be."""
        largest = self.difference.largest
        if not self.conclusive or largest <= _ROUNDING:  # rounding, in both runs alike
            return 1.0
        loose, tight = (max(run.options.rtol, _ROUNDING) for run in (self.loose, self.tight))
        share: float = (tight / loose) ** SAFE_POWER
        return max(share, _LEAST_SHARE) if largest >= DIVERGED else share

    @property
    def delivered(self) -> Run:
        """The run that is the result."""
        return self.loose if self.tight_fails else self.tight

    @property
    def other(self) -> Run:
        """The run that it was compared with."""
        return self.tight if self.tight_fails else self.loose
