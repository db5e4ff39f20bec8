"""A heavy top on a fixed point, whose axis lies level at the start.

              z
              |
              |      axis y', 150 rad/s
              |   [==========]----.
          tip o---[==========]--------- y
                  [==========]
              1 m to the centre of mass

The top of the literature on rotations: 15 kg, moments of 0.46875 kg m² about its axis and 0.234375
across. At -4.61538 rad/s about z it nutates a little; at m g l / (J ω) = 2.0928 rad/s it precesses
steadily.

Scenes
------
spin
    Free on its tip, with 150 rad/s about its axis.
"""

from codegen import Model


def heavy_top() -> Model:
    """The top."""
    model = Model("heavy_top", space=True, gravity=(0, 0, -9.81))
    body = model.body("top", 15.0, (0.234375, 0.46875, 0.234375), at=(0, 1, 0))
    model.spherical("tip", model.ground, body, at=(0, 0, 0))
    start = {body.e0: 1.0, body.e1: 0.0, body.e2: 0.0, body.e3: 0.0}
    spin = {"top.omega_x": 0.0, "top.omega_y": 150.0, "top.omega_z": -4.61538}
    model.scene("spin", effects=["gravity"], start=start | spin)
    return model


model = heavy_top()
