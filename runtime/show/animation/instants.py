"""The instants of an animation: frames, both sides of every event, and more where it is fast."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from runtime.results.motion_at_instants import Sampling, resampled

if TYPE_CHECKING:
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

_VALUES = 600_000  # layout: numbers of a run in a page, some 2 MB
RATE = 60  # layout: frames a second of the run's own time
TURN = 0.15  # accuracy: rad between instants; a straight path between them errs by 0.3 % of an arm
_MAX_FAST = 20_000  # layout: instants of a run whose bodies turn fast
_COARSER = 1.1  # layout: by how much the turn grows until its instants are few enough
_SAMPLING = Sampling(
    a_step=2,  # layout: instants in a step of the run
    least=600,  # layout: instants of a short run
    most=6000,  # layout: instants of a long one, so that a page stays below some MB
    events=1000,  # layout: events of which both sides are shown
    patience=10.0,  # measured: s of integration that an animation takes once more
)


def animated(result: "Result") -> "Result":
    """The result at the instants of its frames; of a run that took long, its own samples.

    Between two instants no body turns by more than `TURN`, if the page has room for so many; else
    the instants lie at equal turns.
    """
    span = float(np.ptp(result.t)) if len(result.t) else 0.0
    room = _VALUES / _columns(result)
    most = int(np.clip(room, _SAMPLING.least, _SAMPLING.most))
    least = int(np.clip(RATE * span, _SAMPLING.least, most))
    sampling = _SAMPLING._replace(least=least, most=most)
    even = resampled(result, sampling)
    limit = int(np.clip(room, most, _MAX_FAST))
    between = instants_between(even.t, turns(even), limit - len(even.t))
    return resampled(result, sampling, between) if len(between) else even


def turns(result: "Result") -> FloatArray:
    """The largest turn of a body between neighbouring instants, (k - 1,), rad."""
    positions = result.description.positions
    angles = [result.q(row.name) for row in positions if row.unit == "rad"]
    if not angles or len(result.t) < 2:
        return np.zeros(max(len(result.t) - 1, 0))
    change = np.abs(np.diff(np.array(angles), axis=1))
    return np.asarray(np.where(np.isfinite(change), change, 0.0).max(axis=0))


def instants_between(t: FloatArray, turned: FloatArray, room: int) -> FloatArray:
    """Instants to add between those of `t`, (k,), no more than `room`, s.

    Parameters
    ----------
    turned : (k - 1,)
        The turn from each instant to the next, rad. Each part of it is to be at most `TURN`, or as
        small as the room permits.
    """
    largest = float(turned.max(initial=0.0))
    turn = TURN
    while turn < largest and np.sum(np.ceil(turned / turn) - 1, where=turned > turn) > room:
        turn *= _COARSER
    if turn >= largest:
        return np.empty(0)
    parts = np.maximum(np.ceil(turned / turn).astype(int), 1)
    wanted = np.flatnonzero(parts > 1)
    return np.concatenate([np.linspace(t[k], t[k + 1], parts[k] + 1)[1:-1] for k in wanted])


def _columns(result: "Result") -> int:
    """About how many numbers a page has of an instant: motion twice, reactions, powers."""
    known = result.description
    return 4 * len(known.coordinates) + len(known.reactions) + len(known.powers) + 4
