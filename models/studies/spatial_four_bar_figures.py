"""Curves of section 12.3, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import over_time
from models.studies.spatial_four_bar import SCENES, driven


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    run = driven(2)
    yield (
        "12_3_position",
        over_time(
            "12.3 Middle of the rocker, wheel at π rad/s", "z, m", {"": (run.t, run.q("rocker.z"))}
        ),
    )
    torques = {f"model {k}": (driven(k).t, driven(k).reaction("drive", "torque")) for k in SCENES}
    yield "12_3_torque", over_time("12.3 Driving torque", "T, N m", torques)
