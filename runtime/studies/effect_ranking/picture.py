"""Which effects matter, as a picture: what each changes, beside what it costs."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.errors import InputError
from runtime.studies.effect_ranking.ranking import Matters, Row, Verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENDINGS = (".png", ".svg", ".pdf")
COLOURS = {
    Verdict.MATTERS: "#b23a48",
    Verdict.NEGLIGIBLE: "#1f6fb2",
    Verdict.NONE_SEEN: "#9aa4ae",
    Verdict.NEEDED: "#59636e",
    Verdict.IMPOSSIBLE: "#59636e",
}


def check_picture(path: Path) -> None:
    """Refuse a file that could not be drawn, before anything is run for it.

    Raises
    ------
    InputError
        For an ending that is no picture's, or a folder that does not exist.
    """
    if path.suffix not in ENDINGS:
        raise InputError(f"--out {path}: a picture ends in {', '.join(ENDINGS)}.")
    if not path.resolve().parent.is_dir():
        raise InputError(f"--out {path}: the folder {path.resolve().parent} does not exist.")


def save(told: Matters, path: Path) -> Path:
    """Draw to a file; returns the path.

    Raises
    ------
    InputError
        As `check_picture`; if matplotlib is missing or the file cannot be written.
    """
    check_picture(path)
    try:
        figure(told).savefig(path)
    except OSError as error:
        raise InputError(f"--out {path}: {error.strerror or error}.") from error
    return path


def figure(told: Matters) -> "Figure":
    """Changes of the quantity on a logarithmic scale, and shares of the run's time, as bars.

    A pale bar ends where the change could still be hidden by what the run is not known to.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError(
            "A picture needs matplotlib, which is not installed. Install linkwright[plot]."
        ) from error
    made = Figure(figsize=(9.0, 1.6 + 0.36 * len(told.rows)), layout="constrained", dpi=130)
    left, right = made.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    _changes(left, told)
    _times(right, told)
    left.set_yticks(range(len(told.rows)), [row.title for row in told.rows], fontsize=9)
    left.set_ylim(len(told.rows) - 0.4, -0.6)
    unit = f" {told.unit}" if told.unit else ""
    made.suptitle(
        f"{told.model}/{told.scene}: {told.quantity} = {told.value:.6g}{unit}", fontsize=11
    )
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(visible=True, axis="x", alpha=0.3, linewidth=0.4)
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=8)
    return made


def _size(told: Matters) -> float:
    return told.size or 1.0


def _shown(row: Row) -> float:
    """What is drawn of a row: its change, or what a change that is not seen may be at most."""
    if row.change is None:
        return 0.0
    return row.doubt if row.verdict is Verdict.NONE_SEEN else abs(row.change)


def _changes(axes: "Axes", told: Matters) -> None:
    size = _size(told)
    shown = [_shown(row) / size for row in told.rows if _shown(row) > 0.0]
    lowest = min([*shown, told.error or math.inf, 1.0])
    highest = max([*shown, told.error or 0.0, 10.0 * lowest])
    floor = 10.0 ** (math.floor(math.log10(lowest)) - 0.5)
    axes.set_xscale("log")
    axes.set_xlim(floor, 40.0 * highest)
    for height, row in enumerate(told.rows):
        _change(axes, height, row, size, floor)
    if told.error is not None:
        axes.axvline(told.error, color="#1b1f24", linewidth=1.0, linestyle="--")
        axes.annotate(
            f"E = {told.error:g}", (told.error, 1.0), xycoords=("data", "axes fraction"),
            xytext=(3, 3), textcoords="offset points", fontsize=8,
        )  # fmt: skip
    axes.set_xlabel("change of the quantity, relative", fontsize=9)


def _change(axes: "Axes", height: int, row: Row, size: float, floor: float) -> None:
    if row.change is None:
        axes.text(1.3 * floor, height, str(row.verdict), va="center", fontsize=8, style="italic")
        return
    seen = row.verdict is not Verdict.NONE_SEEN
    drawn = _shown(row) / size
    colour = COLOURS[row.verdict]
    axes.barh(height, drawn - floor, left=floor, height=0.6, color=colour, alpha=1 if seen else 0.4)
    number = f"{100 * drawn:.2g}" if drawn < 1.0 else f"{100 * drawn:.0f}"
    label = f"{number} %" if seen else f"none seen above {number} %"
    paper = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    axes.text(1.2 * max(drawn, floor), height, label, va="center", fontsize=8, bbox=paper)


def _times(axes: "Axes", told: Matters) -> None:
    shares = [100.0 * (row.time_share or 0.0) for row in told.rows]
    span = max([*map(abs, shares), 1.0])
    for height, (row, share) in enumerate(zip(told.rows, shares, strict=True)):
        if row.time_share is None:
            continue
        axes.barh(height, share, height=0.6, color=COLOURS[row.verdict])
        side = "left" if share >= 0.0 else "right"
        gap = 0.02 * span * (1 if share >= 0.0 else -1)
        axes.text(share + gap, height, f"{share:.0f} %", va="center", ha=side, fontsize=8)
    axes.axvline(0.0, color="#59636e", linewidth=0.8)
    axes.set_xlim(min(0.0, 1.3 * min(shares)), 1.3 * max([*shares, 0.1 * span]))
    axes.set_xlabel("share of the run's time that goes with it", fontsize=9)
    axes.tick_params(axis="y", length=0)
