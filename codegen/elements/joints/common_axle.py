"""How bearings hold two points relative to each other, where the declaration tells it."""

from collections.abc import Mapping

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint
from codegen.elements.joints.revolute import Revolute


def fixed_distance(
    i: Point, j: Point, joints: Mapping[str, Constraint]
) -> tuple[Body, sympy.Expr, sympy.Expr] | None:
    """The body that keeps two points apart, and the way from `i` to `j` in its frame, m.

    A body does so if each of the points is its own, or sits on it by revolute joints at just this
    place, over other bodies on the same axle too. None where no body is seen to.
    """
    for first in _axle(i, joints):
        for second in _axle(j, joints):
            if first.body is second.body:
                return first.body, second.sx - first.sx, second.sy - first.sy
    return None


def _axle(point: Point, joints: Mapping[str, Constraint]) -> list[Point]:
    """The point, and those of other bodies that revolute joints keep at the same place."""
    pins = [pin for pin in joints.values() if isinstance(pin, Revolute)]
    points = [point]
    for place in points:
        for pin in pins:
            for here, there in ((pin.i, pin.j), (pin.j, pin.i)):
                same = here.body is place.body and (here.sx, here.sy) == (place.sx, place.sy)
                if same and not any(other.body is there.body for other in points):
                    points.append(there)
    return points
