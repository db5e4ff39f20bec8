"""Curves of section 12.6, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import over_time
from models.studies.governor import STEADY, running


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    runs = {f"C = {gain:g} N": running(gain) for gain in STEADY}
    yield "12_6_speed", over_time(
        "12.6 Speed of the spindle", "ω, rad/s",
        {label: (run.t, run.v("spindle.omega_y")) for label, run in runs.items()},
    )  # fmt: skip
    yield "12_6_collar", over_time(
        "12.6 Height of the collar", "y, m",
        {label: (run.t, run.q("collar.y")) for label, run in runs.items()},
    )  # fmt: skip
