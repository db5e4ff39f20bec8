"""Accumulation of steps: whether they become shorter so fast that a run never reaches its end.

Near an instant where the motion turns or switches infinitely often, steps are about as long as the
time left to it, or as its square, and the clock resolves them for millions of steps. Each doubling
of their number then covers a fraction of the time that the one before covered, and the sum of all
that are to come stays short of the end of the run. A run that is merely dear keeps its pace: each
doubling covers twice the time. Where the end of the run, or an instant at which a function of time
bends, comes before the limit of that sum, the run goes on. Steps that will stop shrinking look the
same until then: with a `max_steps` of the user's own a run goes on to that number.
"""

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context
from runtime.core.jit import inner
from runtime.core.loop_record import run_record

FIRST_LOOK = 4096  # measured: steps before the first doubling; shorter runs end soon in any case
_SLOWER = 0.75  # safety: of the time of the doubling before; 2 at a constant pace, 1 at half of it
_DOUBLINGS = 7  # safety: so many in a row, up to half a million steps, are no accident
_OF_EVENTS = 4  # safety: the same of a run that consists of events, each of which is dear
_NEAR = 0.01  # safety: of the last doubling; an end so near before the limit is as good as there
_EVENTFUL = 16  # measured: steps an event, with fewer of which the events are to blame


@inner
def next_kink(context: Context) -> float:
    """The next instant known beforehand at which a function of time bends, s; infinite for none."""
    for i in range(run_record(context).next_stop, context[ft.STOPS]):
        if context.stop_kinds[i] >= 0:
            return float(context.stop_times[i])
    return float(np.inf)


@inner
def is_endless(context: Context) -> bool:
    """Whether the run never comes to its end; called where the number of steps has doubled.

    Where events are to blame, this is left to the next of them, which has a name.
    """
    r = run_record(context)
    covered = r.t - r.pace_start
    ratio = covered / r.pace if r.pace > 0.0 else np.inf
    r.slower = r.slower + 1 if ratio < _SLOWER else 0
    eventful = _EVENTFUL * (r.events - r.pace_events) > r.pace_steps // 2
    r.pace_start, r.pace, r.pace_steps, r.pace_events = r.t, covered, 2 * r.steps, r.events
    if r.slower < (_OF_EVENTS if eventful else _DOUBLINGS):
        return False
    limit = r.t + ratio / (1.0 - ratio) * covered
    if limit - _NEAR * covered > min(next_kink(context), r.t_end):
        return False
    r.limit = limit
    if r.unlimited != 0:
        return False
    if eventful:
        r.max_events = 0
        return False
    return True
