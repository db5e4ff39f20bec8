"""Machines in motion as SVG files, which the gallery and the first page show.

The run of a machine's page gives two files in `gallery/pages/moving`: NAME.svg moves, and
NAME-still.svg is its first instant. ``{moving} NAME …`` on a page shows machines as cards, which
move while they are pointed at, and ``{moving-now} NAME`` shows one that moves at once. None moves
where the reader has asked for less motion.
"""

import ast
from collections.abc import Iterable, Sequence
from html import escape
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from codegen.drawing.matplotlib_painter import PictureArtist
from codegen.drawing.picture import Picture
from codegen.drawing.plane_geometry import pairs
from codegen.drawing.styles import STYLES, Stroke, color_of
from linkwright import Result
from runtime.show.pictures import moving_picture

if TYPE_CHECKING:
    from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parent.parent
MOVING = DOCS / "gallery" / "pages" / "moving"

WIDTH, HEIGHT = 360.0, 270.0  # of the files, in pixels
REACH = 0.7  # typical lengths of the machine that the view has beside its first instant
FRAMES = 121  # instants, both ends included
# First and last instant that are shown, s, and how long that takes, s; else the whole run in 6 s.
SPANS: dict[str, tuple[float, float, float]] = {
    "coil_spring": (0.0, 10.0, 5.0),
    "engine": (0.0, 0.206, 6.0),
    "four_bar": (0.0, 1.0, 3.0),
    "film_follower": (0.0, 1.0, 3.0),
    "quarter_car": (0.0, 1.0, 3.0),
    "quick_return": (0.548, 1.636, 5.0),
    "robot_arm": (0.0, 2.0, 4.0),
    "scotch_yoke": (0.952, 1.508, 3.0),
    "slider_crank": (0.264, 0.788, 4.0),
    "trebuchet": (0.0, 1.235, 4.0),
    "valve_lifter": (0.0, 0.02, 2.0),
    "web_cutter": (0.0, 1.0, 3.0),
}


def _d(picture: Picture, stroke: Stroke, scale: float) -> str:
    """A stroke in the frame of its body as the outline of a path, in pixels, y downwards."""
    points = pairs(scale * np.conj(stroke.points))
    line = "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
    return f"M{line}{'Z' if stroke.closed else ''}"


def _path(stroke: Stroke, d: str, inside: str = "") -> str:
    """A path in the colours of its style."""
    style = STYLES[stroke.style]
    fill, line = (color_of(name, stroke.body) or "none" for name in (style.fill, style.line))
    dashes = " ".join(f"{style.width * x:.2f}" for x in style.dashes[1] or ())
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    words = f'fill="{fill}" stroke="{line}" stroke-width="{style.width}"{dashed}'
    return f'<path d="{d}" {words}>{inside}</path>' if inside else f'<path d="{d}" {words}/>'


def _animation(of: str, values: Iterable[str], seconds: float, more: str = "") -> str:
    tag = "animateTransform" if of == "transform" else "animate"
    text = ";".join(values)
    return (
        f'<{tag} attributeName="{of}"{more} dur="{seconds:g}s" repeatCount="indefinite" '
        f'values="{text}"/>'
    )


def _view(frames: Sequence[Picture], artist: PictureArtist) -> tuple[Any, Any]:
    """Least and greatest x and y, m, of all instants, and no more than `REACH` beside the first."""
    lows, highs = zip(*(artist.bounds(frame) for frame in frames[::4]), strict=True)
    reach = REACH * frames[0].size
    return (
        np.maximum(np.min(lows, axis=0), lows[0] - reach),
        np.minimum(np.max(highs, axis=0), highs[0] + reach),
    )


def drawings(result: Result, first: float, last: float, seconds: float) -> tuple[str, str]:
    """A run as an SVG that moves, and its first instant as one that does not."""
    picture = moving_picture(result.at(np.linspace(first, last, FRAMES)))
    frames = [picture.instant(k) for k in range(FRAMES)]
    artist = PictureArtist(frames[0], gaps=False)
    low, high = _view(frames, artist)
    scale = float(np.min((WIDTH, HEIGHT) / (high - low)))
    left, top = (low + high) / 2 * (1, -1) * scale - (WIDTH / 2, HEIGHT / 2)
    columns = list(zip(*(artist.strokes(frame) for frame in frames), strict=True))
    moves: list[str] = []
    rests: list[str] = []

    def is_rigid(column: tuple[Stroke, ...]) -> bool:
        own = column[0].points
        return all(
            one.points.shape == own.shape and np.allclose(one.points, own, atol=1e-3 / scale)
            for one in column
        )

    for (body, rigid), group in groupby(columns, lambda c: (c[0].body, is_rigid(c))):
        paths, still = "", ""
        for column in group:
            outlines = [_d(picture, one, scale) for one in column]
            still += _path(column[0], outlines[0])
            paths += _path(
                column[0], outlines[0], "" if rigid else _animation("d", outlines, seconds)
            )
        poses = picture.poses[:, body]
        places = [f"{scale * x:.2f} {-scale * y:.2f}" for x, y, _ in poses]
        turns = [f"{-np.degrees(phi):.2f}" for phi in poses[:, 2]]
        rests.append(f'<g transform="translate({places[0]}) rotate({turns[0]})">{still}</g>')
        if len({*zip(places, turns, strict=True)}) == 1:
            moves.append(rests[-1].replace(still, paths))
            continue
        moves.append(
            "<g>"
            + _animation("transform", places, seconds, ' type="translate"')
            + _animation("transform", turns, seconds, ' type="rotate" additive="sum"')
            + paths
            + "</g>"
        )
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH:g}" height="{HEIGHT:g}" '
        f'viewBox="{left:.1f} {top:.1f} {WIDTH:g} {HEIGHT:g}" stroke-linecap="round" '
        'stroke-linejoin="round">'
    )
    moving, still = (f"{head}{''.join(parts)}</svg>\n" for parts in (moves, rests))
    return moving, still


def save(name: str, result: Result) -> None:
    """Write the two files of a machine."""
    MOVING.mkdir(parents=True, exist_ok=True)
    span = SPANS.get(name, (float(result.t[0]), float(result.t[-1]), 6.0))
    for ending, text in zip(("", "-still"), drawings(result, *span), strict=True):
        (MOVING / f"{name}{ending}.svg").write_text(text, encoding="utf-8")


class Machines(SphinxDirective):
    """Cards of machines with links to their pages, or with `moving-now` their motion alone."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """The cards as HTML."""
        up = "../" * self.env.docname.count("/")
        card = self.moving if self.name == "moving-now" else self.card
        cards = "".join(card(up, name) for name in self.arguments[0].split())
        return [nodes.raw("", f'<div class="machines {self.name}">{cards}</div>', format="html")]

    def card(self, up: str, name: str) -> str:
        """A machine that moves while it is pointed at, its title and what it is."""
        title, about = described(name)
        file = f"{up}_static/{name}"
        return (
            f'<a href="{up}gallery/pages/plot_{name}.html">'
            f'<img class="still" src="{file}-still.svg" alt="">'
            f'<img class="moves" loading="lazy" src="{file}.svg" alt="">'
            f"<b>{escape(title)}</b><span>{escape(about)}</span></a>"
        )

    def moving(self, up: str, name: str) -> str:
        """A machine that moves at once, unless the reader has asked for less motion."""
        title, _ = described(name)
        file = f"{up}_static/{name}"
        return (
            f'<a href="{up}gallery/pages/plot_{name}.html" title="{escape(title)}"><picture>'
            f'<source media="(prefers-reduced-motion: reduce)" srcset="{file}-still.svg">'
            f'<img src="{file}.svg" alt="{escape(title)} in motion"></picture></a>'
        )


def described(name: str) -> tuple[str, str]:
    """The title of a machine's page, and its first sentence."""
    script = DOCS / "gallery" / "machines" / f"plot_{name}.py"
    title, _, text = (ast.get_docstring(ast.parse(script.read_text("utf-8"))) or "").split("\n", 2)
    return title, " ".join(text.split()).partition(". ")[0].rstrip(".") + "."


def setup(app: "Sphinx") -> dict[str, bool]:
    """Add the directives."""
    app.add_directive("moving", Machines)
    app.add_directive("moving-now", Machines)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
