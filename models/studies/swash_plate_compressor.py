"""Section 12.4 of the book: strokes and accelerations of the air compressor's pistons.

The exact values are independent of this program: they follow from the closed form of a piston's
height by the shaft's angle.
"""

from functools import cache
from math import pi, radians, sin

import numpy as np

from models.studies.quick_return import extremes
from models.studies.rows import Row
from runtime import Result, load

PLOT = "read from a plot"
TOO_LONG = (
    "more than a disc of 0.2 m can give: in any hold its stroke is 2 R sin α to 2 mm; the "
    "acceleration grows with it"
)
# Tilt, degrees → exact largest acceleration; stroke and acceleration of the book.
BOOK = {20: (240.552917880, 0.12, 200.0), 30: (371.763459633, 0.20, 400.0),
        40: (629.976214659, 0.32, 800.0)}  # fmt: skip


@cache
def driven(tilt: float) -> Result:
    """One turn at 600 rpm with a tilt in degrees."""
    machine = load("space/swash_plate_compressor")
    turn = np.linspace(0.0, 2 * pi / (20 * pi), 1441)
    return machine.kinematics(turn, parameters={"tilt": radians(tilt)})


def table() -> list[Row]:
    """Every number of the section, ours, exact, and the book's."""
    rows = []
    for tilt, (exact, stroke, fastest) in BOOK.items():
        run, where = driven(tilt), f"12.4, α = {tilt}°"
        reason = TOO_LONG if tilt == 40 else PLOT
        ours = float(np.diff(extremes(run.q("piston_1.z")))[0])
        rows.append(Row(where, "stroke of piston 1, m", ours, 0.4 * sin(radians(tilt)), stroke,
                        "" if tilt == 30 else reason))  # fmt: skip
        ours = max(abs(one) for one in extremes(run.a("piston_1.z")))
        rows.append(
            Row(where, "largest acceleration of piston 1, m/s²", ours, exact, fastest, reason)
        )
    return rows
