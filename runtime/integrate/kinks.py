"""How a run passes the kinks of explicit functions of time, and ends before their poles."""

from typing import TYPE_CHECKING

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Integers, Vector
from runtime.core.outcomes import Outcome, Site
from runtime.integrate.initialization import start_anew
from runtime.integrate.problem import Passage
from runtime.integrate.sampling import STEP_ENDS
from runtime.integrate.step import Signal

if TYPE_CHECKING:
    from runtime.integrate.run import Run

_GOING = int(Signal.GOING)
_CLOSE = 1e-6  # safety: of the run; nearer to a pole, that is why it ends


def end_at_pole(run: "Run", code: int) -> int:
    """The outcome of a run whose steps get ever shorter up to an instant known beforehand."""
    r, arrays = run.state.record, run.state.wiring.arrays
    ahead = np.flatnonzero(arrays["stop_kinds"][r["next_stop"] :] >= 0) + r["next_stop"]
    stops = run.state.stops
    if not len(ahead) or (stops is not None and stops.further is not None and len(ahead) == 1):
        return code
    way = float(arrays["stop_times"][ahead[0]] - r["t"])
    if way > _CLOSE * float(r["duration"]):
        return code
    passage = _passage(run, ahead[0])
    if passage.outcome is not Outcome.OK:
        return passage.outcome
    if not passage.function:  # it has no value at the first instant
        return code
    run.note = (
        f"At t = {r['t'] + way:.9g} s, {way:.3g} s later, a function of time in "
        f"'{passage.function}' bends or ends: its derivatives may grow without bound there."
    )
    return code


def _passage(run: "Run", stop: int) -> Passage:
    """How the run passes the kink that is a stop of this number."""
    state, r = run.state, run.state.record
    assert state.stops is not None
    q, v = state.y
    kink = int(state.wiring.arrays["stop_kinds"][stop])
    passage = state.stops.passage(kink, q.copy(), v.copy(), state.modes.copy())
    if passage.outcome is not Outcome.OK:
        r["index"], r["site"], run.note = passage.row, Site.NOWHERE, passage.note
    return passage


def pass_kink(run: "Run") -> int:
    """Go on behind a kink of an explicit function of time, or end before it."""
    state, r = run.state, run.state.record
    last = r["next_stop"] == state.table[ft.STOPS] - 1
    if last and state.stops is not None and state.stops.further is not None:
        state.set_further_stops()
        return _GOING
    passage = _passage(run, int(r["next_stop"]))
    if passage.outcome is not Outcome.OK:
        return passage.outcome
    before = state.y.ravel().copy(), state.modes.copy()
    state.leave_kink()
    if passage.v is not None:
        state.y[1] = passage.v
    code: int = start_anew(state.table)
    run.recording.flush()
    _sample_kink(run, before, passage)
    if passage.event is not None:
        number = np.array([state.system.switches + passage.source])
        run.recording.add_events(r["t"], number, [passage.event], state.y.ravel())
        r["events"] += 1
    if code == Outcome.OK and state.system.watches:
        code = run.watch_start()
    return _GOING if code == Outcome.OK else code


def _sample_kink(run: "Run", before: tuple[Vector, Integers], passage: Passage) -> None:
    """Take the samples that are asked for between the two sides of a kink."""
    state, r, times = run.state, run.state.record, run.state.wiring.arrays["sample_times"]
    while r["next_sample"] < len(times) and times[r["next_sample"]] <= r["t"]:
        at = float(times[r["next_sample"]])
        after = passage.behind is None or passage.behind(at)
        if r["every_step"] != STEP_ENDS:
            y, modes = (state.y.ravel(), state.modes) if after else before
            run.recording.add_sample(at, y, modes)
        r["next_sample"] += 1
    if r["every_step"] == STEP_ENDS and r["t"] >= r["t_end"]:
        run.recording.add_sample(float(r["t"]), state.y.ravel(), state.modes)
