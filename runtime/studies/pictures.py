"""Pictures of the studies: an effect ranking, a work-precision diagram; and their files."""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import cycle
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError
from codegen.files.whole_files import whole_file
from codegen.presentation import check_parent, finish_axes, new_figure, save_picture
from runtime.integrate.method import METHODS
from runtime.results.samples import plain
from runtime.studies.diagram import Line, Point, WorkPrecision, effectivity, front, headline, slope
from runtime.studies.harness import Setting
from runtime.studies.ranking import Matters, Row, Verdict, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PALETTE = (
    "#1f6fb2", "#2a9d8f", "#8a9a2b", "#b23a48", "#e07b1a", "#7b5ea7", "#5d4037", "#c2185b",
    "#00838f", "#546e7a",
)  # fmt: skip
METHOD_COLOURS = dict(zip(METHODS, cycle(PALETTE), strict=False))
"""Colour of each method, in the order of the register."""
LOOKS = {("cartesian", "step"): ("-", "o"), ("reduced", "step"): ("--", "s"),
         ("cartesian", "stage"): (":", "^"), ("cartesian", "projection"): ("-.", "v")}  # fmt: skip
"""Formulation, correction → style of the line, marker."""
GREY, DARK, FRONT, PALE = "#b5bcc4", "#1b1f24", "#ffd84d", "#9aa4ae"
VERDICT_COLOURS = {Verdict.MATTERS: PALETTE[3], Verdict.NEGLIGIBLE: PALETTE[0]}
PAPER = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.8}
_HEIGHT, _LINE = 390.0, 11.0  # points: height of the axes, about, and of a line of text
_FAILED = -0.75  # place of runs that did not reach their end, on the axis of digits


def draw_ranking(ranking: Matters) -> "Figure":
    """Changes on a logarithmic scale (pale: the uncertainty, where larger), and shares of time."""
    rows, size = ranking.rows, ranking.size or 1.0
    drawn = new_figure("picture", 9.0, 1.6 + 0.36 * len(rows), dpi=130)
    left, right = drawn.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    heights, colours = range(len(rows)), [VERDICT_COLOURS.get(row.verdict, PALE) for row in rows]

    def draw(axes: "Axes", first: float, widths: list[float], labels: list[str], what: str) -> None:
        bars = axes.barh(heights, widths, left=first, height=0.6, color=colours)
        axes.bar_label(bars, labels, padding=4.0, fontsize=8, bbox=PAPER)
        axes.set_xlabel(what, fontsize=9)
        finish_axes(axes, axis="x", alpha=0.3, linewidth=0.4)
        axes.tick_params(labelsize=8)

    lengths = [_length(row) / size for row in rows]
    limits = [length for length in (*lengths, ranking.error or 0.0) if length > 0.0] or [1.0]
    floor = 10.0 ** (math.floor(math.log10(min(*limits, 1.0))) - 0.5)
    widths = [max(length - floor, 0.0) for length in lengths]
    title = "relative change of the quantity without it"
    draw(left, floor, widths, [*map(_label, rows, lengths)], title)
    left.set_xscale("log")
    left.set_xlim(floor, 40.0 * max(*limits, 10.0 * floor))
    if ranking.error is not None:
        left.axvline(ranking.error, color=DARK, linewidth=1.0, linestyle="--")
        left.annotate(
            f"permitted: {ranking.error:g}", (ranking.error, 1.0), fontsize=8, xytext=(3, 3),
            xycoords=("data", "axes fraction"), textcoords="offset points",
        )  # fmt: skip
    shares = [row.time_share for row in rows]
    labels = ["" if share is None else f"{share:.0%}" for share in shares]
    saved = [100.0 * (share or 0.0) for share in shares]
    draw(right, 0.0, saved, labels, "time saved without it, % of the full run")
    right.axvline(0.0, color=PALE, linewidth=0.8)
    right.margins(x=0.25)  # for the numbers
    left.set_yticks(heights, [row.title for row in rows])
    left.set_ylim(len(rows) - 0.4, -0.6)
    title = f"{ranking.model}/{ranking.scene}: {ranking.quantity} = {ranking.value:.6g}"
    drawn.suptitle(f"{title} {ranking.unit}".rstrip(), fontsize=11)
    return drawn


def _length(row: Row) -> float:
    """The length of a row's bar: its change, or its uncertainty where that is larger."""
    return row.doubt if row.verdict is Verdict.NONE_SEEN else abs(row.change or 0.0)


def _label(row: Row, length: float) -> str:
    if row.change is None:
        return row.verdict
    return f"below {percent(length)}" if row.verdict is Verdict.NONE_SEEN else percent(length)


def save_ranking(ranking: Matters, path: Path) -> tuple[Path]:
    """Draw to a file; returns the path."""
    save_picture(draw_ranking(ranking), path)
    return (path,)


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
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"--out {folder}: {error.strerror or error}.") from error
    lines = (json.dumps(record, allow_nan=False) for record in records(study))
    with whole_file(runs) as temporary:
        temporary.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    save_picture(picture, runs.with_suffix(".png"))
    return runs, runs.with_suffix(".png")


def records(study: WorkPrecision) -> Iterator[dict[str, Any]]:
    """One mapping per run, per refused setting, and per modelling choice."""
    names = ("model", "scene", "model_sha256", "t_start", "t_end", "instants", "environment")
    reference = study.reference
    common = {name: getattr(study, name) for name in names} | {
        "artefact_sha256": study.artefact, "energy_against": study.energy,
        "scales": {scale.name: scale.value for scale in study.quantities},
        "reference": reference.source, "independent": reference.independent,
        "floor": reference.floor, "choice": "",
    }  # fmt: skip
    runs: list[tuple[Setting, Point | None, str, dict[str, Any]]] = [
        (line.setting, x, line.refused, {"slope": slope(line), "effectivity": effectivity(line)})
        for line in study.lines
        for x in line.points or (None,)
    ]
    for one in study.choices:
        about = {"scene_run": one.scene, "choice": one.title}
        runs.append((one.setting or Setting(""), one.point, one.reason, about))
    sizes = {scale.name: scale.value for scale in study.quantities if scale.group == "positions"}
    for setting, point, reason, about in runs:
        run: dict[str, Any] = {"outcome": "REFUSED", "message": reason}
        if point is not None:
            atol = {name: point.rtol * min(1.0, size) for name, size in sizes.items()}
            run = {**asdict(point), "atol": atol, "digits": point.digits}
        yield plain({**common, **asdict(setting), **about, **run})


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
        _draw_line(axes, line)
    _draw_failures(axes, study)
    _draw_choices(axes, study)
    _draw_floor(axes, study)
    axes.set_xlabel("correct digits: -log10 of the largest scaled error")
    axes.set_ylabel("processor time of the integration, ms")
    finish_axes(axes, which="major", alpha=0.35, linewidth=0.5)
    low, high = axes.get_ylim()
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("{x:g}" if high < 100.0 * low else "")
    axes.tick_params(which="both", labelsize=9)
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


def _draw_line(axes: "Axes", line: Line) -> None:
    """Runs that the reference resolves, and in grey all; a refused setting is in the legend."""
    setting = line.setting
    colour = METHOD_COLOURS[setting.method]
    style, marker = LOOKS[setting.formulation, setting.correction]
    axes.plot(*_places(line.done), color=GREY, linewidth=0.9, linestyle=style, zorder=2)
    beyond = [point for point in line.done if point.beyond]
    axes.scatter(*_places(beyond), s=12, color=GREY, marker=marker, zorder=2)
    if line.refused:
        axes.plot([], [], color=GREY, linewidth=0.9, label=f"{setting.title}: refused")
    if line.known:
        axes.plot(
            *_places(line.known), color=colour, linestyle=style, marker=marker, markersize=4.0,
            markerfacecolor=colour if setting.formulation == "cartesian" else "white",
            linewidth=1.7 if setting.correction == "step" else 1.1, zorder=3, label=setting.title,
        )  # fmt: skip


def _draw_failures(axes: "Axes", study: WorkPrecision) -> None:
    """A cross per failed run, at the left, as high as the time until it failed; the limits of x."""
    runs = [point.digits for line in study.lines for point in line.done]
    highest = math.ceil(max(*runs, -math.log10(study.reference.floor), 3.0))
    failed = [line for line in study.lines if line.failed]
    lowest = _FAILED - 0.5 if failed else max(min(*runs, 0.0), -1.0) - 0.1
    axes.set_xlim(lowest, highest + 0.3)
    axes.set_xticks(range(highest + 1))
    for k, line in enumerate(failed):
        place = _FAILED + 0.6 * ((k + 0.5) / len(failed) - 0.5)
        times = [point.seconds for point in line.failed if not math.isnan(point.seconds)]
        heights = [1e3 * seconds for seconds in times or [study.limit]]
        axes.scatter(
            [place] * len(heights), heights, marker="x", s=34, linewidth=1.6,
            color=METHOD_COLOURS[line.setting.method], zorder=5, clip_on=False,
        )  # fmt: skip
    if failed:
        axes.axvspan(lowest, _FAILED + 0.45, color="#fbe9e7", zorder=0)
        _write(axes, _FAILED, "did not\nreach\nthe end", ha="center", color="#8c2f2f")


def _draw_choices(axes: "Axes", study: WorkPrecision) -> None:
    """A star per choice, with its name; names of close stars stand one above the other."""
    drawn = sorted(
        (1e3 * choice.point.seconds, max(choice.point.digits, 0.0), choice.title)
        for choice in study.choices
        if choice.point is not None
    )
    low, high = (math.log(limit) for limit in axes.get_ylim())
    top, label = -math.inf, "modelled differently"
    for y, x, title in drawn:
        axes.scatter(x, y, s=130, marker="*", color=DARK, edgecolor="white", zorder=6, label=label)
        height, label = _HEIGHT * (math.log(y) - low) / (high - low), ""
        top = max(height - 3.0, top + _LINE, 2.0)
        axes.annotate(
            title, (x, y), xytext=(9.0, top - height), textcoords="offset points", fontsize=8.5,
            weight="bold", zorder=7, bbox=PAPER,
        )  # fmt: skip


def _draw_floor(axes: "Axes", study: WorkPrecision) -> None:
    floor, right = -math.log10(study.reference.floor), axes.get_xlim()[1]
    axes.axvspan(floor, right, facecolor="#eceff1", edgecolor="#cfd4d9", hatch="///",
                 linewidth=0.0, zorder=0)  # fmt: skip
    text = f"the reference has {floor:.1f} digits "
    _write(axes, right, text, ha="right", color="#59636e", bbox=PAPER, zorder=8)


def _write(axes: "Axes", x: float, text: str, **style: Any) -> None:
    """Small text above the lower edge."""
    where = axes.get_xaxis_transform()
    axes.text(x, 0.015, text, transform=where, va="bottom", fontsize=8, **style)
