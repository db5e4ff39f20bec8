"""Growth with size, as a picture."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchmarks.growth import Row

MEASURES = {
    "operations": "operations a call",
    "nanoseconds": "ns a call",
    "build": "s to build",
    "milliseconds": "ms to an error of 1e-6",
}
COLOURS = {"chain": "#1f77b4", "n_four_bar": "#d62728"}
NAMES = {"chain": "chain", "n_four_bar": "N-four-bar"}


def draw(rows: Sequence["Row"], path: Path) -> Path:
    """A panel a measure, both axes logarithmic; reduced full, cartesian dashed."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 3.4), dpi=130, layout="constrained")
    panels = figure.subplots(1, len(MEASURES))
    kinds = sorted({(row.family, row.formulation) for row in rows}, reverse=True)
    for axes, (measure, title) in zip(panels, MEASURES.items(), strict=True):
        for family, formulation in kinds:
            chosen = [r for r in rows if (r.family, r.formulation) == (family, formulation)]
            line = [(r.size, getattr(r, measure)) for r in chosen]
            line = [(x, y) for x, y in line if math.isfinite(y) and y > 0.0]
            if line:
                dashes = "-" if formulation == "reduced" else "--"
                axes.plot(
                    *zip(*line, strict=True),
                    dashes,
                    color=COLOURS[family],
                    marker=".",
                    label=f"{NAMES[family]}, {formulation}",
                )
        axes.set(xscale="log", yscale="log", xlabel="N")
        axes.set_title(title, fontsize=10)
        sizes = sorted({row.size for row in rows})
        axes.set_xticks(sizes, [str(size) for size in sizes])
        axes.minorticks_off()
        axes.grid(True, color="#eeeeee")
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    panels[0].legend(fontsize=7.5, frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path
