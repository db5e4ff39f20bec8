"""The numbers of a result: arrays over time, partitions of the coordinates, and their JSON."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class Samples(NamedTuple):
    """States and what follows from them; the first axis of each array is time.

    Attributes
    ----------
    t
        Instants in s, shape (k,).
    q, v, a
        Coordinates, velocities, accelerations, (k, n).
    lam
        Multipliers, (k, m).
    reaction
        Reactions, (k, rows of REACTIONS).
    power
        Powers in W, (k, rows of POWERS).
    energy
        Kinetic and potential energy in J, (k, 2).
    residual
        Largest |Φ| and |Φ_q v - ν|, (k, 2).
    modes
        Modes of the switching functions: 1, 0, or 2 where the function stays at zero, (k, s).
    share
        Filippov's share α where the mode is 2, (k, s); else NaN.
    """

    t: FloatArray
    q: FloatArray
    v: FloatArray
    a: FloatArray
    lam: FloatArray
    reaction: FloatArray
    power: FloatArray
    energy: FloatArray
    residual: FloatArray
    modes: npt.NDArray[np.int64]
    share: FloatArray


class Partition(NamedTuple):
    """A choice of independent coordinates."""

    time: float  # from which on they hold, s
    independent: tuple[str, ...]  # their names; the others follow from them by the constraints


def plain(value: Any) -> Any:
    """Mappings, sequences and numbers, also NumPy's, as JSON; None if a number is not finite."""
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
