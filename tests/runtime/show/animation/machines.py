"""Small machines whose motion is known, as pages."""

from pathlib import Path
from typing import Any

import numpy as np

from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.picture import BodyPicture, Picture, Symbol
from codegen.drawing.shapes import Force, Pin, Place, Shape, Spring
from runtime.show.animation.page_data import block, in_two, machine_data
from runtime.show.animation.page_text import page_text


def crank_pictures(
    t: np.ndarray, angle: np.ndarray, arm: float = 1.0, shapes: tuple[Shape, ...] = ()
) -> Picture:
    """A crank that turns about the origin, with further shapes."""
    poses = np.zeros((len(t), 2, 3))
    poses[:, 1, 0], poses[:, 1, 1] = arm / 2 * np.cos(angle), arm / 2 * np.sin(angle)
    poses[:, 1, 2] = angle
    pin = Pin(Place(0, 0.0, 0.0), Place(1, -arm / 2, 0.0))
    symbols = [Symbol("A", "revolute", "joint", pin)]
    symbols += [Symbol(f"E{k}", "own", "force", shape) for k, shape in enumerate(shapes, 1)]
    bodies = (BodyPicture("ground", True), BodyPicture("crank"))
    return complete_picture(Picture("crank", bodies, poses, tuple(symbols), 1.0, poses, t))


def page_of(path: Path, *drawn: Picture, labels: tuple[str, ...] = ("",), **more: Any) -> Path:
    """A page without curves; `more` are further entries of each run."""
    runs = [
        {
            "label": label, "title": one.title, "t": in_two(one.t),
            "series": [], "groups": [], **machine_data(one), **more,
        }
        for one, label in zip(drawn, labels, strict=True)
    ]  # fmt: skip
    path.write_text(page_text("crank", block({"runs": runs}), has_curves=False))
    return path


def spring_on_a_shaker(t: np.ndarray) -> Picture:
    """A crank at rest, and a spring whose end on the ground goes to and fro."""
    spring = Spring(Place(0, 2.0 + 0.5 * np.sin(t), 0.0), Place(1, 0.5, 0.0))
    return crank_pictures(t, np.zeros(len(t)), shapes=(spring,))


def pushed_crank(t: np.ndarray, fx: np.ndarray) -> Picture:
    """A crank at rest with a force along x."""
    return crank_pictures(t, np.zeros(len(t)), shapes=(Force(Place(1, 0.5, 0.0), fx, 0.0),))
