"""The effect ranking as a picture: the change that each effect makes, and its cost."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.errors import InputError
from codegen.figures_and_html import check_parent, finish_axes, new_figure
from codegen.files.whole_files import whole_file
from runtime.studies.effect_ranking.ranking import Matters, Row, Verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENDINGS = (".png", ".svg", ".pdf")
COLOURS = {
    Verdict.MATTERS: "#b23a48",
    Verdict.NEGLIGIBLE: "#1f6fb2",
    Verdict.NONE_SEEN: "#9aa4ae",
}


def check_place(path: Path) -> None:
    """Refuse an ending that is no picture's, or a place in no folder, before anything runs."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"--out {path}: a picture ends in {', '.join(ENDINGS)}.")
    check_parent(path)


def save(ranking: Matters, path: Path) -> tuple[Path]:
    """Draw to a file; returns the path."""
    check_place(path)
    with whole_file(path) as temporary:
        figure(ranking).savefig(temporary)
    return (path,)


def figure(ranking: Matters) -> "Figure":
    """Changes on a logarithmic scale (pale: the uncertainty, where larger), and shares of time."""
    drawn = new_figure("picture", 9.0, 1.6 + 0.36 * len(ranking.rows), dpi=130)
    left, right = drawn.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    _changes(left, ranking)
    _times(right, ranking)
    left.set_yticks(range(len(ranking.rows)), [row.title for row in ranking.rows], fontsize=9)
    left.set_ylim(len(ranking.rows) - 0.4, -0.6)
    title = f"{ranking.model}/{ranking.scene}: {ranking.quantity} = {ranking.value:.6g}"
    drawn.suptitle(f"{title} {ranking.unit}".rstrip(), fontsize=11)
    for axes in (left, right):
        finish_axes(axes, axis="x", alpha=0.3, linewidth=0.4)
        axes.tick_params(labelsize=8)
    return drawn


def _length(row: Row) -> float:
    """The length of a row's bar: its change, or its uncertainty where that is larger."""
    if row.change is None:
        return 0.0
    return row.doubt if row.verdict is Verdict.NONE_SEEN else abs(row.change)


def _changes(axes: "Axes", ranking: Matters) -> None:
    lengths = [_length(row) / (ranking.size or 1.0) for row in ranking.rows]
    limits = [*(length for length in lengths if length > 0.0), *filter(None, [ranking.error])]
    lowest = min([*limits, 1.0])
    floor = 10.0 ** (math.floor(math.log10(lowest)) - 0.5)
    axes.set_xscale("log")
    axes.set_xlim(floor, 40.0 * max([*limits, 10.0 * lowest]))
    for height, (row, length) in enumerate(zip(ranking.rows, lengths, strict=True)):
        if row.change is None:
            verdict = str(row.verdict)
            axes.text(1.3 * floor, height, verdict, va="center", fontsize=8, style="italic")
            continue
        seen, colour = row.verdict is not Verdict.NONE_SEEN, COLOURS[row.verdict]
        pale = 1.0 if seen else 0.4
        axes.barh(height, length - floor, left=floor, height=0.6, color=colour, alpha=pale)
        number = f"{100 * length:.2g}" if length < 1.0 else f"{100 * length:.0f}"
        label = f"{number} %" if seen else f"below {number} %"
        paper = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        axes.text(1.2 * max(length, floor), height, label, va="center", fontsize=8, bbox=paper)
    if ranking.error is not None:
        axes.axvline(ranking.error, color="#1b1f24", linewidth=1.0, linestyle="--")
        axes.annotate(
            f"permitted: {ranking.error:g}", (ranking.error, 1.0), fontsize=8, xytext=(3, 3),
            xycoords=("data", "axes fraction"), textcoords="offset points",
        )  # fmt: skip
    axes.set_xlabel("relative change of the quantity without it", fontsize=9)


def _times(axes: "Axes", ranking: Matters) -> None:
    shares = [100.0 * (row.time_share or 0.0) for row in ranking.rows]
    span = max([*map(abs, shares), 1.0])
    for height, (row, share) in enumerate(zip(ranking.rows, shares, strict=True)):
        if row.time_share is None:
            continue
        axes.barh(height, share, height=0.6, color=COLOURS[row.verdict])
        side = "left" if share >= 0.0 else "right"
        gap = 0.02 * span * (1 if share >= 0.0 else -1)
        axes.text(share + gap, height, f"{share:.0f} %", va="center", ha=side, fontsize=8)
    axes.axvline(0.0, color="#59636e", linewidth=0.8)
    room = 0.25 * span  # for the numbers
    axes.set_xlim(min(0.0, min(shares) - room), max(0.0, *shares) + room)
    axes.set_xlabel("time saved without it, % of the full run", fontsize=9)
    axes.tick_params(axis="y", length=0)
