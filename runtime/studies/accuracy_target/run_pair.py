"""Two runs with tolerances far apart, and what their difference says of the tighter one."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.integrate.problem import Options
from runtime.integrate.trajectory import Trajectory
from runtime.studies.accuracy_target.run_difference import PARTED, Difference

FloatArray = npt.NDArray[np.float64]

SURE = 0.75
"""Power of rtol with which errors are counted upon to fall."""
_GRAIN = 2e-13  # rtol from which on rounding keeps errors from falling any further
_ROUGH = 0.1  # least share of a difference that is counted upon where the motion parts later


@dataclass(frozen=True)
class Run:
    """A run: which one, its options, values, what these are parts of, its processor time in s."""

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
    """Two runs, the second with the tighter tolerance, and by how much they differ.

    A vibration that the loose one does not resolve at all makes a difference of its own size, which
    tells nothing of the tight one.
    """

    loose: Run
    tight: Run
    found: Difference
    resolved: bool

    @property
    def unable(self) -> bool:
        """Whether the tighter one ends before, by something else than its end."""
        return self.tight.path.outcome is not Outcome.OK and len(self.tight.t) < len(self.loose.t)

    @property
    def known(self) -> bool:
        """Whether all of the tighter one was compared, with one that has all of its motions."""
        return self.resolved and not self.unable and len(self.loose.t) >= len(self.tight.t)

    @property
    def share(self) -> float:
        """How much of the difference the error of the tighter one is taken to be."""
        if not self.known or self.found.largest <= _GRAIN:  # rounding, in both runs alike
            return 1.0
        loose, tight = (max(run.options.rtol, _GRAIN) for run in (self.loose, self.tight))
        share: float = (tight / loose) ** SURE
        return max(share, _ROUGH) if self.found.largest >= PARTED else share
