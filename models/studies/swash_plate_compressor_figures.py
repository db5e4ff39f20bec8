"""Curves of section 12.4, with our numbers."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from models.studies.curves import of_runs
from models.studies.swash_plate_compressor import BOOK, driven


def figures() -> Iterator[tuple[str, Figure]]:
    """(number, picture)."""
    bend = "12_4_acceleration", "12.4 Acceleration of a piston", "z̈, m/s²"
    yield from of_runs(
        {f"α = {tilt}°": driven(tilt) for tilt in BOOK},
        ("12_4_position", "12.4 Place of a piston, 600 rpm", "z, m", lambda r: r.q("piston_1.z")),
        (*bend, lambda run: run.a("piston_1.z")),
    )
