"""A ledger as a picture: operations of each kernel and nanoseconds, stacked by part."""

from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from codegen.errors import InputError
from codegen.explain.ledger import Ledger, Part
from codegen.files.whole_files import whole_file
from codegen.object_display import html_table
from codegen.presentation import finish_axes, html_figure, html_page, new_figure, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 11  # parts with a colour of their own; smaller ones are drawn together
COLOURS = (
    *("#1f6fb2", "#d9822b", "#2f8f5b", "#b23a48", "#7356a8", "#8a6a4f", "#d472a8", "#a3a832"),
    *("#2aa5b5", "#e0b13c", "#5b7fd1"),
)
SHARED = {"factorization": "#59636e", "correction": "#9aa4ae", "sums": "#cdd3d9"}
REST = "#e6e8ea"
ENDINGS = (".png", ".svg", ".html")


def write(ledgers: Sequence[Ledger], path: Path) -> Path:
    """Draw ledgers one below the other; returns the path.

    Raises InputError if the ending is none of .png, .svg and .html, matplotlib is missing, or the
    file cannot be written.
    """
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"--out {path}: a ledger is saved as {', '.join(ENDINGS)}.")
    with whole_file(path) as temporary:
        if path.suffix.lower() == ".html":
            temporary.write_text(page(ledgers), encoding="utf-8")
        else:
            save_figure(figure(ledgers), temporary)
    return path


def figure(ledgers: Sequence[Ledger]) -> "Figure":
    """A panel of operations a ledger, with one of nanoseconds where they were measured."""
    bars = [bar for ledger in ledgers for bar in _panels(ledger)]
    heights = [0.55 + 0.3 * len(rows) for _, _, rows, _ in bars]
    picture = new_figure("picture", 9.0, 0.5 + sum(heights), dpi=130)
    axes = picture.subplots(len(bars), 1, squeeze=False, height_ratios=heights)[:, 0]
    for place, (ledger, unit, rows, title) in zip(axes, bars, strict=True):
        _stack(place, _coloured(ledger), rows)
        place.set_title(title, loc="left", fontsize=10)
        place.set_xlabel(unit, fontsize=9)
    return picture


Rows = dict[str, dict[str, float]]  # bar → part → its length


def _panels(ledger: Ledger) -> Iterator[tuple[Ledger, str, Rows, str]]:
    operations: Rows = {
        kernel: {p.name: float(p.operations.get(kernel, 0)) for p in ledger.parts}
        for kernel in ledger.kernels
    }
    yield ledger, "operations", operations, f"{ledger.title}: operations"
    if ledger.nanoseconds is not None:
        times = {p.name: p.nanoseconds or 0.0 for p in ledger.parts}
        title = f"{ledger.title}: time of an evaluation, measured"
        yield ledger, "ns", {"accelerations": times}, title


def _coloured(ledger: Ledger) -> dict[str, str]:
    """Part → colour; what costs most has one of its own, and what all share is grey."""
    costly = sorted((p for p in ledger.parts if p.role != "shared"), key=_weight, reverse=True)
    chosen = {p.name for p in costly[:MOST] if _weight(p) > 0}
    names = [p.name for p in ledger.parts if p.name in chosen]
    return dict(zip(names, COLOURS, strict=False)) | {
        p.name: SHARED.get(p.name, REST) for p in ledger.parts if p.role == "shared"
    }


def _weight(part: Part) -> float:
    return part.total + 10 * abs(part.nanoseconds or 0.0)


def _stack(axes: "Axes", colours: dict[str, str], rows: Rows) -> None:
    """Stacked bars, the first on top; what takes less than nothing is drawn left of zero."""
    count = len(rows)
    heights = np.arange(count)
    ends = np.zeros((2, count))  # of the bars right of zero, and left of it
    small = [sum(x for part, x in row.items() if part not in colours) for row in rows.values()]
    stacked = {part: [row.get(part, 0.0) for row in rows.values()] for part in colours}
    for part, lengths in (stacked | {"others": small}).items():
        if any(lengths):
            side = np.less(lengths, 0.0).astype(int)
            axes.barh(
                heights, lengths, left=ends[side, heights], height=0.7, linewidth=0.4,
                edgecolor="white", color=colours.get(part, REST), label=part,
            )  # fmt: skip
            ends[side, heights] += lengths
    for height, row in enumerate(rows.values()):
        axes.text(
            ends[0, height], height, f"  {_short(sum(row.values()))}", va="center", fontsize=8
        )
    axes.set_yticks(heights, list(rows), fontsize=8)
    axes.set_ylim(count - 0.4, -0.6)
    axes.tick_params(axis="x", labelsize=8)
    finish_axes(axes, axis="x", alpha=0.3, linewidth=0.4)
    axes.set_xlim(1.05 * ends[1].min(initial=0.0), 1.08 * ends[0].max(initial=0.0) or 1.0)
    if axes.containers:
        axes.legend(
            frameon=False, fontsize=8, ncols=1 if count > 4 else 2, loc="center left",
            bbox_to_anchor=(1.0, 0.5), handlelength=1.0,
        )  # fmt: skip


def _short(value: float) -> str:
    return f"{value:.0f}" if value == round(value) else f"{value:.1f}"


def page(ledgers: Sequence[Ledger]) -> str:
    """A page that needs nothing else: each ledger's picture, then its table."""
    parts: list[str] = []
    for ledger in ledgers:
        heading = f"<h1>{escape(ledger.title)}</h1>"
        parts += [heading, html_figure(figure([ledger])), _table(ledger)]
    return html_page("What a scene costs", parts)


def _table(ledger: Ledger) -> str:
    heads = ("part", "", "kind", "why", "accelerations", "all kernels", "ns", "events")
    rows = [
        (
            part.name, "in" if part.acts else "out", part.kind, part.why, part.solving or "",
            part.total or "", "" if part.nanoseconds is None else f"{part.nanoseconds:.1f}",
            len(part.events) or "",
        )
        for part in ledger.parts
    ]  # fmt: skip
    return html_table(heads, rows)
