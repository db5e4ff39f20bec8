"""One look for all figures, and their files."""

from collections.abc import Iterable
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

STYLE = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.alpha": 0.5,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "svg.hashsalt": "linkwright",
    "svg.fonttype": "none",
    "figure.dpi": 110,
    "savefig.dpi": 150,
}


def draw(figures: Iterable[tuple[str, Figure]], folder: Path) -> list[Path]:
    """Write (name, figure) pairs as PNG and SVG; returns the paths.

    The style holds while a generator draws, so figures are to be yielded one by one.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    with mpl.rc_context(STYLE):
        for name, figure in figures:
            for ending in ("png", "svg"):
                path = folder / f"figure_{name}.{ending}"
                figure.savefig(path, metadata={"Date": None} if ending == "svg" else None)
                written.append(path)
    return written
