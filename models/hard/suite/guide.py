"""The slider-crank with a guide that rubs, by its one angle: no kernels, no multipliers.

The forces of the pins, the guide and the friction are five unknowns that are linear in the
equations of Newton and Euler, with the accelerations written out in φ, φ̇ and φ̈. A state of the
friction, sliding either way or sticking, is integrated by scipy until its own end.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

R, L, G = 0.3, 0.9, 9.81
CRANK_INERTIA = 0.05
ROD, ROD_INERTIA = 1.5, 1.5 * 0.9**2 / 12
SLIDER = 2.0
MU = 0.3


@dataclass(frozen=True)
class Forces:
    """φ̈, the friction on the slider along x, and the force of the guide on it along y."""

    alpha: float
    friction: float
    normal: float


def slider_velocity(phi: float, omega: float) -> float:
    """ẋ of the slider."""
    beta = np.arcsin(R * np.sin(phi) / L)
    return float(-R * np.sin(phi) * omega - R * np.cos(phi) * omega * np.tan(beta))


def forces(torque: float, phi: float, omega: float, side: float | None) -> Forces:
    """Forces and acceleration where the slider slides to the `side`, or, for None, rests.

    Unknown are φ̈, the pins' forces P on the rod at the crank and X, Y on the slider at the wrist,
    N, and, at rest, the friction f.
    """
    s, c = np.sin(phi), np.cos(phi)
    beta = np.arcsin(R * s / L)
    sb, cb = np.sin(beta), np.cos(beta)
    rate = R * c / (L * cb)  # dβ/dφ
    bend = (-R * s + L * sb * rate**2) / (L * cb)
    # Accelerations are (coefficient of φ̈, rest).
    slider = np.array([-R * s - L * sb * rate, -(R * c + L * cb * rate**2 + L * sb * bend)])
    rod_x = np.array([-R * s - L / 2 * sb * rate, -(R * c + L / 2 * (cb * rate**2 + sb * bend))])
    rod_y = np.array([R / 2 * c, -R / 2 * s])
    turn = -np.array([rate, bend])
    slider[1] *= omega**2
    rod_x[1] *= omega**2
    rod_y[1] *= omega**2
    turn[1] *= omega**2
    half_x, half_y = L / 2 * cb, -L / 2 * sb  # from the rod's centre to the wrist
    for sign in (1.0, -1.0):  # of N
        # φ̈, Px, Py, X, Y, N, f
        matrix = np.zeros((7, 7))
        right = np.zeros(7)
        matrix[0, [0, 1, 2]] = CRANK_INERTIA, -R * s, R * c
        right[0] = torque
        matrix[1, [0, 1, 3]] = ROD * rod_x[0], -1.0, 1.0
        right[1] = -ROD * rod_x[1]
        matrix[2, [0, 2, 4]] = ROD * rod_y[0], -1.0, 1.0
        right[2] = -ROD * rod_y[1] - ROD * G
        matrix[3, [0, 1, 2, 3, 4]] = (
            ROD_INERTIA * turn[0], -half_y, half_x, -half_y, half_x
        )  # fmt: skip
        right[3] = -ROD_INERTIA * turn[1]
        matrix[4, [0, 3, 6]] = SLIDER * slider[0], -1.0, -1.0
        right[4] = -SLIDER * slider[1]
        matrix[5, [4, 5]] = 1.0, 1.0
        right[5] = SLIDER * G
        if side is None:
            matrix[6, 0] = 1.0
        else:
            matrix[6, [5, 6]] = MU * side * sign, 1.0
        solved = np.linalg.solve(matrix, right)
        if side is None or solved[5] * sign >= 0.0:
            break
    return Forces(float(solved[0]), float(solved[6]), float(solved[5]))


def torque(t: float, size: float = 4.0, frequency: float = 3.0) -> float:
    """Of the motor."""
    return float(size * np.sin(frequency * t))


def motion(t_end: float, phi: float) -> tuple[np.ndarray, list[tuple[float, str]]]:
    """Final (φ, φ̇) and the instants at which the friction changed, from rest at t = 0.

    Each change is "sticks", or "+" or "-" for the side to which the slider slides.
    """
    y = np.array([phi, 0.0])
    t, side = _resting(0.0, t_end, y)
    changes = [(t, "+" if side > 0 else "-")]
    while t < t_end:
        y, t, side, change = _sliding(t, t_end, y, side)
        if change:
            changes.append((t, change))
        if side == 0.0 and t < t_end:
            t, side = _resting(t, t_end, y)
            if t < t_end:
                changes.append((t, "+" if side > 0 else "-"))
    return y, changes


def _sliding(
    t: float, t_end: float, y: np.ndarray, side: float
) -> tuple[np.ndarray, float, float, str]:
    def field(at: float, z: np.ndarray) -> list[float]:
        return [z[1], forces(torque(at), z[0], z[1], side).alpha]

    def stops(at: float, z: np.ndarray) -> float:
        return slider_velocity(z[0], z[1])

    stops.terminal = True  # type: ignore[attr-defined]
    stops.direction = -side  # type: ignore[attr-defined]
    run = solve_ivp(field, (t, t_end), y, "DOP853", events=stops, rtol=1e-12, atol=1e-13)
    if run.status == 0:
        return run.y[:, -1], t_end, side, ""
    t, y = float(run.t_events[0][0]), run.y_events[0][0]
    if abs(y[1]) < 1e-6:
        y = np.array([y[0], 0.0])
        rest = forces(torque(t), *y, None)
        if abs(rest.friction) <= MU * abs(rest.normal):
            return y, t, 0.0, "sticks"
    return y, t, -side, "+" if side < 0 else "-"


def _resting(t: float, t_end: float, y: np.ndarray) -> tuple[float, float]:
    """When the friction at rest reaches its limit, and the side to which it then lets go."""

    def room(at: float) -> float:
        rest = forces(torque(at), *y, None)
        return MU * abs(rest.normal) - abs(rest.friction)

    step = 1e-4
    while t < t_end and room(t + step) > 0.0:
        t += step
    low, high = t, t + step
    while high - low > 1e-14:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if room(middle) > 0.0 else (low, middle)
    return high, float(-np.sign(forces(torque(high), *y, None).friction))
