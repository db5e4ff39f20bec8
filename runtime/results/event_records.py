"""Events of a result: changes of modes, impacts, singular configurations."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.core.modes import Direction

FloatArray = npt.NDArray[np.float64]


class Event(NamedTuple):
    """A change of a mode, an impact, or a singular configuration.

    Attributes
    ----------
    name
        `effect: condition`; of a singular position its drivers and joints, as
        `singular: drive, A, B`.
    time
        In s; where bouncing ends, the instant at which its last flight would.
    direction
        1: the condition began to hold, or a contact opened; -1: it ceased; 0: from now on the
        motion stays on its boundary: it slides there, friction sticks, or a contact is closed;
        2: an impact, after which the contact is open; 3: a singular position was crossed; 4: the
        machine locked up in one.
    q, v
        State, shape (n,); after an impact, the velocities that it leaves.
    """

    name: str
    time: float
    direction: int
    q: FloatArray
    v: FloatArray

    @property
    def what(self) -> str:
        """The direction in a word: began, ceased, holds, impact, crossed or locked."""
        return Direction(self.direction).name.lower()

    @property
    def state(self) -> FloatArray:
        """q and v in one array, shape (2 n,)."""
        return np.concatenate([self.q, self.v])
