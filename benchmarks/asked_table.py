"""What was measured of simulations that are asked for an accuracy, as a table and in sentences."""

import math
from collections.abc import Sequence
from statistics import median

from benchmarks import asked
from benchmarks.report import Report, records
from runtime.results.json_values import plain

SHARE, WORST, COST = 0.95, 10.0, 3.0
"""Bars: share of the runs below what was asked, the worst ratio, the cost in times the cheapest."""


def sentences(rows: Sequence[asked.Row]) -> list[str]:
    """What follows, in sentences."""
    judged = [row for row in rows if row.counted]
    below = sum(row.ratio <= 1.0 for row in judged)
    worst = max(judged, key=lambda row: row.ratio)
    priced = [row for row in judged if math.isfinite(row.cost)]
    cheap = sum(row.cost <= COST for row in priced)
    dearest = max(priced, key=lambda row: row.cost)
    ended = [row for row in rows if row.outcome != "OK"]
    unknown = len(rows) - len(judged) - len(ended)
    right = (
        f"The true error is below what was asked in {below} of {len(judged)} runs "
        f"({100.0 * below / len(judged):.1f} %, the bar is {100.0 * SHARE:g} %); the worst is "
        f"{worst.ratio:.2g} times it ({worst.scene} at {worst.asked:.0e}; the bar is {WORST:g})."
    )
    price = (
        f"All runs together cost {median(row.cost for row in priced):.2f} times the cheapest "
        f"single run in the median, at most {COST:g} times in {cheap} of {len(priced)}, and "
        f"{dearest.cost:.2f} times at the most ({dearest.scene} at {dearest.asked:.0e})."
    )
    lines = [right, price]
    if ended:
        told = ", ".join(f"{row.scene} at {row.asked:.0e} ({row.outcome})" for row in ended)
        lines.append(f"Not reached over all the time, and said so: {told}.")
    if unknown:
        lines.append(f"Not judged, as the references agree no better: {unknown} of the runs.")
    return lines


def report(quick: bool) -> list[Report]:
    """All scenes of the library, in place; quick: one of them, three accuracies.

    Reduced equations that are not built yet are built into `generated`.
    """
    scenes, errors, repeats = asked.SCENES, asked.ASKED, 5
    if quick:
        scenes, errors, repeats = asked.SCENES[:1], asked.ASKED[::3], 1
    rows = list(asked.measure(scenes, errors, None, repeats))
    headings = (
        "scene", "asked", "true", "estimated", "true over asked", "runs", "taken", "ms",
        "cheapest, ms", "cheapest setting", "cost",
    )  # fmt: skip
    table = [
        (
            f"{row.model}, {row.scene}",
            f"{row.asked:.0e}",
            f"{row.true:.1e}",
            f"{row.estimated:.1e}",
            f"{row.ratio:.2g}" if row.counted else row.outcome if row.outcome != "OK" else "?",
            str(row.runs),
            f"{row.method}, {row.formulation}, {row.rtol:.0e}",
            f"{row.milliseconds:.2f}",
            f"{row.cheapest:.2f}",
            row.setting,
            f"{row.cost:.2f}",
        )
        for row in rows
    ]
    title = "asked for an accuracy: true errors, and the cost beside the cheapest single run"
    return [Report("accuracy", title, headings, table, sentences(rows), plain(records(rows)))]
