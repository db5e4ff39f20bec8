"""Closed forms of spatial linkages: universal joint, slider-crank, swash plate, governor."""

from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
from scipy.optimize import brentq

G = 9.81


def universal_joint_ratio(angle: float, bend: float) -> float:
    """ω₂/ω₁ of two shafts at an angle `bend`.

    `angle` turns the first shaft from where its arm of the cross lies in the plane of both shafts.
    """
    return float(np.cos(bend) / (1.0 - (np.sin(bend) * np.cos(angle)) ** 2))


def universal_joint_angle(angle: float, bend: float) -> float:
    """The angle of the second shaft, 0 with the first and counted through turns with it."""
    whole = np.round(angle / np.pi) * np.pi
    return float(whole + np.arctan2(np.sin(angle - whole), np.cos(bend) * np.cos(angle - whole)))


@dataclass(frozen=True)
class SpatialSliderCrank:
    """Haug 12.2: a crank about x at (0, 0.1, 0.12), a slider on the x axis, a rod between."""

    rod: float
    radius: float = 0.08
    height: tuple[float, float] = (0.1, 0.12)

    def slider(self, angle: Any) -> Any:
        """x of the slider, for the crank's angle about +x, 0 where its pin lies towards +y."""
        y = self.height[0] + self.radius * mpmath.cos(angle)
        z = self.height[1] + self.radius * mpmath.sin(angle)
        return mpmath.sqrt(mpmath.mpf(self.rod) ** 2 - y * y - z * z)

    def motion(self, angle: float, speed: float) -> tuple[float, float, float]:
        """x, ẋ and ẍ of the slider at a constant speed of the crank, rad/s."""
        x, slope, curve = (mpmath.diff(self.slider, angle, k) for k in range(3))
        return float(x), float(slope * speed), float(curve * speed**2)

    def extremes(self, order: int, speed: float) -> tuple[float, float]:
        """Least and largest x, ẋ or ẍ, by the order of the derivative."""
        angles = np.linspace(0.0, 2.0 * np.pi, 721)

        def value(angle: Any) -> Any:
            return mpmath.diff(self.slider, angle, order) if order else self.slider(angle)

        coarse = [float(value(a)) for a in angles]
        found = []
        for k in (int(np.argmin(coarse)), int(np.argmax(coarse))):
            place = mpmath.findroot(
                lambda a: mpmath.diff(self.slider, a, order + 1),
                (angles[k] - 5e-3, angles[k] + 5e-3),
            )
            found.append(float(value(place) * speed**order))
        return found[0], found[1]

    @property
    def lock_up(self) -> float:
        """The shortest rod that lets the crank turn."""
        return float(np.hypot(*self.height)) + self.radius


@dataclass(frozen=True)
class SwashPlate:
    """Haug 12.4: pistons parallel to the shaft, moved by a plate tilted against it.

    The plate does not turn with the shaft: a universal joint holds it, with one axis in the housing
    and one in the plate. The pistons stand on a circle.
    """

    tilt: float
    radius: float = 0.2
    rod: float = 0.5

    @property
    def stroke(self) -> float:
        """Of a piston opposite to an axis of the universal joint, 2 R sin α."""
        return 2.0 * self.radius * float(np.sin(self.tilt))

    def piston(self, angle: Any, place: float) -> Any:
        """Height of a piston above the plate's centre, at `place` on the circle from the axis x.

        `x` is the axis of the universal joint in the housing, and the shaft turns by `angle` from
        where the plate's normal leans towards x.
        """
        tilt = self.tilt
        lean = mpmath.sin(tilt)
        n = lean * mpmath.cos(angle), lean * mpmath.sin(angle), mpmath.cos(tilt)
        across = mpmath.sqrt(n[1] ** 2 + n[2] ** 2)
        y = mpmath.matrix([0, n[2] / across, -n[1] / across])
        x = mpmath.matrix([across, -n[0] * n[1] / across, -n[0] * n[2] / across])  # y × n
        c, s = mpmath.cos(place), mpmath.sin(place)
        point = self.radius * (c * x + s * y)
        aside = (point[0] - self.radius * c) ** 2 + (point[1] - self.radius * s) ** 2
        return point[2] + mpmath.sqrt(mpmath.mpf(self.rod) ** 2 - aside)

    def largest_acceleration(self, speed: float, place: float = np.pi / 2) -> float:
        """The largest |ẍ| of a piston, m/s², at a constant speed of the shaft, rad/s."""
        angles = np.linspace(0.0, 2.0 * np.pi, 181)

        def curve(angle: Any) -> Any:
            return mpmath.diff(lambda a: self.piston(a, place), angle, 2)

        coarse = [abs(float(curve(a))) for a in angles]
        middle = angles[int(np.argmax(coarse))]
        around = np.linspace(middle - 0.02, middle + 0.02, 41)
        return max(abs(float(curve(a))) for a in around) * speed**2


@dataclass(frozen=True)
class FlyballGovernor:
    """Haug 12.6: two balls on arms from a spindle's top, links to a collar, a spring.

    The spindle's centre, at which the arms hang, is `top` above the origin; gravity along -y.
    """

    top: float = 0.2
    arm: float = 0.16
    joint: float = 0.08
    link: float = 0.10922
    stiffness: float = 1000.0
    free_length: float = 0.15
    ball: float = 1.0
    collar: float = 1.0

    def height(self, angle: float) -> float:
        """y of the collar, for the angle of the arms against the downward vertical."""
        aside = self.joint * np.sin(angle)
        return float(self.top - self.joint * np.cos(angle) - np.sqrt(self.link**2 - aside**2))

    def slope(self, angle: float) -> float:
        """dy/dθ of the collar."""
        s, c = np.sin(angle), np.cos(angle)
        root = np.sqrt(self.link**2 - (self.joint * s) ** 2)
        return float(self.joint * s + self.joint**2 * s * c / root)

    def angle(self, height: float) -> float:
        """The angle of the arms where the collar is at a height."""
        return float(brentq(lambda a: self.height(a) - height, 0.05, 1.5, xtol=1e-15))

    def speed(self, height: float) -> float:
        """The speed of the spindle at which the collar stays at a height, by virtual work, rad/s.

        2 m ω² R² sin θ cos θ = 2 m g R sin θ + dy/dθ (M g - k (top - y - l₀)).
        """
        a = self.angle(height)
        s, c = np.sin(a), np.cos(a)
        pull = self.stiffness * (self.top - height - self.free_length)
        held = 2 * self.ball * G * self.arm * s + self.slope(a) * (self.collar * G - pull)
        return float(np.sqrt(held / (2 * self.ball * self.arm**2 * s * c)))

    def steady(self, gain: float, load: float = 25.0) -> tuple[float, float]:
        """Height of the collar, and speed, at which the engine's torque is the load.

        The torque is gain Δl, with Δl = (top - y) - l₀.
        """
        height = self.top - self.free_length - load / gain
        return height, self.speed(height)
