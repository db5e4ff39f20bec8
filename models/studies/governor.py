"""Section 12.6 of the book: the governor under load, with three gains.

The exact values are independent of this program: where the governor runs steadily the engine's
torque is the load, which gives the collar's height, and virtual work gives the speed. The damper
changes nothing of that; our values are those of a run of 40 s with a damper of 300 N s/m, in which
the third gain, too, settles.
"""

from functools import cache

from models.studies.rows import Row
from runtime import Result, load

PLOT = "read from a plot"
# Gain → exact height of the collar and speed; those of the book.
STEADY = {
    7500.0: ((140 / 3, 10.2959094804), (46.7, 10.30)),
    12500.0: ((48.0, 10.5874802864), (48.0, 10.58)),
    17500.0: ((340 / 7, 10.7121105859), (48.6, 10.71)),
}


@cache
def running(gain: float, seconds: float = 10.0, damping: float = 30.0) -> Result:
    """A run from 11.0174 rad/s, with the load from 1 s on."""
    values = {"gain": gain, "damping": damping}
    return load("space/governor").simulate(seconds, 1001, rtol=1e-9, parameters=values)


def table() -> list[Row]:
    """Every number of the section, ours, exact, and the book's."""
    rows = []
    for gain, ((height, speed), (low, slow)) in STEADY.items():
        run, where = running(gain, 40.0, 300.0), f"12.6, C = {gain:g} N"
        lifted = 1e3 * float(run.q("collar.y")[-1])
        rows.append(Row(where, "collar, steady, mm", lifted, height, low))
        found = float(run.v("spindle.omega_y")[-1])
        rows.append(Row(where, "speed, steady, rad/s", found, speed, slow, PLOT))
    return rows
