"""Two shafts that meet at an angle, with a universal joint between them.

                              .o  second shaft
                           .`
      o-------------[+]-`      β
      first shaft, along x

While the first shaft turns evenly, the second turns at ω₁ cos β / (1 - sin² β cos² θ), up to
1 / cos β times as fast. Each shaft lies in a hinge, so that three of the rows follow from others:
they are left out, and the reactions that share a load are those of least norm.

`universal_joint(bend)` declares the machine with any angle, rad; the file's own has 0.5 rad.

Scenes
------
driven
    The first shaft turns at 2 rad/s.
free
    Both turn freely, from 2 rad/s of the first.
"""

from math import cos, sin

from codegen import Model, disc, extruded, polygon, t


def universal_joint(bend: float) -> Model:
    """The shafts with a bend between them, rad."""
    model = Model(f"universal_joint_{round(100 * bend)}", space=True)
    along = (cos(bend), sin(bend), 0.0)
    # Each shaft ends in a fork, whose prongs hold an axis of the cross.
    fork = polygon([(0.35, -0.1), (0.54, -0.1), (0.54, -0.07), (0.4, -0.07), (0.4, 0.07),
                    (0.54, 0.07), (0.54, 0.1), (0.35, 0.1)])  # fmt: skip
    across = ((0, 1, 0), (0, 0, 1))
    drawn = [
        [extruded(fork, 0.06, axes=((side, 0, 0), up)),
         extruded(disc(0.03), 0.98, (-0.11 * side, 0, 0), across)]
        for side, up in ((1, (0, 1, 0)), (-1, (0, 0, 1)))
    ]  # fmt: skip
    first = model.body("first", 1.0, (0.1, 0.2, 0.3), at=(-0.5, 0, 0), draw=drawn[0])
    second = model.body("second", 2.0, (0.3, 0.2, 0.1), at=(0.5 * along[0], 0.5 * along[1], 0),
                        axes=(0, 0, bend), draw=drawn[1])  # fmt: skip
    hinge = model.revolute("A", model.ground, first, at=(-1, 0, 0), axis=(1, 0, 0))
    model.universal("cross", first, second, at=(0, 0, 0), axes=((0, 1, 0), (0, 0, 1)))
    model.revolute("B", model.ground, second, at=along, axis=along)
    model.rotation_driver("drive", hinge, 2 * t)
    model.scene("driven", drivers=["drive"])
    model.scene("free", start={hinge.angle: 0.0, hinge.rate: 2.0})
    return model


model = universal_joint(0.5)
