"""Curves of section 12.2, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import of_runs
from models.studies.spatial_slider_crank import LENGTHS, driven


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    place = "12_2_position", "12.2 Slider position, crank at 2π rad/s", "x, m"
    yield from of_runs(
        {f"l = {length:g} m": driven(length) for length in LENGTHS},
        (*place, lambda run: run.q("slider.x")),
        ("12_2_acceleration", "12.2 Slider acceleration", "ẍ, m/s²", lambda r: r.a("slider.x")),
        ("12_2_torque", "12.2 Driving torque", "T, N m", lambda r: r.reaction("drive", "torque")),
    )
