"""The numbers of a result: arrays over time, partitions of the coordinates, and their JSON."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class Samples(NamedTuple):
    """States and what follows from them; the first axis of each array is time."""

    t: FloatArray  # instants in s, shape (k,)
    q: FloatArray  # coordinates, (k, n), as velocities and accelerations
    v: FloatArray
    a: FloatArray
    lam: FloatArray  # multipliers, (k, m)
    reaction: FloatArray  # reactions, (k, rows of REACTIONS)
    power: FloatArray  # powers in W, (k, rows of POWERS)
    energy: FloatArray  # kinetic and potential energy in J, (k, 2)
    residual: FloatArray  # largest |Φ| and |Φ_q v - ν|, (k, 2)
    # modes of the switching functions: 1, 0, or 2 where the function stays at zero, (k, s)
    modes: npt.NDArray[np.int64]
    share: FloatArray  # Filippov's share α where the mode is 2, (k, s); else NaN


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
