"""Curves of section 12.3, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import of_runs
from models.studies.spatial_four_bar import SCENES, driven


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    place = "12_3_position", "12.3 Middle of the rocker, wheel at π rad/s", "z, m"
    yield from of_runs({"": driven(2)}, (*place, lambda run: run.q("rocker.z")))
    yield from of_runs(
        {f"model {k}": driven(k) for k in SCENES},
        ("12_3_torque", "12.3 Driving torque", "T, N m", lambda r: r.reaction("drive", "torque")),
    )
