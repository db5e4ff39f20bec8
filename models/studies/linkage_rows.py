"""Lines of the table that several linkages have, ours beside the closed form."""

from math import pi

from scipy.optimize import minimize_scalar

from models.studies.linkage import FourBar
from models.studies.rows import Row
from runtime import Result


def summit(exact: FourBar, place: complex, phi: float, sign: int) -> float:
    """Lowest (sign +1) or highest (-1) point near φ on the path of a point of BC, m."""
    found = minimize_scalar(
        lambda phi: sign * exact.point(1, place, phi).at.imag,
        bracket=(phi - 0.02, phi + 0.02),
        tol=1e-10,
    )
    return float(sign * found.fun)


def turns_row(place: str, run: Result, exact: FourBar, torque: float, turns: int) -> Row:
    """The time of so many turns; the run ends there, and Newton mends what it missed."""
    start = float(run.v("crank.phi")[0])
    missed = 2 * pi * turns - run.q("crank.phi")[-1]
    ours = float(run.t[-1] + missed / run.v("crank.phi")[-1])
    quantity = f"{turns} turns under {torque:g} N m take, s"
    return Row(place, quantity, ours, exact.time(2 * pi * turns, torque, start))
