"""The picture of an element on its page: its example between the bodies i and j, as it is drawn.

It stands below the sentence with which the page opens. Kinds without a shape have none.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.declare.element import Constraint
from codegen.derive.constraint_terms import constraint_terms
from codegen.drawing.annotations import (
    acting_loads,
    arrow,
    drawn_loads,
    driver_strokes,
    frame_strokes,
)
from codegen.drawing.labels import Label, Writer
from codegen.drawing.matplotlib_painter import PictureArtist
from codegen.drawing.picture import ARROW, HEAD, PIN
from codegen.drawing.plane_geometry import origin, straight_arrow, unit
from codegen.drawing.shapes import Gravity
from codegen.drawing.styles import LIGHT, Stroke, color_of
from codegen.picture_at_start import declared_picture
from codegen.presentation import new_figure, save_figure
from codegen.reference.pages import Example, Pair, example_of, find_kind

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PICTURES = Path(__file__).resolve().parent.parent / "elements" / "pictures"
LARGEST = (5.4, 3.3)  # width and height of a picture, in inches
MAGNIFIED = 7.0  # inches that a typical length has at most
# Where bodies stand, and from where the joint of a kind is closed, if elsewhere.
GUESS = {"i.phi": 0.3, "j.x": 1.1, "j.y": 0.25, "j.phi": -0.2}
GUESSES = {
    **{kind: {"j.x": 2.7} for kind in ("distance", "distance driver", "revolute-revolute")},
    "screw": {"j.x": 1.419, "j.y": -0.189, "j.phi": 0.3, "spindle.x": 0.58, "spindle.y": -0.03,
              "spindle.phi": 63.13},
}  # fmt: skip
# Joints that hold the bodies of others together: at these points, or along this axis.
PINNED = dict.fromkeys(("motor", "one-way clutch", "torque", "torsion spring"), "j")
PINNED["relative driver"] = "Q"
GUIDED = {"dry friction": (1, 0), "translation driver": (2, 1)}
# Contacts with the ground, which has a surface.
LAID = {"contact": {"stiffness": 1e4}, "rigid contact": {"restitution": 0.5}}


def shown_example(kind: str) -> Example:
    """The example of a kind, with all that its picture needs."""
    example = example_of(kind)
    model: Any = Pair("example") if kind in LAID else example.model
    if kind in LAID:
        way = {"free_length": 0, "direction": (0, 1)}
        floor = model.contact("floor", model.ground.at(0, 0), model.Q, **way, **LAID[kind])
        example = Example(model, floor, source="Q")
    if kind in PINNED:
        model.revolute("pin", model.P, getattr(model, PINNED[kind]))
    if kind in GUIDED:
        model.translational("guide", model.P, model.Q, axis=GUIDED[kind])
    used = {body.name for body in example.element.bodies}
    is_whole = not used or kind in PINNED | GUIDED or not hasattr(example.element, "shapes")
    absent = set() if is_whole else {"i", "j"} - used
    start = {name: value for name, value in (GUESS | GUESSES.get(kind, {})).items()
             if name[0] not in absent}  # fmt: skip
    acting = {"effects": [*model.effects.values()], "drivers": [*model.drivers.values()]}
    model.scene("shown", **acting, without=absent, guess=start)
    return example


def figure(kind: str) -> Any:
    """The picture of a kind; None where nothing of it has a shape."""
    example = shown_example(kind)
    model, element, ink = example.model, example.element, LIGHT["ink"]
    picture = declared_picture(model, "shown")
    if not picture.symbols:
        return None
    size, labels = picture.size, []
    signs = [*frame_strokes(picture), *driver_strokes(picture)]

    def write(text: str, at: Any, color: str, room: float = 0.0, **style: Any) -> None:
        labels.append(Label(text, np.ravel(at), room * size, {"color": color, **style}))

    reactions: list[str] = []
    if isinstance(element, Constraint):
        terms = constraint_terms(element)[1].reactions
        reactions = [name for name, _, value in terms if value != 0]
    for name in reactions:
        acting = acting_loads(picture, {f"{element.name}.{name}": 1.0})
        for load, strokes in drawn_loads(picture, acting, False):
            signs += strokes
            write(name, strokes[0].points[[-1, 0]], LIGHT[load.style], fontsize=10)
    loads = drawn_loads(picture, acting_loads(picture, {}), False)
    signs += [one for _, strokes in loads for one in strokes]
    for number, body in enumerate(picture.bodies[1:], 1):
        at, color = origin(picture.poses[number]), color_of("line", number)
        write(body.name, at, color, 0.045, fontsize=13, fontstyle="italic")
        for way, axis in ((1.0, "x′"), (1j, "y′")):
            tip = at + 0.08 * size * picture.turned(way, number)
            write(axis, tip, LIGHT["muted"], fontsize=8.5)
        letter = {"i": "P", "j": "Q"}.get(body.name, "")
        if letter and re.search(rf"\b{letter}\b", example.source):
            point = getattr(model, letter)
            away = complex(*(model.parameters[one.name].value for one in (point.sx, point.sy)))
            signs.insert(0, Stroke("dimension", number, np.array([0j, away])))
            write(letter, picture.placed(away, number), ink, PIN, fontsize=12, fontstyle="italic")
        for _, gravity in picture.having(Gravity):
            end = at + ARROW * size * unit(gravity.gx + 1j * gravity.gy)
            signs += arrow("force", straight_arrow(at, end, HEAD * size))
    artist = PictureArtist(picture)
    artist.signs = signs
    low, high = artist.bounds(picture)
    scale = min(*(LARGEST / (high - low)), MAGNIFIED / size)
    drawn = new_figure("picture", *(scale * (high - low)))
    axes = drawn.add_subplot()
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()
    artist.add_to(axes, picture)
    drawn.draw_without_rendering()
    writer = Writer(axes, artist.global_lines(picture))
    for label in labels:
        writer.add(label)
    return drawn


def show(_: "Sphinx", page: str, source: list[str]) -> None:
    """Draw the picture of an element, and put it below the first sentence of its page."""
    folder, _, name = page.rpartition("/")
    is_kind = folder == "elements" and name not in ("index", "in-space")
    drawn = figure(find_kind(name)) if is_kind else None
    if drawn is not None:
        PICTURES.mkdir(exist_ok=True)
        save_figure(drawn, PICTURES / f"{name}.svg")
        title, sentence, rest = source[0].split("\n\n", 2)
        text = f"{name.replace('-', ' ')}: its symbol between the bodies i and j"
        picture = f"```{{image}} pictures/{name}.svg\n:alt: {text}\n:class: element\n```"
        source[0] = "\n\n".join((title, sentence, picture, rest))


def setup(app: "Sphinx") -> dict[str, bool]:
    """Change the pages of elements as they are read."""
    app.connect("source-read", show)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
