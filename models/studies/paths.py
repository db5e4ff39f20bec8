"""The path of a point of a body in a run, as complex numbers x + iy."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BPoly, PPoly

from runtime import Result

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


class Path(NamedTuple):
    """Position in m, velocity in m/s and acceleration in m/s² at the instants, each (k,)."""

    at: ComplexArray
    velocity: ComplexArray
    acceleration: ComplexArray


def path(run: Result, body: str, place: complex = 0) -> Path:
    """The point `place` of the body's frame: r + A s' and its derivatives (Haug 2.6)."""
    names = f"{body}.x", f"{body}.y"
    x, y = (Path(run.q(n), run.v(n), run.a(n)) for n in names)
    arm = place * np.exp(1j * run.q(f"{body}.phi"))
    omega, alpha = run.v(f"{body}.phi"), run.a(f"{body}.phi")
    return Path(
        x.at + 1j * y.at + arm,
        x.velocity + 1j * y.velocity + 1j * omega * arm,
        x.acceleration + 1j * y.acceleration + (1j * alpha - omega**2) * arm,
    )


def extreme(instants: FloatArray, path: Path, k: int) -> float:
    """Height of the vertical extreme next to instant k, m: of quintics through y, ẏ and ÿ."""
    near = slice(k - 1, k + 2)
    known = np.column_stack([part[near].imag for part in path])
    height = PPoly.from_bernstein_basis(BPoly.from_derivatives(instants[near], known))
    return float(height(height.derivative().roots(extrapolate=False)[0]))
