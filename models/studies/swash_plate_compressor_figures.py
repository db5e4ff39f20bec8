"""Curves of section 12.4, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import over_time
from models.studies.swash_plate_compressor import BOOK, driven


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    runs = {f"α = {tilt}°": driven(tilt) for tilt in BOOK}
    yield "12_4_position", over_time(
        "12.4 Place of a piston, 600 rpm", "z, m",
        {label: (run.t, run.q("piston_1.z")) for label, run in runs.items()},
    )  # fmt: skip
    yield "12_4_acceleration", over_time(
        "12.4 Acceleration of a piston", "z̈, m/s²",
        {label: (run.t, run.a("piston_1.z")) for label, run in runs.items()},
    )  # fmt: skip
