"""The page of an animation as text: template, style, script, data, and its curves by Bokeh."""

import json
import re
import sys
from collections.abc import Iterator
from functools import cache
from html import escape
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.drawing.styles import COUNT, DARK, LIGHT, STYLES
from codegen.errors import InputError
from runtime.mechanism.series_table import Series
from runtime.show.animation.page_data import compressed, rounded

if TYPE_CHECKING:
    from runtime.results.result import Result


_FOLDER = Path(__file__).parent / "page"
SCRIPTS = (
    "data", "poses", "signs", "scene", "lines", "labels", "arrows", "traces", "flashes",
    "camera", "hold", "stage", "clock", "timeline", "curves", "state_text", "controls", "keys",
    "surroundings", "main",
)  # fmt: skip
"""The modules of the script, each after those that it imports."""
_PIXELS = 1.4  # layout: in a page, of a line that is a point wide in a figure
_PLANE_ALONE = {"lines", "traces", "hold"}
SPACE_SCRIPTS = tuple(
    part for name in SCRIPTS if name not in _PLANE_ALONE
    for part in (("solids", name) if name == "stage" else (name,))
)  # fmt: skip
"""The same of a page of machines in space: files of `page/space` stand in for those of their name,
which they import as ../NAME.js."""
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "(\.\.?)/(\w+)\.js";$', re.MULTILINE)
_LISTED = re.compile(r"^export \{ (\w+) \};\n", re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async )?(?:const|function|class) (\w+))", re.MULTILINE)


@cache
def script(in_space: bool = False) -> str:
    """All modules in one text: each is a function that is called once and returns its exports."""
    parts = ['"use strict";']
    for name in SPACE_SCRIPTS if in_space else SCRIPTS:
        own = _FOLDER / "space" / f"{name}.js"
        replaced = in_space and own.exists()
        plane = _FOLDER / f"{name}.js"
        if plane.exists() and (not replaced or f'"../{name}.js"' in own.read_text("utf-8")):
            parts.append(_module(f"plane_{name}" if replaced else name, plane))
        if replaced:
            parts.append(_module(name, own))
    return "\n".join(parts)


def _module(name: str, file: Path) -> str:
    text = file.read_text(encoding="utf-8")
    listed = _LISTED.findall(text)
    exports = ", ".join([*(found[2] for found in _EXPORT.finditer(text)), *listed])

    def constant(found: re.Match[str]) -> str:
        names, folder, other = found.groups()
        is_plane = folder == ".." and (_FOLDER / "space" / f"{other}.js").exists()
        source = f"module_plane_{other}" if is_plane else f"module_{other}"
        return f"const {names.replace(' as ', ': ')} = {source};"

    body = _EXPORT.sub(r"\1", _IMPORT.sub(constant, _LISTED.sub("", text)))
    return f"const module_{name} = (() => {{\n{body}return {{ {exports} }};\n}})();"


@cache
def style() -> str:
    """The style sheet, colours of both themes first."""
    light, dark = (
        " ".join(f"--{name}: {color};" for name, color in colors.items())
        for colors in (LIGHT, DARK)
    )
    numbered = " ".join(
        f".body-{k} {{ --fill: var(--fill-{k}); --line: var(--line-{k}); }} "
        f".run-{k} {{ color: var(--line-{k}); }}"
        for k in range(COUNT)
    )
    lines = "\n".join(
        f".world .{name} {{ fill: {_color(one.fill)}; stroke: {_color(one.line)}; "
        f"stroke-width: {_PIXELS * one.width:.1f}px; }}"
        for name, one in STYLES.items()
        if one.layer != "signs" or name == "driver"
    )
    sheet = (_FOLDER / "page.css").read_text(encoding="utf-8")
    return (
        f":root, :root[data-theme=light] {{ color-scheme: light; {light} }}\n"
        f"@media (prefers-color-scheme: dark) {{ :root {{ color-scheme: dark; {dark} }} }}\n"
        f":root[data-theme=dark] {{ color-scheme: dark; {dark} }}\n{numbered}\n{sheet}\n{lines}\n"
    )


def _color(name: str) -> str:
    return f"var(--{name})" if name else "none"


def page_text(
    title: str, data: str, below: str = "", about: str = "", *, has_curves: bool = True,
    runs: int = 1, in_space: bool = False,
) -> str:  # fmt: skip
    """The page as text, of `runs` runs beside each other, with curves where there is a motion.

    `data` is the block of `page_data`, `below` HTML under the player, `about` text under the title.
    """
    template = (_FOLDER / "page.html").read_text(encoding="utf-8")
    if in_space:
        place = '<script type="text/plain" id="data">'
        template = template.replace(
            place, f'<script type="text/plain" id="three">{{{{three}}}}</script>\n{place}'
        )
    parts = {
        "title": escape(title),
        "about": f'<p class="about" title="{escape(about)}">{escape(about)}</p>' if about else "",
        "style": style(),
        "curves": "\n".join(map(_curve_section, range(PANELS))) if has_curves else "",
        "below": below,
        "data": data,
        "panels": panels(runs).replace("</", "<\\/") if has_curves else "null",
        "library": library() if has_curves else "",
        "script": script(in_space),
        "three": three() if in_space else "",
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], template)


def _curve_section(number: int) -> str:
    return (
        f'<section class="panel" data-panel="{number}" aria-label="Curves {number + 1}">'
        f'<header><select aria-label="Quantity of curves {number + 1}"></select>'
        f'<div class="legend"></div></header>'
        f'<div class="plot"><div id="curves-{number}"></div>'
        f'<div class="cursor" hidden></div></div></section>'
    )


def framed(page: str, title: str, height: int) -> str:
    """A page within a frame of a notebook, in which it needs nothing from outside."""
    return (
        f'<iframe title="{escape(title)}" srcdoc="{escape(page)}" width="100%" height="{height}" '
        'style="border:0" allow="fullscreen" loading="lazy"></iframe>'
    )


PANELS = 4  # layout: panels of curves in a page
MAX_LINES = 6  # layout: curves of a run in a panel
_HEIGHT = 140  # layout: of a panel, px
_LEAST = 70  # layout: of a panel in a low window, px
_ROUNDING = 1e-9  # accuracy: of a group's largest value; a curve that changes by less is constant
_IDENTITIES = re.compile(r'"(p\d+|[0-9a-f]{8}-[0-9a-f-]{27})"')
_SECTIONS = {
    "coordinate": ("Bodies", "position"), "velocity": ("Bodies", "velocity"),
    "spin": ("Bodies", "velocity"), "acceleration": ("Bodies", "acceleration"),
    "state": ("States", "state"),
    "reaction": ("Joints", "reaction"), "effect": ("Effects", "effect"),
    "point": ("Points", "path"), "expression": ("Outputs", "expression"),
    "power": ("Energy", "power"), "energy": ("Energy", "energy"),
}  # fmt: skip
"""Kind of a series → where a panel offers it, and under which word."""
_ANGULAR = {
    "position": "angle", "velocity": "angular velocity", "acceleration": "angular acceleration",
}  # fmt: skip


def require_bokeh() -> None:
    """Refuse to go on without Bokeh, which is looked for and not loaded.

    Raises InputError if it is not installed.
    """
    absent = "bokeh" in sys.modules and sys.modules["bokeh"] is None
    if absent or find_spec("bokeh") is None:
        raise InputError(
            "An animation needs bokeh, which is not installed. Run pip install "
            "'linkwright[animation]', in the checkout pip install '.[animation]'."
        )


@cache
def library() -> str:
    """The script of Bokeh's core, compressed."""
    require_bokeh()
    import bokeh

    folder = Path(bokeh.__file__).parent / "server" / "static" / "js"
    return compressed((folder / "bokeh.min.js").read_bytes())


@cache
def three() -> str:
    """The script of three.js, compressed."""
    return compressed((_FOLDER.parent / "three" / "three.js").read_bytes())


@cache
def panels(runs: int = 1) -> str:
    """All panels as JSON: the document of Bokeh, and which root is drawn in which element."""
    require_bokeh()
    from bokeh.document import Document
    from bokeh.embed.util import standalone_docs_json_and_render_items
    from bokeh.models import DataRange1d, Range1d

    span = Range1d(start=0.0, end=1.0, name="span")
    figures = [
        _panel(number, span, DataRange1d(only_visible=True), MAX_LINES * runs)
        for number in range(PANELS)
    ]
    document = Document()
    for figure in figures:
        document.add_root(figure)
    documents, (item,) = standalone_docs_json_and_render_items(figures)
    roots = {model.ref["id"]: f"curves-{number}" for number, model in enumerate(figures)}
    text = json.dumps({"documents": documents, "item": {**item.to_json(), "roots": roots}})
    # Names that count up with every model of a process, and a random one: in their order instead.
    known: dict[str, str] = {}
    return _IDENTITIES.sub(lambda m: f'"p{known.setdefault(m[1], str(len(known) + 1))}"', text)


def _panel(number: int, span: Any, values: Any, lines: int) -> Any:
    from bokeh.models import BasicTicker, BasicTickFormatter, ColumnDataSource
    from bokeh.plotting import figure

    panel = figure(
        name=f"panel-{number}", height=_HEIGHT, sizing_mode="stretch_both", x_range=span,
        y_range=values, min_height=_LEAST, tools="xpan,xwheel_zoom,xbox_zoom,reset,save",
        active_drag=None, active_scroll=None, output_backend="canvas", min_border_left=76,
        min_border_right=14, min_border_bottom=22, background_fill_color=None,
        border_fill_color=None, outline_line_color=None,
    )  # fmt: skip
    panel.yaxis.formatter = BasicTickFormatter(power_limit_high=7, power_limit_low=-4)
    panel.yaxis.ticker = BasicTicker(desired_num_ticks=4)
    panel.toolbar.logo = None
    panel.toolbar.autohide = True
    for _ in range(lines):
        panel.line(
            "t", "y", source=ColumnDataSource({"t": [0.0, 1.0], "y": [0.0, 1.0]}), line_width=1.6
        )
    return panel


def curves(result: "Result") -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """The series of a result that are finite somewhere, and their groups, as the page has them.

    A group is a panel's worth of curves: those of a body, joint or effect that share a unit, and
    those of one kind of all bodies.
    """
    series: list[dict[str, Any]] = []
    groups: dict[tuple[str, str], dict[str, Any]] = {}
    for row in _rows(result):
        values = result.column(row)
        finite = values[np.isfinite(values)]
        if not len(finite):
            continue
        section, kind, owner, unit = _place_of(result, row)
        name = f"power({row.name})" if row.kind == "power" else row.name
        size, change = float(np.abs(finite).max()), float(np.ptp(finite))
        shared = [("All bodies", "", kind)] if section == "Bodies" else []
        own = section, owner, f"{owner}: {kind}" if owner else kind
        for where, whose, word in (*shared, own):
            title = f"{word}, {unit}" if unit else word
            group = groups.setdefault(
                (where, title),
                {"section": where, "title": title, "owner": whose, "unit": unit, "curves": []},
            )
            group["curves"].append((len(series), size, change))
        known = {"name": name, "owner": row.element, "unit": unit}
        series.append({**known, "values": rounded(values)})
    return series, [part for group in groups.values() for part in _parts(group)]


def _rows(result: "Result") -> Iterator[Series]:
    """The series that a page offers, in the order of a report.

    Bodies in space have ω' in place of the rates of their Euler parameters.
    """
    table, turning = result.description.series, result.description.turning
    parameters = {k for _, first in turning for k in range(first, first + 4)}
    motion = table.of_kind("coordinate", "velocity", "acceleration")
    for row in sorted(motion, key=lambda row: row.column):
        if row.kind == "coordinate" or row.column not in parameters:
            yield row
    yield from table.of_kind("spin")
    for kinds in ("state",), ("reaction", "effect", "point", "expression"), ("power",), ("energy",):
        yield from table.of_kind(*kinds)


def _place_of(result: "Result", row: Series) -> tuple[str, str, str, str]:
    """Section, kind, owner and unit of a series in the list of a panel."""
    section, kind = _SECTIONS[row.kind]
    owner = "" if section in ("States", "Energy") else row.element
    if row.element in result.description.drivers and row.kind == "reaction":
        section, kind = "Drivers", "exerts"
    elif row.kind == "effect":
        kind = row.quantity or kind
    elif section == "Bodies" and row.unit.partition("/")[0] == "rad":
        kind = _ANGULAR[kind]
    return section, kind, owner, "" if row.unit == "1" else row.unit


def _parts(group: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A group without the curves that stay constant, unless all do, in panels."""
    every = group.pop("curves")
    least = _ROUNDING * max(size for _, size, _ in every)
    chosen = [number for number, _, change in every if change > least]
    constant = not chosen
    chosen = chosen or [number for number, *_ in every]
    pieces = range(0, len(chosen), MAX_LINES)
    for first in pieces:
        number = f" ({first // MAX_LINES + 1})" if len(pieces) > 1 else ""
        part = chosen[first : first + MAX_LINES]
        yield {**group, "title": group["title"] + number, "series": part, "constant": constant}
