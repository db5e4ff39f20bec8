"""Instants at which runs end by a condition, or joints come and go: each run has its own.

Each is a quantity with an error of its own, and the state at an end is compared with that of
another run at its own end.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.results.result import Result
from runtime.studies.series_by_name import FloatArray


def own_instants(result: Result) -> dict[str, float]:
    """The instants of a run's changes and of its end by a condition, s: ``t(latch)#2``."""
    ends = [(result.ended_by, float(result.t[-1]))] if result.ended_by else []
    found = dict[str, float]()
    for name, t in [*((one.joint, one.time) for one in result.reconnections), *ends]:
        count = sum(1 for known in found if known.partition("#")[0] == f"t({name})")
        found[f"t({name}){f'#{count + 1}' if count else ''}"] = t
    return found


class Places(NamedTuple):
    """The instants of a run with which others are compared."""

    t: FloatArray  # s, (k,); where a condition ended it, the last is that end
    start: float  # s
    instants: dict[str, float]  # its own, s
    are_compared: bool  # whether these, and its end, are quantities

    @property
    def names(self) -> tuple[str, ...]:
        """Of its own instants, where they are quantities."""
        return tuple(self.instants) if self.are_compared else ()

    def rows(self, result: Result) -> npt.NDArray[np.int64]:
        """The rows of another run with the same ways, (k,); behind its end that of its end."""
        last = len(result.t) - 1
        rows: npt.NDArray[np.int64] = np.minimum(np.searchsorted(result.t, self.t), last)
        if self.are_compared and result.ended_by:
            rows[-1:] = last
        return rows

    def columns(self, result: Result) -> FloatArray:
        """The instants of a run as quantities over time, s since the start, (k, m)."""
        own = own_instants(result)
        values = [own[name] - self.start for name in self.names]
        return np.tile(values, (len(self.t), 1)).reshape(len(self.t), len(values))

    def difference(self, result: Result) -> str:
        """Sentence on a run that ends, or changes joints, otherwise; empty where it does not."""
        ways = [", ".join(one) or "none" for one in (own_instants(result), self.instants)]
        if ways[0] == ways[1]:
            return ""
        return f"Its own instants are {ways[0]}, and those of the reference {ways[1]}."
