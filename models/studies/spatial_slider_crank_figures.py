"""Curves of section 12.2, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import over_time
from models.studies.spatial_slider_crank import LENGTHS, driven


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    runs = {f"l = {length:g} m": driven(length) for length in LENGTHS}
    yield "12_2_position", over_time(
        "12.2 Slider position, crank at 2π rad/s", "x, m",
        {label: (run.t, run.q("slider.x")) for label, run in runs.items()},
    )  # fmt: skip
    yield "12_2_acceleration", over_time(
        "12.2 Slider acceleration", "ẍ, m/s²",
        {label: (run.t, run.a("slider.x")) for label, run in runs.items()},
    )  # fmt: skip
    yield "12_2_torque", over_time(
        "12.2 Driving torque", "T, N m",
        {label: (run.t, run.reaction("drive", "torque")) for label, run in runs.items()},
    )  # fmt: skip
