"""Machines in motion as SVG files, which the gallery and the first page show.

The run of a machine's page gives two files in `gallery/pages/moving`: NAME.svg moves, and
NAME-still.svg is its first instant. ``{moving} NAME …`` on a page shows machines as cards, which
move while they are pointed at, and ``{moving-now} NAME …`` shows pictures that move at once. None
moves where the reader has asked for less motion.
"""

import ast
import re
from collections.abc import Iterable
from html import escape
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from codegen.drawing.matplotlib_painter import PictureArtist, SpaceArtist
from codegen.drawing.picture import Picture, SpacePicture
from codegen.drawing.plane_geometry import Points, pairs
from codegen.drawing.styles import STYLES, Stroke, color_of
from linkwright import Result
from runtime.show.pictures import moving_picture

if TYPE_CHECKING:
    from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parent.parent
MOVING = DOCS / "gallery" / "pages" / "moving"
SIZE = np.array([360.0, 270.0])  # width and height of the files, in pixels
REACH = 0.7  # typical lengths of the machine that the view has beside its first instant
FRAMES = 121  # instants, both ends included
FRAMES_IN_SPACE = 31  # each has all its lines, since these change their order
ROUND = 24  # points of a closed line in space, of which more are thinned
# First and last instant that are shown, s, and how long that takes, s; else the whole run in 6 s.
SPANS = {
    "coil_spring": (0.0, 10.0, 5.0), "engine": (0.0, 0.206, 6.0), "four_bar": (0.0, 1.0, 3.0),
    "film_follower": (0.0, 1.0, 3.0), "quarter_car": (0.0, 1.0, 3.0),
    "quick_return": (0.548, 1.636, 5.0), "robot_arm": (0.0, 2.0, 4.0),
    "scotch_yoke": (0.952, 1.508, 3.0), "slider_crank": (0.264, 0.788, 4.0),
    "trebuchet": (0.0, 1.235, 4.0), "valve_lifter": (0.0, 0.02, 2.0), "web_cutter": (0.0, 1.0, 3.0),
}  # fmt: skip


def drawing(result: Result, first: float, last: float, seconds: float) -> str:
    """A run as an SVG that moves; without its animations it shows the first instant."""
    picture = moving_picture(result.at(np.linspace(first, last, FRAMES)))
    step = (FRAMES - 1) // (FRAMES_IN_SPACE - 1) if isinstance(picture, SpacePicture) else 1
    frames = [picture.instant(k) for k in range(0, FRAMES, step)]
    artist: PictureArtist = (SpaceArtist if step > 1 else PictureArtist)(frames[0], gaps=False)
    bounds, reach = np.array([artist.bounds(one) for one in frames[::4]]), REACH * picture.size
    low = np.maximum(bounds[:, 0].min(axis=0), bounds[0, 0] - reach)
    high = np.minimum(bounds[:, 1].max(axis=0), bounds[0, 1] + reach)
    scale = float(np.min(SIZE / (high - low)))
    draw = parts_in_space if step > 1 else parts_in_plane
    parts = draw(artist, frames, scale, seconds)
    left, top = (low + high) / 2 * (1, -1) * scale - SIZE / 2
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIZE[0]:g}" height="{SIZE[1]:g}" '
        f'viewBox="{left:.1f} {top:.1f} {SIZE[0]:g} {SIZE[1]:g}" stroke-linecap="round" '
        f'stroke-linejoin="round">{"".join(parts)}</svg>\n'
    )


def outline(points: Points, scale: float, closed: bool) -> str:
    """The data of a path."""
    places = (f"{x:.1f} {y:.1f}" for x, y in pairs(scale * np.conj(points)))
    return f"M{'L'.join(places)}{'Z' if closed else ''}"


def path(own: Stroke, data: str, inside: str = "", filled: str = "") -> str:
    """A stroke as a path with an outline, filled as its style says or otherwise."""
    style = STYLES[own.style]
    names = filled or style.fill, style.line
    fill, line = (color_of(name, own.body) or "none" for name in names)
    dashes = " ".join(f"{style.width * x:.2f}" for x in style.dashes[1] or ())
    return (
        f'<path d="{data}" fill="{fill}" stroke="{line}" stroke-width="{style.width}"'
        f"{f' stroke-dasharray={dashes!r}' if dashes else ''}>{inside}</path>"
    )


def parts_in_space(
    artist: PictureArtist, frames: list[Picture], scale: float, seconds: float
) -> list[str]:
    """A group for each instant, of which one is visible at a time."""
    parts = []
    for k, frame in enumerate(frames):
        until = (k + 1) / len(frames)
        shown = ("none;inline;none", f"0;{k / len(frames):.4f};{until:.4f}")
        values, times = shown if k else ("inline;none", f"0;{until:.4f}")
        lines = []
        for one in artist.strokes(frame):
            if one.style != "inside":  # the edge has it
                thin = 1 + len(one.points) // ROUND if one.closed else 1
                data = outline(one.points[::thin], scale, one.closed)
                lines.append(path(one, data, filled="fill" if one.style == "edge" else ""))
        parts.append(
            f'<g display="{"none" if k else "inline"}"><animate attributeName="display" '
            f'dur="{seconds:g}s" repeatCount="indefinite" calcMode="discrete" values="{values}" '
            f'keyTimes="{times}"/>{"".join(lines)}</g>'
        )
    return parts


def parts_in_plane(
    artist: PictureArtist, frames: list[Picture], scale: float, seconds: float
) -> list[str]:
    """A group for each body, which moves with its lines."""

    def animation(of: str, values: Iterable[str], more: str = "") -> str:
        rest = f'attributeName="{of}" dur="{seconds:g}s" repeatCount="indefinite"'
        tag = "animateTransform" if more else "animate"
        return f'<{tag} {rest}{more} values="{";".join(values)}"/>'

    def moving(column: tuple[Stroke, ...]) -> str:
        own = column[0]
        moves = any(not np.array_equal(one.points, own.points) for one in column)
        shown = column if moves else column[:1]
        outlines = [outline(one.points, scale, one.closed) for one in shown]
        return path(own, outlines[0], animation("d", outlines) if len({*outlines}) > 1 else "")

    parts = []
    poses = np.array([frame.poses for frame in frames])
    columns = zip(*(artist.strokes(frame) for frame in frames), strict=True)
    for body, group in groupby(columns, key=lambda column: column[0].body):
        x, y, phi = poses[:, body].T
        places = [f"{scale * a:.2f} {-scale * b:.2f}" for a, b in zip(x, y, strict=True)]
        turns = [f"{angle:.2f}" for angle in -np.degrees(phi)]
        parts.append(f'<g transform="translate({places[0]}) rotate({turns[0]})">')
        if len({*zip(places, turns, strict=True)}) > 1:
            parts.append(animation("transform", places, ' type="translate"'))
            parts.append(animation("transform", turns, ' type="rotate" additive="sum"'))
        parts += [*map(moving, group), "</g>"]
    return parts


def save(name: str, result: Result) -> None:
    """Write the two files of a machine."""
    MOVING.mkdir(parents=True, exist_ok=True)
    drawn = drawing(result, *SPANS.get(name, (float(result.t[0]), float(result.t[-1]), 6.0)))
    (MOVING / f"{name}.svg").write_text(drawn, encoding="utf-8")
    still = re.sub('<g display="none">.*?</g>|<animate[^>]*>', "", drawn)
    (MOVING / f"{name}-still.svg").write_text(still, encoding="utf-8")


class Machines(SphinxDirective):
    """Cards of machines with links to their pages."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """The cards as HTML."""
        up = "../" * self.env.docname.count("/")
        cards = "".join(card(up, name) for name in self.arguments[0].split())
        return [nodes.raw("", f'<div class="machines {self.name}">{cards}</div>', format="html")]


def card(up: str, name: str) -> str:
    """The two pictures of a machine, the title of its page and the first sentence there."""
    script = DOCS / "gallery" / "machines" / f"plot_{name}.py"
    title, _, text = (ast.get_docstring(ast.parse(script.read_text("utf-8"))) or "").split("\n", 2)
    about = " ".join(text.split()).partition(". ")[0].rstrip(".")
    return (
        f'<a href="{up}gallery/pages/plot_{name}.html">'
        f'<img class="still" src="{up}_static/{name}-still.svg" alt="">'
        f'<img class="moves" loading="lazy" src="{up}_static/{name}.svg" alt="">'
        f"<b>{escape(title)}</b><span>{escape(about)}.</span></a>"
    )


def setup(app: "Sphinx") -> dict[str, bool]:
    """Add the directives."""
    app.add_directive("moving", Machines)
    app.add_directive("moving-now", Machines)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
