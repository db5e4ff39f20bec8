"""Poses of the driven linkages of Haug's chapter 12 in closed form, and their torques by energy.

Every body is a place and a rotation matrix that follow from the time alone. The torque that drives
the machine is d(T + V)/dt over its speed, by differences in forty digits.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
from mpmath import mp, mpf

DIGITS = 40
STEP = mpf("1e-7")
Pose = tuple[Any, Any]  # r (3, 1) and A (3, 3)


def vector(*parts: Any) -> Any:
    return mpmath.matrix([mpf(x) for x in parts])


def cross(a: Any, b: Any) -> Any:
    return mpmath.matrix(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def dot(a: Any, b: Any) -> Any:
    return mpmath.fsum(x * y for x, y in zip(a, b, strict=True))


def unit(a: Any) -> Any:
    return a / mpmath.sqrt(dot(a, a))


def columns(x: Any, y: Any, z: Any) -> Any:
    return mpmath.matrix([[x[k], y[k], z[k]] for k in range(3)])


def about_x(angle: Any) -> Any:
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    return mpmath.matrix([[1, 0, 0], [0, c, -s], [0, s, c]])


@dataclass(frozen=True)
class Body:
    """Mass, principal moments, and the pose at a time."""

    mass: float
    moments: Sequence[float]
    pose: Callable[[Any], Pose]


def rate(f: Callable[[Any], Any], t: Any) -> Any:
    """f′ to the fourth order of a step of 1e-7."""
    h = STEP
    return (8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h)


def energy(bodies: Sequence[Body], t: Any) -> Any:
    """T + V under gravity along -z, J."""
    total = mpf(0)
    for body in bodies:
        v = rate(lambda s, b=body: b.pose(s)[0], t)
        r, A = body.pose(t)
        W = A.T * rate(lambda s, b=body: b.pose(s)[1], t)
        spin = (W[2, 1], W[0, 2], W[1, 0])
        turning = mpmath.fsum(mpf(J) * w**2 for J, w in zip(body.moments, spin, strict=True))
        total += mpf(body.mass) * (dot(v, v) / 2 + mpf("9.81") * r[2]) + turning / 2
    return total


def torque(bodies: Sequence[Body], speed: float, t: float) -> float:
    """What drives the machine at a constant speed, N m."""
    with mp.workdps(DIGITS):
        return float(rate(lambda s: energy(bodies, s), mpf(t)) / mpf(speed))


def slider_crank(length: float, speed: float, moments: Sequence[float]) -> list[Body]:
    """Section 12.2, model 1, with a driven crank; the pin is above A at t = 0.

    The cross at C has axes x and y′ of the rod.
    """

    def ends(t: Any) -> tuple[Any, Any]:
        angle = mpmath.pi / 2 + mpf(speed) * t
        y = mpf("0.1") + mpf("0.08") * mpmath.cos(angle)
        z = mpf("0.12") + mpf("0.08") * mpmath.sin(angle)
        return vector(0, y, z), vector(mpmath.sqrt(mpf(length) ** 2 - y * y - z * z), 0, 0)

    def rod(t: Any) -> Pose:
        B, C = ends(t)
        along = unit(C - B)
        across = unit(cross(along, vector(1, 0, 0)))
        return (B + C) / 2, columns(along, across, cross(along, across))

    def crank(t: Any) -> Pose:
        return vector(0, "0.1", "0.12"), about_x(mpmath.pi / 2 + mpf(speed) * t)

    still = mpmath.eye(3)
    return [
        Body(0.12, (1e-4, 1e-5, 1e-4), crank),
        Body(0.5, moments, rod),
        Body(2.0, (1e-4,) * 3, lambda t: (ends(t)[1], still)),
    ]


def four_bar(speed: float, with_link: bool) -> list[Body]:
    """Section 12.3 with a driven wheel; B is above A at t = 0, and the rocker points upward."""
    at = vector(-4, "-8.5", 0)

    def pin(t: Any) -> Any:
        return about_x(mpf(speed) * t) * vector(0, 0, 2)

    def tip(t: Any) -> Any:
        """|B - D - 7.4 (sin a, 0, cos a)| = 12.2, of the two angles that which is nearer to 0."""
        arm, R = pin(t) - at, mpf("7.4")
        middle = mpmath.atan2(arm[0], arm[2])
        wanted = (dot(arm, arm) + R**2 - mpf("12.2") ** 2) / (2 * R)
        half = mpmath.acos(wanted / mpmath.sqrt(arm[0] ** 2 + arm[2] ** 2))
        a = min((middle - half, middle + half), key=abs)
        return at + R * vector(mpmath.sin(a), 0, mpmath.cos(a))

    def link(t: Any) -> Pose:
        B, C = pin(t), tip(t)
        along = unit(C - B)
        third = unit(cross(about_x(mpf(speed) * t) * vector("0.75", "-0.662", 0), along))
        return (B + C) / 2, columns(cross(along, third), along, third)

    def rocker(t: Any) -> Pose:
        along = unit(tip(t) - at)
        hinge = vector(0, 1, 0)
        return at + along * mpf("3.7"), columns(hinge, along, cross(hinge, along))

    bodies = [
        Body(2.0, (4.0, 2.0, 2.0), lambda t: (vector(0, 0, 0), about_x(mpf(speed) * t))),
        Body(1.0, (4.54, 0.01, 4.54), rocker),
    ]
    return [*bodies, Body(1.0, (12.4, 0.01, 12.4), link)] if with_link else bodies
