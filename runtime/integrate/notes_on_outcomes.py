"""Sentences on how a run ended, with the numbers that show it."""

from typing import Any

import numpy as np

from runtime.core.arrays import Vector
from runtime.hybrid.mode_selection import MOST_COMBINED
from runtime.integrate.problem import MOST_STEPS
from runtime.integrate.recording_buffers import Recording


def memory_note(recording: Recording) -> str:
    """What a run has recorded, and the memory that it takes."""
    r = recording.record
    return (
        f"The states that were recorded in {r['steps']} steps and {r['events']} events take "
        f"{recording.bytes:.3g} bytes."
    )


def energy_note(record: Any) -> str:
    """How the energy changes, and what explains of it."""
    change, work = float(record["unexplained"] + record["explained"]), float(record["explained"])
    if record["index"] >= 0:
        return f"The energy jumps there by {change:.6g} J, which no force and no impact explains."
    return (
        f"Up to t = {record['end']:.9g} s the energy changes by {change:.6g} J, and the work of "
        f"effects and drivers is {work:.6g} J."
    )


def accumulation_note(record: Any) -> str:
    """Up to where steps get ever shorter, and how the run goes on; empty where they do not."""
    if record["unlimited"] != 0 or not np.isfinite(record["limit"]):
        return ""
    t, limit = float(record["t"]), float(record["limit"])
    return (
        f"In {record['steps']} steps the run has come to t = {t:.9g} s; each doubling of their "
        f"number covers less time than the one before, {float(record['pace']):.3g} s at last, and "
        f"all that are to come add up to t = {limit:.9g} s, {limit - t:.3g} s later, where the run "
        f"is to reach {float(record['t_end']):.9g} s. If its steps stop shrinking before, go on "
        f"with a number of your own, such as max_steps={MOST_STEPS}, which switches this check off."
    )


def passed_accumulation_note(record: Any) -> str:
    """That steps got ever shorter towards an instant, and the run went on; empty: they did not."""
    if record["unlimited"] == 0 or not np.isfinite(record["limit"]):
        return ""
    return (
        f"Towards about t = {float(record['limit']):.6g} s its steps got ever shorter, as where a "
        "motion turns or switches infinitely often, and only the number given as max_steps= let it "
        "go on: look at the motion about there."
    )


def mode_search_note(bands: Vector) -> str:
    """Note on a run where more functions were on their surface than can all be tried.

    `bands`, (s,), are positive where a function is on its surface.
    """
    count = int(np.count_nonzero(bands > 0.0))
    if count <= MOST_COMBINED:
        return ""
    return (
        f"{count} conditions are on their surface at once; of their combinations only those of "
        f"{MOST_COMBINED} were all tried, and the search was given up: there may be a state that "
        "agrees."
    )
