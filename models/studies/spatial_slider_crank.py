"""Section 12.2 of the book: the spatial slider-crank driven at 2π rad/s.

The exact values are independent of this program: the slider's place is a closed form of the crank's
angle, and the driving torque the derivative of the energy by the angle, taken in forty digits.
"""

from functools import cache

import numpy as np

from models.studies.quick_return import extremes
from models.studies.rows import Row
from runtime import Result, load

LENGTHS = (0.3, 0.27, 0.24)
PLOT = "read from a plot"
MOMENTS = (
    "its figure follows from 4e-3 kg m² along the rod and 4e-4 across: -0.71462 and 0.96057 N m"
)

# l → exact ẍ3, and the largest of the book; exact torques, and those of the book.
ACCELERATIONS = {0.3: (2.66738599667, 2.6), 0.27: (3.77185646235, 3.7), 0.24: (11.6049000223, 11.4)}
TORQUES = {
    0.3: ((-0.2975489152, -0.28), (0.2029977386, 0.22)),
    0.27: ((-0.3368541267, None), (0.2824747380, None)),
    0.24: ((-0.7408196049, -0.70), (0.9867543946, 0.96)),
}


@cache
def driven(length: float) -> Result:
    """One turn with a rod of this length."""
    turn = np.linspace(0.0, 1.0, 2001)
    machine = load("space/spatial_slider_crank", "inverse_dynamics")
    return machine.inverse_dynamics(turn, parameters={"length": length})


def table() -> list[Row]:
    """Every number of the section, ours, exact, and the book's."""
    least, most = extremes(driven(0.3).q("slider.x"))
    rows = [
        Row("12.2, l = 0.3", "least x, m", least, 0.184951888439, 0.185),
        Row("12.2, l = 0.3", "largest x, m", most, 0.290159954099, 0.293, PLOT),
    ]
    for length, (exact, book) in ACCELERATIONS.items():
        ours = extremes(driven(length).a("slider.x"))[1]
        rows.append(Row(f"12.2, l = {length:g}", "largest ẍ, m/s²", ours, exact, book, PLOT))
    for length, values in TORQUES.items():
        ours = extremes(driven(length).reaction("drive", "torque"))
        for word, one, (exact, book) in zip(("least", "largest"), ours, values, strict=True):
            reason = MOMENTS if length == 0.24 else PLOT if book else ""
            what = f"{word} torque, N m"
            rows.append(Row(f"12.2, l = {length:g}", what, one, exact, book, reason))
    return rows
