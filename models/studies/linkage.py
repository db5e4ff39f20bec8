"""The four-bar linkage A B C D in closed form: what the studies hold their runs against.

Points of the plane are complex numbers. With u = e^{iφ} along each bar,

    A + a u₂ + b u₃ = C = D + c u₄,

C is where the circle of radius b about B meets that of radius c about D (Freudenstein's equation,
solved by a square root); its first and second derivative in the crank's angle are linear in the
rates of φ3 and φ4. A machine of one degree of freedom follows from them: the inertia that the crank
feels, and the slope of the potential energy.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


class Rider(NamedTuple):
    """A body's mass (kg), inertia (kg m²), and its centre in the frame of bar 0, 1 or 2."""

    bar: int
    centre: complex
    mass: float
    inertia: float


class Track(NamedTuple):
    """A point, or an angle, and its first and second derivative in the crank's angle, each (k,)."""

    at: npt.NDArray[np.complexfloating | np.floating]
    first: npt.NDArray[np.complexfloating | np.floating]
    second: npt.NDArray[np.complexfloating | np.floating]


@dataclass(frozen=True)
class FourBar:
    """A linkage and its bodies.

    Attributes
    ----------
    A, D
        Pivots on the ground, m.
    a, b, c
        Lengths AB, BC, CD, m.
    side
        +1 where C lies to the left of the line from B to D, else -1.
    riders
        The bodies.
    g
        Gravity along -y, m/s².
    """

    A: complex
    D: complex
    a: float
    b: float
    c: float
    side: int
    riders: tuple[Rider, ...] = ()
    g: float = 0.0

    def angle(self, bar: int, phi: npt.ArrayLike) -> Track:
        """Angle of bar 0 (from A to B), 1 (B to C) or 2 (D to C) with the crank at `phi`, rad."""
        phi = np.asarray(phi, dtype=np.float64)
        if bar == 0:
            return Track(phi, np.ones_like(phi), np.zeros_like(phi))
        crank = np.exp(1j * phi)
        span = self.D - self.A - self.a * crank
        square = np.abs(span) ** 2
        along = (self.b**2 - self.c**2 + square) / (2 * square)
        across = self.side * np.sqrt(self.b**2 / square - along**2)
        u3 = span * (along + 1j * across) / self.b
        u4 = (self.b * u3 - span) / self.c
        # b ω3 i u3 - c ω4 i u4 = -a i u2: a product with the conjugate of u4 or u3 rids of one.
        turn = (u3 * np.conj(u4)).imag
        w3 = -self.a * (crank * np.conj(u4)).imag / (self.b * turn)
        w4 = -self.a * (crank * np.conj(u3)).imag / (self.c * turn)
        rest = self.a * crank + self.b * w3**2 * u3 - self.c * w4**2 * u4
        u, w = (u3, w3) if bar == 1 else (u4, w4)
        other = u4 if bar == 1 else u3
        second = -(rest * np.conj(other)).real / ((self.b if bar == 1 else self.c) * turn)
        return Track(np.unwrap(np.atleast_1d(np.angle(u))).reshape(phi.shape), w, second)

    def point(self, bar: int, place: complex, phi: npt.ArrayLike) -> Track:
        """The point `place` of the frame of a bar: origin at A, B or D, x' along the bar."""
        angle = self.angle(bar, phi)
        arm = place * np.exp(1j * angle.at)
        at, first = arm, 1j * angle.first * arm
        second = (1j * angle.second - angle.first**2) * arm
        if bar == 1:
            base = self.point(0, self.a, phi)
            return Track(base.at + at, base.first + first, base.second + second)
        return Track((self.A if bar == 0 else self.D) + at, first, second)

    def inertia(self, phi: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Inertia that the crank feels, 2 E_kin / ω² in kg m², and its derivative in φ."""
        total, slope = 0.0, 0.0
        for rider in self.riders:
            r, turn = self.point(rider.bar, rider.centre, phi), self.angle(rider.bar, phi)
            total = total + rider.mass * np.abs(r.first) ** 2 + rider.inertia * turn.first**2
            slope = slope + 2 * rider.mass * (r.first * np.conj(r.second)).real
            slope = slope + 2 * rider.inertia * turn.first * turn.second
        return total, slope

    def potential(self, phi: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Potential energy of the weights, J, and its derivative in φ, N m."""
        tracks = [(r.mass * self.g, self.point(r.bar, r.centre, phi)) for r in self.riders]
        heights = sum(weight * track.at.imag for weight, track in tracks)
        slopes = sum(weight * track.first.imag for weight, track in tracks)
        return heights, slopes

    def torque(self, phi: npt.ArrayLike, speed: float) -> FloatArray:
        """Torque that turns the crank at constant speed: dE/dt over ω, N m."""
        return 0.5 * self.inertia(phi)[1] * speed**2 + self.potential(phi)[1]

    def speed(self, phi: npt.ArrayLike, torque: float, start: float) -> FloatArray:
        """ω at φ under a constant torque, from φ = 0 and ω = `start`: the balance of energy."""
        before = 0.5 * self.inertia(0.0)[0] * start**2 + self.potential(0.0)[0]
        kinetic = before + torque * np.asarray(phi) - self.potential(phi)[0]
        # At rest a start that is zero to rounding may lie on either side of it.
        return np.sqrt(2 * np.maximum(kinetic, 0.0) / self.inertia(phi)[0])

    def time(self, phi: float, torque: float, start: float) -> float:
        """When the crank is at φ > 0 under a constant torque, s: ∫ dφ/ω by Gauss's rule.

        dφ = 2 s ds lets it start at rest.
        """
        edges = np.sqrt(np.linspace(0.0, phi, 2 + int(16 * phi / np.pi)))
        nodes, weights = np.polynomial.legendre.leggauss(24)
        half = 0.5 * np.diff(edges)[:, None]
        s = edges[:-1, None] + half * (nodes + 1)
        slowness = 2 * s / self.speed((s * s).ravel(), torque, start).reshape(s.shape)
        return float((half * weights * slowness).sum())

    def locks(self) -> float:
        """Where the crank stops, rad from the line AD: B is b + c from D, or |b - c|; nan: nowhere.

        By the law of cosines in the triangle A B D.
        """
        ground = abs(self.D - self.A)
        for reach in (self.b + self.c, abs(self.b - self.c)):
            cosine = (self.a**2 + ground**2 - reach**2) / (2 * self.a * ground)
            if abs(cosine) < 1:
                return float(np.arccos(cosine))
        return float("nan")
