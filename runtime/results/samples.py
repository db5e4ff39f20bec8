"""The numbers of a result: arrays over time, their memory, partitions of the coordinates, JSON."""

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.object_display import counted
from runtime.mechanism.module_tables import Description
from runtime.mechanism.series_table import Series
from runtime.mechanism.spins import rotation_matrices, spins

FloatArray = npt.NDArray[np.float64]

_NUMBER = 8  # layout: bytes of a number
_GIGABYTE = 1e9  # formula: bytes of a gigabyte
_SHARE = 0.9  # safety: of the free memory, which a result may take
_SMALL = 1 << 24  # measured: bytes; asking the system takes a quarter of a millisecond
_LIMITS = (
    ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
    ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
)
"""Files in which Linux keeps what a container may take, and what it has taken."""


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

    def at(self, rows: Any) -> "Samples":
        """Those of some rows, an index."""
        return Samples._make(array[rows] for array in self)

    def column(self, row: Series) -> npt.NDArray[Any]:
        """The values of a series that is no work, (k,)."""
        if row.array == "spin":
            first, axis = divmod(row.column, 3)
            p = slice(first, first + 4)
            return spins(self.q[:, p], self.v[:, p])[:, axis]
        if row.array == "rotation":
            first, entry = divmod(row.column, 9)
            return rotation_matrices(self.q[:, first : first + 4]).reshape(-1, 9)[:, entry]
        array: npt.NDArray[Any] = getattr(self, row.array)
        return array.sum(axis=1) if row.column < 0 else array[:, row.column]

    @staticmethod
    def joined(pieces: Sequence["Samples"]) -> "Samples":
        """One after the other."""
        return Samples._make(map(np.concatenate, zip(*pieces, strict=True)))


def undefined_outputs(description: Description, samples: Samples) -> str:
    """Sentences on the expressions among the outputs that are no number at some instants."""
    text = ""
    for k, row in enumerate(description.reactions):
        if not row.component and len(lost := samples.t[np.isnan(samples.reaction[:, k])]):
            of = f"{len(lost)} of {counted(len(samples.t), 'instant')}"
            text += f" '{row.name}' is not a number at t = {lost[0]:.6g} s ({of})."
    return text


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


def empty_samples(description: Description, count: int) -> Samples:
    """Samples of a scene at so many instants, all zero."""
    n, s, rows = len(description.coordinates), len(description.switches), description.reactions
    widths = n, n, n, len(description.constraints), len(rows), len(description.powers), 2, 2
    floats = [np.zeros((count, width)) for width in widths]
    modes, share = np.zeros((count, s), np.int64), np.zeros((count, s))
    return Samples._make([np.zeros(count), *floats, modes, share])


def sample_bytes(description: Description) -> int:
    """Bytes of all quantities of a result at one instant."""
    return sum(array.nbytes for array in empty_samples(description, 1))


def state_bytes(description: Description) -> int:
    """Bytes of what the integration itself records at one instant."""
    return _NUMBER * (2 * len(description.coordinates) + len(description.switches) + 1)


def free_bytes() -> int | None:
    """Bytes that this process can still take; None where the system does not tell."""
    found = list[int]()
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found += [int(row.split()[1]) << 10 for row in lines if row.startswith("MemAvailable:")]
    except (OSError, ValueError, IndexError):
        pass
    for limit, taken in _LIMITS:
        try:
            found.append(int(Path(limit).read_text()) - int(Path(taken).read_text()))
        except (OSError, ValueError):  # none, or "max"
            continue
    if not found and hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return max(0, min(found)) if found else None


def require_memory(title: str, what: str, needed: int, advice: str) -> None:
    """Raise InputError where `what` takes more bytes than are free, with both numbers.

    What is small always fits: the system is not asked.
    """
    free = free_bytes() if needed > _SMALL else None
    if free is not None and needed > _SHARE * free:
        raise InputError(
            f"{title}: {what} take {needed / _GIGABYTE:.3g} GB, and {free / _GIGABYTE:.3g} GB of "
            f"memory are free. {advice}"
        )
