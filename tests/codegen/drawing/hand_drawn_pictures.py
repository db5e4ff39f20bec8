"""Pictures written by hand: a slider-crank, and others with one shape each."""

from collections.abc import Sequence

import numpy as np

from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.picture import BodyPicture, Picture, Symbol
from codegen.drawing.shapes import Drive, Force, Gravity, Pin, Place, Shape, Slide


def picture(
    bodies: Sequence[str],
    poses: Sequence[tuple[float, float, float]],
    symbols: Sequence[tuple[str, str, Shape]],
) -> Picture:
    """Name, role and shape of each symbol; the ground comes first by itself."""
    pictures = (BodyPicture("ground", fixed=True), *(BodyPicture(name) for name in bodies))
    drawn = tuple(Symbol(name, shape.kind, role, shape) for name, role, shape in symbols)
    first = Picture("test", pictures, np.array([(0.0, 0.0, 0.0), *poses]), drawn, 1.0)
    return complete_picture(first)


def slider_crank(angle: float = 0.8, closed: bool = True) -> Picture:
    """Crank of 2 m, rod of 3.5 m, a slider along x."""
    pin = 2 * np.array([np.cos(angle), np.sin(angle)])
    slide = pin[0] + np.sqrt(3.5**2 - pin[1] ** 2)
    rod = (pin + np.array([slide, 0.0])) / 2 + (0.0 if closed else 0.4)
    tilt = np.arctan2(-pin[1], slide - pin[0])
    return picture(
        ["crank", "rod", "slider"],
        [(0.0, 0.0, angle), (rod[0], rod[1], tilt), (slide, 0.0, 0.0)],
        [
            ("A", "joint", Pin(Place(0, 0.0, 0.0), Place(1, 0.0, 0.0))),
            ("B", "joint", Pin(Place(1, 2.0, 0.0), Place(2, -1.75, 0.0))),
            ("C", "joint", Pin(Place(2, 1.75, 0.0), Place(3, 0.0, 0.0))),
            ("guide", "joint", Slide(Place(0, 0.0, 0.0), Place(3, 0.0, 0.0), 1.0, 0.0)),
            ("drive", "driver", Drive(None, Place(1, 0.0, 0.0), True)),
            ("gas", "force", Force(Place(3, 0.0, 0.0), -5e4, 0.0)),
            ("gravity", "force", Gravity(0.0, -9.81)),
        ],
    )
