"""Section 12.3 of the book: the spatial four-bar, its wheel driven at π rad/s.

The exact values are independent of this program: poses are closed forms of the wheel's angle, and
the driving torque is the derivative of the energy by the angle, taken in forty digits.
"""

from functools import cache

import numpy as np

from models.studies.rows import Row
from runtime import Result, load

SCENES = {1: "inverse_dynamics", 2: "inverse_dynamics_without_link"}
PLOT = "read from a plot"
PEAKS = {"first peak": 0.535, "trough": 0.91, "second peak": 1.523}
# Model → exact torque at each of these, and the book's.
TORQUES = {
    1: ((183.704420159, 180.0), (-105.101844828, -100.0), (190.702824210, 190.0)),
    2: ((97.7699186994, 97.0), (-50.0819104367, -50.0), (89.0077677421, 90.0)),
}
# End of the rocker's swing → time, exact height of its middle, and the book's.
ENDS = {"first": (0.324, 2.62147538332, 2.63), "second": (1.315, 2.79182887005, 2.79)}


@cache
def driven(model: int) -> Result:
    """A turn and a quarter of the wheel, as in the book."""
    machine = load("space/spatial_four_bar", SCENES[model])
    return machine.inverse_dynamics(np.linspace(0.0, 2.5, 5001))


def extreme(t: np.ndarray, values: np.ndarray, near: float) -> float:
    """The extreme of a smooth function nearest to a time, of the quartic through five samples."""
    k = int(np.abs(t - near).argmin())
    steps = np.arange(-20, 21, 10)
    curve = np.polynomial.Polynomial.fit(steps, values[k + steps], 4)
    places = curve.deriv().roots()
    return float(curve(places[np.abs(places).argmin()].real))


def table() -> list[Row]:
    """Every number of the section, ours, exact, and the book's."""
    run, rows = driven(2), []
    for end, (near, exact, book) in ENDS.items():
        ours = extreme(run.t, run.q("rocker.z"), near)
        rows.append(Row("12.3", f"z of the rocker, {end} end, m", ours, exact, book, PLOT))
    for model, values in TORQUES.items():
        run = driven(model)
        for (what, near), (exact, book) in zip(PEAKS.items(), values, strict=True):
            ours = extreme(run.t, run.reaction("drive", "torque"), near)
            where = f"12.3, model {model}"
            rows.append(Row(where, f"torque, {what}, N m", ours, exact, book, PLOT))
    return rows
