"""The panels of curves: figures of Bokeh, whose script the page carries, filled by the page."""

import json
import re
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from runtime.show.animation.payload import compressed

PANELS = 4  # layout: panels of curves in a page
MAX_LINES = 6  # layout: curves of a run in a panel
_HEIGHT = 140  # layout: of a panel, px
_IDENTITIES = re.compile(r'"(p\d+|[0-9a-f]{8}-[0-9a-f-]{27})"')


def require_bokeh() -> None:
    """Refuse to go on without Bokeh, which is looked for and not loaded.

    Raises
    ------
    InputError
        If it is not installed.
    """
    absent = "bokeh" in sys.modules and sys.modules["bokeh"] is None
    if absent or find_spec("bokeh") is None:
        raise InputError(
            "An animation needs bokeh, which is not installed. Run pip install "
            "'linkwright[animation]', in the checkout pip install '.[animation]'."
        )


def _bokeh() -> Any:
    require_bokeh()
    import bokeh

    return bokeh


@cache
def library() -> str:
    """The script of Bokeh's core, compressed."""
    folder = Path(_bokeh().__file__).parent / "server" / "static" / "js"
    return compressed((folder / "bokeh.min.js").read_bytes())


@cache
def panels(runs: int = 1) -> str:
    """All panels as JSON: the document of Bokeh, and which root is drawn in which element."""
    _bokeh()
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
        name=f"panel-{number}", height=_HEIGHT, sizing_mode="stretch_width", x_range=span,
        y_range=values, tools="xpan,xwheel_zoom,xbox_zoom,reset,save", active_drag=None,
        active_scroll=None, output_backend="canvas", min_border_left=76,
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
