"""The work-precision diagram as a picture: digits against milliseconds, a line per setting."""

import math
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from codegen.errors import InputError
from codegen.figures_and_html import check_parent, finish_axes, new_figure
from codegen.files.whole_files import whole_file
from runtime.integrate.method import METHODS
from runtime.studies.work_precision.diagram import Line, Point, WorkPrecision
from runtime.studies.work_precision.interpretation import front, headline
from runtime.studies.work_precision.json_records import write_records

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PALETTE = (
    "#1f6fb2", "#2a9d8f", "#8a9a2b", "#b23a48", "#e07b1a", "#7b5ea7", "#5d4037", "#c2185b",
    "#00838f", "#546e7a",
)  # fmt: skip
COLOURS = dict(zip(METHODS, cycle(PALETTE), strict=False))
"""Colour of each method, in the order of the register."""
LOOKS = {("cartesian", "step"): ("-", "o"), ("reduced", "step"): ("--", "s"),
         ("cartesian", "stage"): (":", "^"), ("cartesian", "projection"): ("-.", "v")}  # fmt: skip
"""Formulation, correction → style of the line, marker."""
GREY, DARK, FRONT = "#b5bcc4", "#1b1f24", "#ffd84d"
_HEIGHT, _LINE = 390.0, 11.0  # points: height of the axes, about, and of a line of text
_FAILED = -0.75  # place of runs that did not reach their end, on the axis of digits


def check_place(path: Path) -> None:
    """Refuse a file, or a place in no folder, before the study runs."""
    if path.exists() and not path.is_dir():
        raise InputError(f"--out {path}: it is a file; name a folder.")
    check_parent(path)


def save(study: WorkPrecision, folder: Path) -> tuple[Path, Path]:
    """Write MODEL__SCENE.jsonl and .png into a folder, which is created; returns the paths."""
    check_place(folder)
    picture = figure(study)
    records = folder / f"{study.model}__{study.scene}.jsonl"
    drawn = records.with_suffix(".png")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"--out {folder}: {error.strerror or error}.") from error
    with whole_file(records) as temporary:
        write_records(study, temporary)
    with whole_file(drawn) as temporary:
        picture.savefig(temporary)
    return records, drawn


def figure(study: WorkPrecision) -> "Figure":
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
    colour = COLOURS.get(setting.method, DARK)
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
            color=COLOURS.get(line.setting.method, DARK), zorder=5, clip_on=False,
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
