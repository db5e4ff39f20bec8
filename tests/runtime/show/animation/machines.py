"""Small machines whose motion is known, as pages."""

from pathlib import Path
from typing import Any

import numpy as np

from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.picture import BodyPicture, MovingPicture, Picture, Symbol
from codegen.drawing.shapes import Force, Pin, Place, Shape, Spring
from runtime.show.animation.compressed_arrays import block, in_two
from runtime.show.animation.page_data import machine_data
from runtime.show.animation.page_text import page_text


def crank_pictures(
    t: np.ndarray, angle: np.ndarray, arm: float = 1.0, shapes: tuple[Shape, ...] = (),
    moving: dict[tuple[int, str], np.ndarray] | None = None,
) -> MovingPicture:  # fmt: skip
    """A crank that turns about the origin; further shapes have the numbers 1, 2 …"""
    poses = np.zeros((len(t), 2, 3))
    poses[:, 1, 0], poses[:, 1, 1] = arm / 2 * np.cos(angle), arm / 2 * np.sin(angle)
    poses[:, 1, 2] = angle
    pin = Pin(Place(0, 0.0, 0.0), Place(1, -arm / 2, 0.0))
    symbols = [Symbol("A", "revolute", "joint", pin)]
    symbols += [Symbol(f"E{k}", "own", "force", shape) for k, shape in enumerate(shapes, 1)]
    bodies = (BodyPicture("ground", True), BodyPicture("crank"))
    picture = complete_picture(Picture("crank", bodies, poses[0], tuple(symbols), 1.0), poses)
    return MovingPicture(t, picture, poses, moving or {}, {}, poses)


def page_of(
    path: Path, *drawn: MovingPicture, labels: tuple[str, ...] = ("",), **more: Any
) -> Path:
    """A page without curves; `more` are further entries of each run."""
    runs = [
        {
            "label": label, "title": one.picture.title, "t": in_two(one.t),
            "series": [], "groups": [], **machine_data(one), **more,
        }
        for one, label in zip(drawn, labels, strict=True)
    ]  # fmt: skip
    path.write_text(page_text("crank", block({"runs": runs}), has_curves=False))
    return path


def spring_on_a_shaker(t: np.ndarray) -> MovingPicture:
    """A crank at rest, and a spring whose end on the ground goes to and fro."""
    spring = Spring(Place(0, 2.0, 0.0), Place(1, 0.5, 0.0))
    moving = {(1, "i.x"): 2.0 + 0.5 * np.sin(t)}
    return crank_pictures(t, np.zeros(len(t)), shapes=(spring,), moving=moving)


def pushed_crank(t: np.ndarray, fx: np.ndarray) -> MovingPicture:
    """A crank at rest with a force along x."""
    force = Force(Place(1, 0.5, 0.0), float(fx[0]), 0.0)
    return crank_pictures(t, np.zeros(len(t)), shapes=(force,), moving={(1, "fx"): fx})
