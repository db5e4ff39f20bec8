"""What users do without a compiler: SymPy, lambdify and SciPy's solve_ivp.

The equation in φ₁ is derived from Lagrange's function. `plain` hands it to lambdify and to DOP853
as it is. `simulate` takes care: lambdified for plain floats with common sub-expressions taken out,
and the integration stops at every switch of the gas force and starts again on the other side, so
that DOP853 sees smooth functions only.
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
PHI, OMEGA, FORCE = sympy.symbols("phi omega force")


@dataclass(frozen=True)
class Run:
    """φ₁ and ω at the instants asked for, and what they took."""

    phi: npt.NDArray[np.float64]
    omega: npt.NDArray[np.float64]
    evaluations: int
    restarts: int


def expressions(inertia: float = 450.0) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
    """ω̇ of PHI, OMEGA and FORCE on the slider, and x₃ and dx₃/dφ of PHI."""
    r, length, g = 2, sympy.Rational(7, 2), 9.81
    s2 = -r * sympy.sin(PHI) / length
    c2 = sympy.sqrt(1 - s2**2)
    rod, x3 = sympy.asin(s2), r * sympy.cos(PHI) + length * c2
    x2, y2 = r * sympy.cos(PHI) + length * c2 / 2, r * sympy.sin(PHI) / 2
    d = [sympy.diff(e, PHI) for e in (x2, y2, rod, x3)]
    mass = inertia + sum(m * e**2 for m, e in zip((35, 35, 35, 25), d, strict=True))
    push = 41450 + 35 * g * d[0] + (25 * g + FORCE) * d[3]
    return (push - sympy.diff(mass, PHI) * OMEGA**2 / 2) / mass, x3, d[3]


@cache
def equations(inertia: float = 450.0) -> tuple[Callable[..., float], Callable[..., Any]]:
    """(ω̇ of φ, ω and the gas force) and (x₃, dx₃/dφ), as functions of plain floats."""
    rate, x3, slope = expressions(inertia)
    alpha = sympy.lambdify((PHI, OMEGA, FORCE), rate, "math", cse=True)
    return alpha, sympy.lambdify((PHI,), (x3, slope), "math", cse=True)


@cache
def plain_equation(inertia: float = 450.0) -> Callable[..., float]:
    """ω̇ of φ and ω with the gas force written out, lambdified as lambdify does by itself."""
    rate, x3, slope = expressions(inertia)
    pi = sympy.pi
    force = sympy.Piecewise(
        (0, slope * OMEGA <= 0),
        (0, x3 < EDGES[0]),
        (62857 - 282857 / (6 - x3), x3 <= EDGES[1]),
        (-110000 * (1 - sympy.sin(2 * pi * (x3 - sympy.Rational(21, 4)))), x3 <= EDGES[2]),
        (0, True),
    )
    return sympy.lambdify((PHI, OMEGA), rate.subs(FORCE, force))


def plain(instants: npt.NDArray[np.float64], rtol: float, atol: float) -> Run:
    """The compressor in one call of solve_ivp, its steps finding the switches by failing."""
    alpha = plain_equation()
    done = solve_ivp(
        lambda _, y: (y[1], alpha(y[0], y[1])),
        (instants[0], instants[-1]),
        START,
        method="DOP853",
        t_eval=instants,
        rtol=rtol,
        atol=atol,
    )
    return Run(done.y[0], done.y[1], done.nfev, 0)


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
