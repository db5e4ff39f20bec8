"""The picture of an element on its page: its example between the bodies i and j, as it is drawn.

The build draws them into `elements/pictures`, one SVG a kind, and puts each below the sentence with
which a page opens. Kinds without a shape of their own have none.
"""

import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.declare.element import Constraint
from codegen.derive.constraint_terms import constraint_terms
from codegen.drawing import shapes
from codegen.drawing.annotations import arrow, drawn_loads, driver_strokes, frame_strokes
from codegen.drawing.labels import Label, Writer
from codegen.drawing.matplotlib_painter import PictureArtist
from codegen.drawing.picture import ARROW, HEAD, PIN, Picture
from codegen.drawing.plane_geometry import origin, round_arrow, straight_arrow, unit
from codegen.drawing.styles import LIGHT, Stroke, color_of
from codegen.picture_at_start import declared_picture
from codegen.presentation import new_figure, save_figure
from codegen.reference.pages import Example, Pair, chosen_kinds, example_of, slug

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PICTURES = Path(__file__).resolve().parent.parent / "elements" / "pictures"
WIDTH, TALLEST = 5.4, 3.3  # of a picture, in inches
LEAST = 0.45  # width and height of a picture, in typical lengths
GUESS = {"i.phi": 0.3, "j.x": 1.1, "j.y": 0.25, "j.phi": -0.2}
# Where bodies stand from which the joint of a kind is closed, if elsewhere.
GUESSES: dict[str, dict[str, float]] = {
    "distance": {"j.x": 2.7},
    "distance driver": {"j.x": 2.7},
    "revolute-revolute": {"j.x": 2.7},
    "screw": {
        "j.x": 1.419, "j.y": -0.189, "j.phi": 0.3,
        "spindle.x": 0.58, "spindle.y": -0.03, "spindle.phi": 63.13,
    },
}  # fmt: skip
# Another example where that of the page has no surface.
EXAMPLES = {
    "contact": """
        model.contact("floor", model.ground.at(0, 0), Q, stiffness=1e4, free_length=0,
                      direction=(0, 1))
    """,
    "rigid contact": """
        model.contact("floor", model.ground.at(0, 0), Q, restitution=0.5, free_length=0,
                      direction=(0, 1))
    """,
}
# A joint beside an element, so that its bodies hold together.
BESIDE: dict[str, Callable[[Any], Any]] = {
    "dry friction": lambda m: m.translational("guide", m.P, m.Q, axis=(1, 0)),
    "motor": lambda m: m.revolute("pin", m.P, m.j),
    "one-way clutch": lambda m: m.revolute("pin", m.P, m.j),
    "relative driver": lambda m: m.revolute("pin", m.P, m.Q),
    "torque": lambda m: m.revolute("pin", m.P, m.j),
    "torsion spring": lambda m: m.revolute("pin", m.P, m.j),
    "translation driver": lambda m: m.translational("guide", m.P, m.Q, axis=(2, 1)),
}


def example(kind: str) -> Example:
    """What the picture of a kind shows."""
    if kind not in EXAMPLES:
        return example_of(kind)
    pair, source = Pair("example"), cleandoc(EXAMPLES[kind])
    exec(source, {"model": pair, "Q": pair.Q})
    return Example(pair, *pair.effects.values(), source=source)


def figure(example: Example) -> Any:
    """The picture of an example; None where nothing of it has a shape."""
    model, element = example.model, example.element
    if element.kind in BESIDE:
        BESIDE[element.kind](model)
    acting = {"effects": model.effects, "drivers": model.drivers}
    named = {word: [element] for word, some in acting.items() if element.name in some}
    model.scene("shown", **named, guess=GUESS | GUESSES.get(element.kind, {}))
    picture = declared_picture(model, "shown")
    if not picture.symbols:
        return None
    used = {body.name for body in element.bodies} or {"i", "j"}
    used |= {"i", "j"} if element.kind in BESIDE else set()
    bodies = tuple(replace(body, outlines=body.outlines if body.name in used else ())
                   for body in picture.bodies)  # fmt: skip
    picture = replace(picture, bodies=bodies)
    artist = PictureArtist(picture)
    strokes, texts = reaction_arrows(picture, element)
    lettered, letters = named_parts(example, picture, used)
    artist.signs = [
        *lettered, *driver_strokes(picture), *strokes, *weights(picture),
        *(stroke for _, strokes in drawn_loads(picture) for stroke in strokes),
    ]  # fmt: skip
    low, high = artist.bounds(picture)
    more = np.maximum(LEAST * picture.size - (high - low), 0.0) / 2
    low, high = low - more, high + more
    size = (high - low) * np.min((WIDTH, TALLEST) / (high - low))
    drawn = new_figure("picture", *map(float, size))
    axes = drawn.add_subplot()
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()
    artist.add_to(axes, picture)
    drawn.draw_without_rendering()
    writer = Writer(axes, artist.global_lines(picture))
    for label in (*texts, *letters):
        writer.add(label)
    return drawn


def weights(picture: Picture) -> Iterator[Stroke]:
    """The arrows of gravity, one at the centre of each body."""
    for _, gravity in picture.having(shapes.Gravity):
        way = ARROW * picture.size * unit(gravity.gx + 1j * gravity.gy)
        for at in origin(picture.poses[1:]):
            yield from arrow("force", straight_arrow(at, at + way, HEAD * picture.size))


def reaction_arrows(picture: Picture, element: Any) -> tuple[list[Stroke], list[Label]]:
    """Arrows of the components of a joint's reaction that are not 0, and their names."""
    strokes: list[Stroke] = []
    texts: list[Label] = []
    if isinstance(element, Constraint):
        _, terms = constraint_terms(element)
        present = {name for name, _, value in terms.reactions if value != 0}
        size, style = picture.size, {"color": LIGHT["reaction"], "fontsize": 10}
        for _, axes in picture.having(shapes.Reaction):
            at, along = axes.x + 1j * axes.y, axes.ux + 1j * axes.uy
            for name, way in (("fx", along), ("fy", 1j * along)):
                if name in present:
                    tip = at + 1.4 * ARROW * size * way
                    strokes += arrow("reaction", straight_arrow(at, tip, HEAD * size))
                    texts.append(Label(name, np.array([tip]), 0.0, style))
            if "torque" in present:
                lines = round_arrow(at, 0.09 * size, *np.radians((120, 200)), HEAD * size)
                strokes += arrow("torque", lines)
                texts.append(
                    Label("torque", lines[0][::8], 0.0, {**style, "color": LIGHT["torque"]})
                )
    return strokes, texts


def named_parts(
    example: Example, picture: Picture, used: set[str]
) -> tuple[list[Stroke], list[Label]]:
    """The axes of the bodies, lines to their points, and the letters of all these."""
    model, size = example.model, picture.size
    points = {"i": ("P", model.P), "j": ("Q", model.Q)}
    numbers = {k: body.name for k, body in enumerate(picture.bodies) if body.name in used and k}
    strokes = [one for one in frame_strokes(picture) if one.body in numbers]
    labels: list[Label] = []

    def write(text: str, at: complex, room: float = 0.0, **style: Any) -> None:
        labels.append(Label(text, np.array([at]), room * size, style))

    for number, name in numbers.items():
        at = complex(origin(picture.poses[number]))
        letter, point = points.get(name, ("", None))
        if point and re.search(rf"\b{letter}\b", example.source):
            place = [model.parameters[one.name].value for one in (point.sx, point.sy)]
            away = complex(*place)
            strokes.insert(0, Stroke("dimension", number, np.array([0j, away])))
            write(letter, complex(picture.placed(away, number)), PIN, fontsize=12,
                  color=LIGHT["ink"], fontstyle="italic")  # fmt: skip
        write(name, at, 0.045, fontsize=13, color=color_of("line", number), fontstyle="italic")
        for way, axis in ((1.0, "x′"), (1j, "y′")):
            tip = at + 0.08 * size * complex(picture.turned(way, number))
            write(axis, tip, fontsize=8.5, color=LIGHT["muted"])
    return strokes, labels


def draw(app: "Sphinx") -> None:
    """Draw the pictures, where they are not yet those of this state of the program."""
    stamp = PICTURES / ".source"
    if stamp.exists() and stamp.read_text(encoding="utf-8") == app.config.source_digest:
        return
    shutil.rmtree(PICTURES, ignore_errors=True)
    PICTURES.mkdir()
    for kind in chosen_kinds():
        drawn = figure(example(kind))
        if drawn is not None:
            save_figure(drawn, PICTURES / f"{slug(kind)}.svg")
    stamp.write_text(app.config.source_digest, encoding="utf-8")


def show(_: "Sphinx", page: str, source: list[str]) -> None:
    """Put the picture of an element below the first sentence of its page."""
    folder, _, name = page.rpartition("/")
    if folder == "elements" and (PICTURES / f"{name}.svg").exists():
        title, sentence, rest = source[0].split("\n\n", 2)
        text = f"{name.replace('-', ' ')}: its symbol between the bodies i and j"
        picture = f"```{{image}} pictures/{name}.svg\n:alt: {text}\n:class: element\n```"
        source[0] = "\n\n".join((title, sentence, picture, rest))


def setup(app: "Sphinx") -> dict[str, bool]:
    """Draw before pages are read, and change them as they are."""
    app.connect("builder-inited", draw)
    app.connect("source-read", show)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
