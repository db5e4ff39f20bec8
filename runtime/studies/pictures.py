"""Pictures of the studies: an effect ranking, a work-precision diagram; and their files."""

import json
import math
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from codegen.errors import InputError
from codegen.files.whole_files import whole_file
from codegen.presentation import check_parent, finish_axes, new_figure, save_picture
from runtime.integrate.method import METHODS
from runtime.studies.effect_ranking.ranking import Matters, Row, Verdict, percent
from runtime.studies.work_precision.diagram import Line, Point, WorkPrecision
from runtime.studies.work_precision.interpretation import front, headline, records

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

VERDICT_COLOURS = {
    Verdict.MATTERS: "#b23a48",
    Verdict.NEGLIGIBLE: "#1f6fb2",
    Verdict.NONE_SEEN: "#9aa4ae",
}
PALETTE = (
    "#1f6fb2", "#2a9d8f", "#8a9a2b", "#b23a48", "#e07b1a", "#7b5ea7", "#5d4037", "#c2185b",
    "#00838f", "#546e7a",
)  # fmt: skip
METHOD_COLOURS = dict(zip(METHODS, cycle(PALETTE), strict=False))
"""Colour of each method, in the order of the register."""
LOOKS = {("cartesian", "step"): ("-", "o"), ("reduced", "step"): ("--", "s"),
         ("cartesian", "stage"): (":", "^"), ("cartesian", "projection"): ("-.", "v")}  # fmt: skip
"""Formulation, correction → style of the line, marker."""
GREY, DARK, FRONT = "#b5bcc4", "#1b1f24", "#ffd84d"
_HEIGHT, _LINE = 390.0, 11.0  # points: height of the axes, about, and of a line of text
_FAILED = -0.75  # place of runs that did not reach their end, on the axis of digits


def draw_ranking(ranking: Matters) -> "Figure":
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


def save_ranking(ranking: Matters, path: Path) -> tuple[Path]:
    """Draw to a file; returns the path."""
    save_picture(draw_ranking(ranking), path)
    return (path,)


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
    paper = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    for height, (row, length) in enumerate(zip(ranking.rows, lengths, strict=True)):
        if row.change is None:
            verdict = str(row.verdict)
            axes.text(1.3 * floor, height, verdict, va="center", fontsize=8, style="italic")
            continue
        seen, end = row.verdict is not Verdict.NONE_SEEN, max(length, floor)
        bar = axes.barh(
            height, end - floor, left=floor, height=0.6, color=VERDICT_COLOURS[row.verdict],
            alpha=1.0 if seen else 0.4,
        )  # fmt: skip
        label = percent(length) if seen else f"below {percent(length)}"
        axes.bar_label(bar, [label], padding=4.0, fontsize=8, bbox=paper)
    if ranking.error is not None:
        axes.axvline(ranking.error, color="#1b1f24", linewidth=1.0, linestyle="--")
        axes.annotate(
            f"permitted: {ranking.error:g}", (ranking.error, 1.0), fontsize=8, xytext=(3, 3),
            xycoords=("data", "axes fraction"), textcoords="offset points",
        )  # fmt: skip
    axes.set_xlabel("relative change of the quantity without it", fontsize=9)


def _times(axes: "Axes", ranking: Matters) -> None:
    for height, row in enumerate(ranking.rows):
        if row.time_share is not None:
            colour = VERDICT_COLOURS[row.verdict]
            bar = axes.barh(height, 100.0 * row.time_share, height=0.6, color=colour)
            axes.bar_label(bar, fmt="%.0f %%", padding=3.0, fontsize=8)
    axes.axvline(0.0, color="#59636e", linewidth=0.8)
    axes.margins(x=0.25)  # for the numbers
    axes.set_xlabel("time saved without it, % of the full run", fontsize=9)
    axes.tick_params(axis="y", length=0)


def check_folder(path: Path) -> None:
    """Refuse a file, or a place in no folder, before the study runs."""
    if path.exists() and not path.is_dir():
        raise InputError(f"--out {path}: it is a file; name a folder.")
    check_parent(path)


def save_diagram(study: WorkPrecision, folder: Path) -> tuple[Path, Path]:
    """Write MODEL__SCENE.jsonl and .png into a folder, which is created; returns the paths."""
    check_folder(folder)
    picture = draw_diagram(study)
    runs = folder / f"{study.model}__{study.scene}.jsonl"
    drawn = runs.with_suffix(".png")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"--out {folder}: {error.strerror or error}.") from error
    lines = (json.dumps(record, allow_nan=False) for record in records(study))
    with whole_file(runs) as temporary:
        temporary.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    save_picture(picture, drawn)
    return runs, drawn


def draw_diagram(study: WorkPrecision) -> "Figure":
    """Colour shows the method, line style the formulation, stars are modelling choices."""
    drawn = new_figure("picture", 10.5, 6.4, dpi=130)
    axes = drawn.subplots()
    axes.set_yscale("log")
    if best := front(study.lines):
        axes.plot(
            *_places(best), color=FRONT, linewidth=9.0, alpha=0.75, solid_capstyle="round",
            zorder=1, label="Pareto front",
        )  # fmt: skip
    for line in study.lines:
        _line(axes, line)
    for line in study.lines:
        if line.refused:  # in the legend, so that none is missing
            axes.plot([], [], color=GREY, linewidth=0.9, label=f"{line.setting.title}: refused")
    _limits(axes, study)
    _failures(axes, study)
    _choices(axes, study)
    _floor(axes, study)
    axes.set_xlabel("correct digits: -log10 of the largest scaled error")
    axes.set_ylabel("processor time of the integration, ms")
    finish_axes(axes, which="major", alpha=0.35, linewidth=0.5)
    _ticks(axes)
    axes.tick_params(labelsize=9)
    axes.legend(
        loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8.5, frameon=False, handlelength=3.2
    )
    if study.build:
        axes.text(
            1.02, 0.0, f"building, apart from all runs:\n{sum(study.build.values()):.1f} s",
            transform=axes.transAxes, fontsize=8.5, va="bottom", color="#59636e",
        )  # fmt: skip
    drawn.suptitle(fill(headline(study), 105), fontsize=11.5, x=0.01, ha="left", weight="bold")
    names = ", ".join(scale.name for scale in study.quantities[:6])
    more = len(study.quantities) - 6
    axes.set_title(
        f"{study.model}/{study.scene}, {study.t_start:g} to {study.t_end:g} s: "
        f"{names}{f' and {more} more' if more > 0 else ''}, at {study.instants} instants",
        fontsize=9.5, loc="left",
    )  # fmt: skip
    return drawn


def _places(points: Sequence[Point]) -> tuple[list[float], list[float]]:
    """Digits and milliseconds of runs."""
    return [point.digits for point in points], [1e3 * point.seconds for point in points]


def _ticks(axes: "Axes") -> None:
    """Times as plain numbers: 1, 2 and 5 of each decade, 1 alone of many decades, more of one."""
    from matplotlib.ticker import LogLocator, NullFormatter

    low, high = axes.get_ylim()
    decades = math.log10(high / low)
    few = (1.0, 2.0, 5.0) if decades > 1.0 else (1.0, 2.0, 3.0, 5.0, 7.0)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if decades > 3.0 else few))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def _line(axes: "Axes", line: Line) -> None:
    setting = line.setting
    colour = METHOD_COLOURS.get(setting.method, DARK)
    style, marker = LOOKS.get((setting.formulation, setting.correction), ("-", "o"))
    if line.done:
        beyond = _places([point for point in line.done if point.beyond])
        axes.plot(*_places(line.done), color=GREY, linewidth=0.9, linestyle=style, zorder=2)
        axes.scatter(*beyond, s=12, color=GREY, marker=marker, zorder=2)
    if line.known:
        axes.plot(
            *_places(line.known), color=colour, linestyle=style, marker=marker, markersize=4.0,
            markerfacecolor=colour if setting.formulation == "cartesian" else "white",
            linewidth=1.7 if setting.correction == "step" else 1.1, zorder=3, label=setting.title,
        )  # fmt: skip


def _choices(axes: "Axes", study: WorkPrecision) -> None:
    """A star per choice, with its name; names of close stars stand one above the other."""
    drawn = [
        (1e3 * choice.point.seconds, max(choice.point.digits, 0.0), choice.title)
        for choice in study.choices
        if choice.point is not None
    ]
    for y, x, _ in drawn:
        axes.scatter(x, y, s=130, marker="*", color=DARK, edgecolor="white", zorder=6)
    low, high = (math.log(limit) for limit in axes.get_ylim())
    top = -math.inf
    for y, x, title in sorted(drawn):
        height = _HEIGHT * (math.log(y) - low) / (high - low)
        top = max(height - 3.0, top + _LINE, 2.0)
        axes.annotate(
            title, (x, y), xytext=(9.0, top - height), textcoords="offset points", fontsize=8.5,
            weight="bold", zorder=7,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.6},
        )  # fmt: skip
    if drawn:
        axes.scatter([], [], s=90, marker="*", color=DARK, label="modelled differently")


def _limits(axes: "Axes", study: WorkPrecision) -> None:
    runs = [point.digits for line in study.lines for point in line.done]
    highest = max([*runs, -math.log10(study.reference.floor), 3.0])
    failed = any(line.failed for line in study.lines)
    lowest = min([0.0, *(max(value, -1.0) for value in runs)])
    axes.set_xlim(_FAILED - 0.5 if failed else lowest - 0.1, math.ceil(highest) + 0.3)
    axes.set_xticks(range(math.ceil(highest) + 1))


def _failures(axes: "Axes", study: WorkPrecision) -> None:
    """A cross per failed run, at the left, as high as the time until it failed."""
    failed = [line for line in study.lines if line.failed]
    if not failed:
        return
    for k, line in enumerate(failed):
        place = _FAILED + 0.6 * ((k + 0.5) / len(failed) - 0.5)
        times = [point.seconds for point in line.failed if not math.isnan(point.seconds)]
        heights = [1e3 * seconds for seconds in times or [study.limit]]
        axes.scatter(
            [place] * len(heights), heights, marker="x", s=34, linewidth=1.6,
            color=METHOD_COLOURS.get(line.setting.method, DARK), zorder=5, clip_on=False,
        )  # fmt: skip
    axes.axvspan(_FAILED - 0.5, _FAILED + 0.45, color="#fbe9e7", zorder=0)
    axes.text(
        _FAILED - 0.02, 0.015, "did not\nreach\nthe end", transform=axes.get_xaxis_transform(),
        ha="center", va="bottom", fontsize=8, color="#8c2f2f",
    )  # fmt: skip


def _floor(axes: "Axes", study: WorkPrecision) -> None:
    floor = -math.log10(study.reference.floor)
    right = axes.get_xlim()[1]
    axes.axvspan(floor, right, facecolor="#eceff1", edgecolor="#cfd4d9", hatch="///",
                 linewidth=0.0, zorder=0)  # fmt: skip
    axes.text(
        right, 0.015, f"the reference has {floor:.1f} digits ",
        transform=axes.get_xaxis_transform(), ha="right", va="bottom", fontsize=8, color="#59636e",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.8}, zorder=8,
    )  # fmt: skip
