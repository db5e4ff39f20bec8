"""The page of an animation: template, style, script and data in one text."""

import re
from functools import cache
from html import escape
from pathlib import Path

from codegen.drawing.colors import PALETTES, Palette
from codegen.drawing.line_styles import STYLES
from runtime.show.animation.curves import PANELS, library, panels

_FOLDER = Path(__file__).parent / "page"
SCRIPTS = (
    "data", "poses", "signs", "scene", "lines", "labels", "arrows", "traces", "flashes",
    "camera", "stage", "clock", "timeline", "curves", "state_text", "controls", "keys",
    "surroundings", "main",
)  # fmt: skip
"""The modules of the script, each after those that it imports."""
_PIXELS = 1.4  # layout: in a page, of a line that is a point wide in a figure
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";$', re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async )?(?:const|function|class) (\w+))", re.MULTILINE)


@cache
def script() -> str:
    """All modules in one text: each is a function that is called once and returns its exports."""
    parts = ['"use strict";']
    for name in SCRIPTS:
        text = (_FOLDER / f"{name}.js").read_text(encoding="utf-8")
        exports = ", ".join(found[2] for found in _EXPORT.finditer(text))
        body = _EXPORT.sub(r"\1", _IMPORT.sub(r"const \1 = module_\2;", text))
        parts.append(f"const module_{name} = (() => {{\n{body}return {{ {exports} }};\n}})();")
    return "\n".join(parts)


@cache
def style() -> str:
    """The style sheet, colours of both themes first."""
    light, dark = (_colors(PALETTES[theme]) for theme in ("light", "dark"))
    count = len(PALETTES["light"].lines)
    numbered = " ".join(
        f".body-{k} {{ --fill: var(--fill-{k}); --line: var(--line-{k}); }} "
        f".line-{k} {{ --chip: var(--line-{k}); }} .run-{k} {{ color: var(--line-{k}); }}"
        for k in range(count)
    )
    lines = "\n".join(_line_rule(name) for name, one in STYLES.items() if one.layer != "signs")
    sheet = (_FOLDER / "page.css").read_text(encoding="utf-8")
    return (
        f":root, :root[data-theme=light] {{ color-scheme: light; {light} }}\n"
        f"@media (prefers-color-scheme: dark) {{ :root {{ color-scheme: dark; {dark} }} }}\n"
        f":root[data-theme=light] {{ color-scheme: light; {light} }}\n"
        f":root[data-theme=dark] {{ color-scheme: dark; {dark} }}\n{numbered}\n{sheet}\n"
        f"{lines}\n{_line_rule('driver')}\n"
    )


def _line_rule(name: str) -> str:
    """The rule of the style sheet for lines of a style."""
    style = STYLES[name]
    fill, line = (
        f"var(--{own if color == 'body' else color})" if color else "none"
        for color, own in ((style.fill, "fill"), (style.line, "line"))
    )
    width = f"{_PIXELS * style.width:.1f}px"
    return f".world .{name} {{ fill: {fill}; stroke: {line}; stroke-width: {width}; }}"


def _colors(palette: Palette) -> str:
    words = palette._asdict()
    lines, fills = words.pop("lines"), words.pop("fills")
    words |= {f"line-{k}": color for k, color in enumerate(lines)}
    words |= {f"fill-{k}": color for k, color in enumerate(fills)}
    return " ".join(f"--{name}: {color};" for name, color in words.items())


def page_text(
    title: str, data: str, below: str = "", *, has_curves: bool = True, runs: int = 1
) -> str:
    """The page as text.

    Parameters
    ----------
    title
        Of the page.
    data
        The block of `compressed_arrays`.
    below
        HTML that stands below the player.
    has_curves
        Whether there is a motion, of which there are curves.
    runs
        How many runs lie beside each other.
    """
    template = (_FOLDER / "page.html").read_text(encoding="utf-8")
    curves = "\n".join(map(_curve_section, range(PANELS))) if has_curves else ""
    parts = {
        "title": escape(title),
        "style": style(),
        "curves": curves,
        "below": below,
        "data": data,
        "panels": panels(runs).replace("</", "<\\/") if has_curves else "null",
        "library": library() if has_curves else "",
        "script": script(),
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
