"""Curves of section 12.6, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import of_runs
from models.studies.governor import STEADY, running


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    yield from of_runs(
        {f"C = {gain:g} N": running(gain) for gain in STEADY},
        ("12_6_speed", "12.6 Speed of the spindle", "ω, rad/s", lambda r: r.v("spindle.omega_y")),
        ("12_6_collar", "12.6 Height of the collar", "y, m", lambda r: r.q("collar.y")),
    )
