"""The lines of which a picture consists: those fixed in bodies, and those drawn anew at each pose.

A figure and a player draw the same strokes; only the moving ones need a construction at every
instant, and `spring_lines` and `wheel_lines` state it.
"""

from dataclasses import dataclass

from codegen.drawing.polygons import FloatArray

FILLED = ("support", "bracket-support", "slot", "pin", "gear", "ring", "hub", "fixing", "hole")
"""Styles of closed strokes with an inside; a ring has no line round it."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """A polyline, or a polygon.

    Attributes
    ----------
    style
        What it stands for: "support", "hatch", "rail" (and "bracket-support" and the like, which
        are before the bodies), "slot", "pin", "hub", "disc", "spoke",
        "gear" (racks as well), "ring", "pitch", "rack", "profile", "belt", "rod", "spring",
        "damper", "actuator", "fixing", "hole", "mark", "gap"; and those of `signs`.
    body
        The body in whose frame its points are: 0, the ground, has the global frame.
    points
        Shape (k, 2), m.
    closed
        Whether the last point is joined to the first.
    element
        The element that it belongs to.
    """

    style: str
    body: int
    points: FloatArray
    closed: bool = False
    element: str = ""
