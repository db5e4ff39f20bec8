"""How joints hold the bodies: all at one point of a body, or one joint alone.

Both may be meant. Where a linkage does not close or has a freedom too many, they are often a point
with a wrong sign, or a joint that was forgotten.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from codegen.declare.body import Body, Point
from codegen.model import Model

_SAME = 1e-9  # accuracy: of a point's distance from its body's origin; nearer places are one


def one_joint_bodies(model: Model, left_out: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """The bodies that one joint alone holds, each with the joint; without the joints left out."""
    return tuple(
        (body.name, joints[0])
        for body, joints in _joints_of_bodies(model, left_out)
        if len(joints) == 1
    )


def joints_at_one_point(model: Model) -> tuple[str, ...]:
    """A sentence for each body that several joints hold, all at the same point of it."""
    found = []
    for body, joints in _joints_of_bodies(model, ()):
        places = [place for name in joints for place in _places(model, name, body)]
        size = max((float(np.hypot(*place)) for place in places), default=0.0)
        if len(places) == len(joints) > 1 and float(np.ptp(places, axis=0).max()) <= _SAME * size:
            x, y = places[0]
            found.append(
                f"Joints {' and '.join(joints)} hold body '{body.name}' at one point, "
                f"({x:.4g}, {y:.4g}): is one of the signs wrong?"
            )
    return tuple(found)


def _joints_of_bodies(
    model: Model, left_out: Sequence[str]
) -> Iterator[tuple[Body, tuple[str, ...]]]:
    acting = {name: j for name, j in model.joints.items() if name not in left_out}
    for body in model.bodies.values():
        if not body.fixed:
            yield body, tuple(name for name, j in acting.items() if body in j.bodies)


def _places(model: Model, joint: str, body: Body) -> Iterator[tuple[float, float]]:
    """The points of a body that a joint is attached to, m, where they are numbers."""
    for point in vars(model.joints[joint]).values():
        if isinstance(point, Point) and point.body is body:
            x, y = (value.subs(model.defaults) for value in point.place)
            if x.is_finite and x.is_real and y.is_finite and y.is_real:
                yield float(x), float(y)
