"""The instants of an animation: frames, and both sides of every event."""

from typing import TYPE_CHECKING

import numpy as np

from runtime.results.motion_at_instants import Sampling, resampled

if TYPE_CHECKING:
    from runtime.results.result import Result

_VALUES = 600_000  # layout: numbers of a run in a page, some 2 MB
RATE = 60  # layout: frames a second of the run's own time
_SAMPLING = Sampling(
    a_step=2,  # layout: instants in a step of the run
    least=600,  # layout: instants of a short run
    most=6000,  # layout: instants of a long one, so that a page stays below some MB
    events=1000,  # layout: events of which both sides are shown
    patience=10.0,  # measured: s of integration that an animation takes once more
)


def animated(result: "Result") -> "Result":
    """The result at the instants of its frames; of a run that took long, its own samples."""
    span = float(np.ptp(result.t)) if len(result.t) else 0.0
    most = int(np.clip(_VALUES / _columns(result), _SAMPLING.least, _SAMPLING.most))
    least = int(np.clip(RATE * span, _SAMPLING.least, most))
    return resampled(result, _SAMPLING._replace(least=least, most=most))


def _columns(result: "Result") -> int:
    """About how many numbers a page has of an instant: motion twice, reactions, powers."""
    known = result.description
    return 4 * len(known.coordinates) + len(known.reactions) + len(known.powers) + 4
