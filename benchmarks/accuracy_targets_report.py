"""Simulations with an accuracy target, as a table and in sentences."""

import math
from collections.abc import Sequence
from statistics import median

from benchmarks import accuracy_targets
from benchmarks.report import Report, records
from runtime.results.samples import plain

SHARE, WORST, COST = 0.95, 10.0, 3.0
"""Bars: share of the runs that meet the target, worst ratio, cost over that of the cheapest run."""


def sentences(rows: Sequence[accuracy_targets.Row]) -> list[str]:
    """Conclusions, in sentences."""
    compared = [row for row in rows if row.counted]
    below = sum(row.ratio <= 1.0 for row in compared)
    worst = max(compared, key=lambda row: row.ratio)
    priced = [row for row in compared if math.isfinite(row.cost)]
    cheap = sum(row.cost <= COST for row in priced)
    dearest = max(priced, key=lambda row: row.cost)
    ended = [row for row in rows if row.outcome != "OK"]
    unknown = len(rows) - len(compared) - len(ended)
    right = (
        f"The true error is below the target in {below} of {len(compared)} runs "
        f"({100.0 * below / len(compared):.1f} %, the bar is {100.0 * SHARE:g} %); the worst is "
        f"{worst.ratio:.2g} times it ({worst.scene} at {worst.asked:.0e}; the bar is {WORST:g})."
    )
    price = (
        f"All runs together cost {median(row.cost for row in priced):.2f} times the cheapest "
        f"single run in the median, at most {COST:g} times in {cheap} of {len(priced)}, and "
        f"{dearest.cost:.2f} times at the most ({dearest.scene} at {dearest.asked:.0e})."
    )
    lines = [right, price]
    if ended:
        listed = ", ".join(f"{row.scene} at {row.asked:.0e} ({row.outcome})" for row in ended)
        lines.append(f"Not reached over all the time, and reported as such: {listed}.")
    if unknown:
        lines.append(f"Not compared, as the references agree no better: {unknown} of the runs.")
    return lines


def report(quick: bool) -> list[Report]:
    """All scenes of the library, in place; quick: one of them, three accuracies.

    Reduced equations that are not built yet are built into `generated`.
    """
    scenes = accuracy_targets.SCENES[: 1 if quick else None]
    errors = accuracy_targets.TARGETS[:: 3 if quick else 1]
    repeats = 1 if quick else 5
    rows = list(accuracy_targets.measure(scenes, errors, None, repeats))
    headings = (
        "scene", "target", "true", "estimated", "true over target", "runs", "settings", "ms",
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
    title = "accuracy targets: true errors, and the cost over that of the cheapest single run"
    return [Report("accuracy", title, headings, table, sentences(rows), plain(records(rows)))]
