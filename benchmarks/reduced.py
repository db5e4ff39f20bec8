"""What a careful user would do without a compiler: SymPy, lambdify and SciPy's solve_ivp.

The equation in φ₁ is derived from Lagrange's function, its pieces are lambdified with common
sub-expressions taken out, and the integration stops at every switch of the gas force and starts
again on the other side, so that DOP853 sees smooth functions only.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy
from scipy.integrate import solve_ivp

START = (math.pi, 30.0)
EDGES = (1.5, 5.0, 5.5)


@dataclass(frozen=True)
class Run:
    """φ₁ and ω at the instants asked for, and what they took."""

    phi: npt.NDArray[np.float64]
    omega: npt.NDArray[np.float64]
    evaluations: int
    restarts: int


@cache
def equations(inertia: float = 450.0) -> tuple[Callable[..., float], Callable[..., Any]]:
    """(ω̇ of φ, ω and the gas force) and (x₃, dx₃/dφ), as plain Python functions."""
    phi, omega, force = sympy.symbols("phi omega force")
    r, length, g = 2, sympy.Rational(7, 2), 9.81
    s2 = -r * sympy.sin(phi) / length
    c2 = sympy.sqrt(1 - s2**2)
    rod, x3 = sympy.asin(s2), r * sympy.cos(phi) + length * c2
    x2, y2 = r * sympy.cos(phi) + length * c2 / 2, r * sympy.sin(phi) / 2
    d = [sympy.diff(e, phi) for e in (x2, y2, rod, x3)]
    mass = inertia + sum(m * e**2 for m, e in zip((35, 35, 35, 25), d, strict=True))
    push = 41450 + 35 * g * d[0] + (25 * g + force) * d[3]
    rate = (push - sympy.diff(mass, phi) * omega**2 / 2) / mass
    alpha = sympy.lambdify((phi, omega, force), rate, "math", cse=True)
    return alpha, sympy.lambdify((phi,), (x3, d[3]), "math", cse=True)


def gas(piece: int, x: float) -> float:
    """The gas force in the piece between two edges, while the slider moves outwards."""
    if piece == 1:
        return -282857 / (6 - x) + 62857
    return -110000 * (1 - math.sin(2 * math.pi * (x - 5.25))) if piece == 2 else 0.0


def simulate(instants: npt.NDArray[np.float64], rtol: float, atol: float) -> Run:
    """The compressor from its start, by SciPy's DOP853."""
    alpha, slider = equations()
    t, y = float(instants[0]), np.array(START)
    rows, evaluations, restarts = [y], 0, -1
    outwards, piece = _branch(y, alpha, slider)
    while t < instants[-1]:

        def right(_: float, y: Any, outwards: bool = outwards, piece: int = piece) -> list[float]:
            force = gas(piece, slider(y[0])[0]) if outwards else 0.0
            return [y[1], alpha(y[0], y[1], force)]

        ahead = instants[instants > t]
        done = solve_ivp(
            right,
            (t, instants[-1]),
            y,
            method="DOP853",
            t_eval=ahead,
            events=_events(slider, outwards, piece),
            rtol=rtol,
            atol=atol,
        )
        rows += list(done.y.T)
        evaluations += done.nfev
        restarts += 1
        hits = [
            (times[0], y_hit[0])
            for times, y_hit in zip(done.t_events, done.y_events, strict=True)
            if times.size
        ]
        if not hits:
            break
        t, y = min(hits, key=lambda hit: hit[0])
        outwards, piece = _branch(y, alpha, slider)
    states = np.array(rows)
    return Run(states[:, 0], states[:, 1], evaluations, restarts)


def _branch(y: Any, alpha: Any, slider: Any) -> tuple[bool, int]:
    """Which way the slider goes and which piece of the gas it is in, just after `y`."""
    step = 1e-7
    phi = y[0] + step * y[1]
    x, slope = slider(phi)
    return slope * y[1] > 0, sum(x > edge for edge in EDGES)


def _events(slider: Any, outwards: bool, piece: int) -> list[Any]:
    """Terminal events at the ends of the piece, each in the direction that leads out of it."""

    def turn(_: float, y: Any) -> float:
        return slider(y[0])[1] * y[1]

    turn.terminal, turn.direction = True, -1.0 if outwards else 1.0  # type: ignore[attr-defined]
    found = [turn]
    for k, edge in enumerate(EDGES):
        if outwards and k >= piece:

            def crossing(_: float, y: Any, edge: float = edge) -> float:
                return slider(y[0])[0] - edge

            crossing.terminal, crossing.direction = True, 1.0  # type: ignore[attr-defined]
            found.append(crossing)
    return found
