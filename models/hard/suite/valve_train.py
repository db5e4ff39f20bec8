"""The valve train with a free follower, by its one coordinate: the lift s of the pushrod.

(m3 + m5 + J4 θ'²) s̈ + J4 θ' θ'' ṡ² + k (ℓ0 - ℓ + s) = f, tan θ = s / arm, and f = -K g - C ġ ≥ 0
while the gap g = s - e (1 - cos ωt) is negative. The integrator is SciPy's.
"""

import numpy as np
from scipy.integrate import solve_ivp

from models.hard.suite.case import Array

ARM, PUSHROD, VALVE, ROCKER = 0.06, 0.12, 0.06, 1.8e-4
SPRING, PRESSED = 2500.0, 0.03
ECCENTRICITY, SPEED = 0.0025, 100.0 * np.pi


def lift(times: Array, stiffness: float, damping: float) -> Array:
    """s at the instants from rest at s = 0, for a contact that is closed throughout, m."""

    def gap(t: float, s: float, rate: float) -> tuple[float, float]:
        turned = SPEED * t
        return (
            s - ECCENTRICITY * (1.0 - np.cos(turned)),
            rate - ECCENTRICITY * SPEED * np.sin(turned),
        )

    def field(t: float, y: Array) -> list[float]:
        s, rate = y
        g, closing = gap(t, s, rate)
        turn = ARM / (ARM**2 + s**2)
        bend = -2.0 * s * ARM / (ARM**2 + s**2) ** 2
        mass = PUSHROD + VALVE + ROCKER * turn**2
        force = -stiffness * g - damping * closing - SPRING * (PRESSED + s)
        return [rate, (force - ROCKER * turn * bend * rate**2) / mass]

    run = solve_ivp(
        field, (0.0, times[-1]), [0.0, 0.0], "Radau", t_eval=times, rtol=1e-12, atol=1e-17
    )
    opened = [gap(t, *y)[0] for t, y in zip(run.t[1:], run.y.T[1:], strict=True)]
    if not (run.success and max(opened) < 0.0):
        raise ValueError("the contact opens; this equation is for one that does not")
    return np.asarray(run.y[0])
