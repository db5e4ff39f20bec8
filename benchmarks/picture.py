"""The work-precision diagram of a contest."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.contest import FLOOR, OURS, PEERS, TARGETS, Contest
from benchmarks.precision import best_time, reliable, series
from benchmarks.problems import PROBLEMS

COLOURS = {
    "exudyn": "#b5651d",
    "pinocchio": "#8c3b8c",
    "mujoco": "#2e8b57",
    "pydy": "#c71585",
    "scipy": "#777777",
    "casadi": "#9a9a33",
    "numbalsoda": "#6b8e23",
    "heyoka": "#4f7fa8",
}
OUR_COLOURS = {"reduced": "#d62728", "cartesian": "#ff8c2e"}


def draw(contest: Contest, path: Path) -> Path:
    """Digits against milliseconds, a line a contestant by its best method."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 5.6), dpi=130, layout="constrained")
    axes = figure.add_subplot()
    axes.set(xscale="log", yscale="log", ylabel="time, ms")
    problem, labels = PROBLEMS[contest.problem], []
    axes.set_xlabel(f"error, {problem.unit}")
    for (name, method), points in series(contest.points).items():
        line = [(e, t) for e, t in reliable(points) if e <= 1.0]
        if not line or (name in PEERS and method != best_method(contest, name)):
            continue
        errors, times = zip(*line, strict=True)
        style = look(name, method)
        axes.plot(errors, times, **style)
        text = {OURS: f"linkwright, {method}", FLOOR: method}.get(name, f"{name}, {method}")
        labels.append((times[-1], errors[-1], text, style["color"]))
    for target in TARGETS:
        axes.axvline(target, color="#cccccc", linewidth=1.0, zorder=0)
    least = min((error for _, error, *_ in labels), default=1e-12)
    axes.set_xlim(1.5, max(least, 1e-15) * 0.3)
    axes.axvspan(problem.trusted, 1e-18, color="#f1f1f1", zorder=-1)
    axes.grid(True, which="major", color="#eeeeee")
    axes.set_axisbelow(True)
    axes.set_title(f"{problem.title}: time to an error", loc="left")
    label_ends(axes, labels)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


def best_method(contest: Contest, name: str) -> str:
    """The one that is drawn: best at the tighter error that any reaches, or nearest to it."""
    for target in (*reversed(TARGETS), 1e-4, 1e-2, 1.0):
        time, method = best_time(target, contest.of(name))
        if math.isfinite(time):
            return method
    return ""


def look(name: str, method: str) -> dict[str, Any]:
    """How a line is drawn: ours and the floor thick, hand-reduced equations dashed."""
    if name == OURS:
        return {"color": OUR_COLOURS[method], "linewidth": 2.6, "marker": "o", "markersize": 3.5}
    if name == FLOOR:
        dashes = "-" if method == "floor" else ":"
        return {"color": "#000000", "linewidth": 2.2, "linestyle": dashes}
    dashes = "-" if PEERS[name].multibody else "--"
    return {
        "color": COLOURS[name],
        "linewidth": 1.4,
        "linestyle": dashes,
        "marker": ".",
        "markersize": 4,
    }


def label_ends(axes: object, labels: Sequence[tuple[float, float, str, object]]) -> None:
    """Names at the right edge at the heights of the lines' ends, kept apart from one another."""
    low, high = axes.get_ylim()  # type: ignore[attr-defined]
    span = math.log(high / low)
    gap = 0.045
    heights: list[float] = []
    for time, *_ in sorted(labels):
        height = math.log(time / low) / span
        heights.append(max(height, heights[-1] + gap) if heights else height)
    over = max(heights[-1] - 1.0, 0.0) if heights else 0.0
    for (_, _, text, colour), height in zip(sorted(labels), heights, strict=True):
        axes.text(  # type: ignore[attr-defined]
            1.01,
            height - over,
            text,
            color=colour,
            transform=axes.transAxes,  # type: ignore[attr-defined]
            va="center",
            fontsize=8.5,
        )
