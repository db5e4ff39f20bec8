"""A chain of uniform bars, the pendulum of as many links as one likes.

      o--------o--------o--------o ...
     ///

Bars of 1 m and 1 kg, hinged to one another and to the ground, let go level and at rest. Two
seconds later the chain hangs and its end is swinging up: the motion is smooth, and not yet chaotic
enough to cost digits.
"""

from typing import Any

from codegen import Model

DURATION = 2.0
SCENE = "let_go"


def chain(links: int) -> Model:
    """The declaration; angles are `link_0.phi` and so on."""
    model = Model(f"chain_{links}", gravity=(0, -9.81))
    end = model.ground.at(0, 0)
    start: dict[Any, float] = {}
    guess: dict[Any, float] = {}
    for k in range(links):
        link = model.body(f"link_{k}", mass=1.0, inertia=1 / 12)
        model.revolute(f"hinge_{k}", end, link.at(-0.5, 0))
        end = link.at(0.5, 0)
        start |= {link.phi: 0.0, link.omega: 0.0}
        guess |= {link.x: k + 0.5, link.y: 0.0}
    model.scene(SCENE, ["gravity"], start=start, guess=guess)
    return model
