"""Machines in space as plain numbers for the tools: what `models/space` declares, by joints.

All places and axes are those of the drawing, in global axes. The axes of a body are parallel to the
global ones there, unless it says otherwise. Nothing here needs the program that is measured.
"""

import math
from dataclasses import dataclass

Vector = tuple[float, float, float]
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Link:
    """A body on a hinge: its name, the hinge and its axis, mass, centre and principal moments."""

    name: str
    hinge: Vector
    axis: Vector
    mass: float
    centre: Vector
    moments: Vector


@dataclass(frozen=True)
class Chain:
    """Links one after the other from the ground; `closing` is a last hinge, back to the ground."""

    links: tuple[Link, ...]
    gravity: Vector
    closing: tuple[Vector, Vector] | None = None


def bars(corners: tuple[Vector, ...], axes: tuple[Vector, ...]) -> tuple[Link, ...]:
    """Bars of 1 × 0.1 × 0.1 m and 1 kg from corner to corner."""
    made = []
    for k in range(len(corners) - 1):
        a, b = corners[k], corners[k + 1]
        x, y, z = ((p + q) / 2 for p, q in zip(a, b, strict=True))
        m = [0.01 / 6 if p != q else 1.01 / 12 for p, q in zip(a, b, strict=True)]
        made.append(Link(f"b{k + 1}", a, axes[k], 1.0, (x, y, z), (m[0], m[1], m[2])))
    return tuple(made)


BRICARD = Chain(
    bars(((0, 0, 0), X, (1, -1, 0), (1, -1, 1), (0, -1, 1), Z), (Y, Z, X, Y, Z)),
    (0.0, -9.81, 0.0),
    (Z, X),
)
ARM = Chain(
    (
        Link("column", (0, 0, 0), Z, 20.0, (0, 0, 0.3), (0.7, 0.7, 0.2)),
        Link("upper_arm", (0, 0.12, 0.6), Y, 15.0, (0.2, 0.12, 0.6), (0.05, 0.4, 0.4)),
        Link("forearm", (0.45, 0.12, 0.6), Y, 8.0, (0.6, 0.08, 0.6), (0.02, 0.15, 0.15)),
        Link("wrist", (0.7, 0.06, 0.6), X, 2.0, (0.8, 0.06, 0.6), (3e-3, 5e-3, 5e-3)),
        Link("hand", (0.85, 0.06, 0.6), Y, 1.0, (0.88, 0.06, 0.6), (1e-3, 2e-3, 2e-3)),
        Link("tool", (0.92, 0.06, 0.6), X, 2.5, (1.0, 0.06, 0.58), (4e-3, 5e-3, 4e-3)),
    ),
    (0.0, 0.0, -9.81),
)


class SliderCrank:
    """The crank's pivot A, its pin B, and the slider C; the rod BC is alike across its line.

    The slider moves along x; the rod turns on it about x and about `across`. `rates` are those of
    these three joints and of the crank about x, when the crank turns at -6 rad/s.
    """

    gravity = (0.0, 0.0, -9.81)
    A: Vector = (0.0, 0.1, 0.12)
    B: Vector = (0.0, 0.1, 0.2)
    C: Vector = (0.2, 0.0, 0.0)
    middle: Vector = (0.1, 0.05, 0.1)
    along: Vector = (2 / 3, -1 / 3, -2 / 3)
    across: Vector = (0.0, 2 / math.sqrt(5), -1 / math.sqrt(5))
    crank = (0.12, (1e-4, 1e-4, 1e-5))
    rod = (0.5, (4e-4, 4e-3))
    slider = (2.0, (1e-4, 1e-4, 1e-4))
    rates = (-0.24, -1.92, 0.48 * math.sqrt(5), -6.0)

    @classmethod
    def rod_inertia(cls) -> list[list[float]]:
        """In global axes."""
        along, across = cls.rod[1]
        return [
            [across * (i == k) + (along - across) * cls.along[i] * cls.along[k] for k in range(3)]
            for i in range(3)
        ]


class Platform:
    """The plate on six springs, at rest away from its place; the start's attitude is (e0, e)."""

    gravity = (0.0, 0.0, -9.81)
    mass, moments = 40.0, (1.3, 1.1, 2.3)
    stiffness = 2e4
    height = 0.7
    rest = math.sqrt(height**2 + 0.6**2 + 0.35**2 - 2 * 0.6 * 0.35 * math.cos(2 * math.pi / 9))
    place: Vector = (0.05, -0.03, 0.72)
    vector: Vector = (0.06, -0.04, 0.1)
    attitude = (math.sqrt(1 - 0.06**2 - 0.04**2 - 0.1**2), *vector)

    @classmethod
    def legs(cls) -> list[tuple[Vector, Vector]]:
        """Points of the ground, and of the plate in its own axes."""
        found = []
        for k in range(6):
            middle, side = 2 * math.pi / 3 * (k // 2), (-1) ** k
            at, on = middle + side * math.pi / 18, middle + side * 5 * math.pi / 18
            base = (0.6 * math.cos(at), 0.6 * math.sin(at), 0.0)
            found.append((base, (0.35 * math.cos(on), 0.35 * math.sin(on), 0.0)))
        return found
