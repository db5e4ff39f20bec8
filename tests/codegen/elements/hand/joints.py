"""The joints of Haug's chapter 3 as he writes them; γ by differentiating twice on paper."""

import numpy as np

from tests.codegen.elements.hand.pair import (
    NORMAL,
    SI,
    SJ,
    UNIT,
    Formula,
    Rows,
    State,
    columns,
    span,
)
from tests.codegen.workbench import A, B

VALUE, LENGTH, ANGLE = 0.6, 1.7, 0.35
RADII = {"gear": (0.5, 1.2), "internal": (0.5, -1.7)}
LINE, OFFSET = 0.4, -0.3


def relative(k: int) -> Formula:
    """x_j^P - x_i^P - c, or y."""

    def rows(s: State, i: int | None, j: int | None) -> Rows:
        d, _, quadratic = span(s, i, j)
        e = np.eye(2)[k]
        on_i = columns(-e, -e @ B(s.body(i)[1]) @ SI)
        on_j = columns(e, e @ B(s.body(j)[1]) @ SJ)
        return np.array([d[k] - VALUE]), on_i, on_j, np.array([-quadratic[k]])

    return rows


def relative_phi(s: State, i: int | None, j: int | None) -> Rows:
    one = np.array([[0.0, 0, 1]])
    return np.array([s.body(j)[1] - s.body(i)[1] - VALUE]), -one, one, np.zeros(1)


def distance(s: State, i: int | None, j: int | None) -> Rows:
    d, rate, quadratic = span(s, i, j)
    on_i = columns(-2 * d, -2 * d @ B(s.body(i)[1]) @ SI)
    on_j = columns(2 * d, 2 * d @ B(s.body(j)[1]) @ SJ)
    gamma = np.array([-2 * rate @ rate - 2 * d @ quadratic])
    return np.array([d @ d - LENGTH**2]), on_i, on_j, gamma


def component(
    s: State, i: int | None, j: int | None, e: np.ndarray, si: np.ndarray, sj: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray, float]:
    """(A_i e)ᵀ d_ij, its derivatives for both bodies, and minus its second rate."""
    d, rate, quadratic = span(s, i, j, si, sj)
    (_, pi, _, wi), (_, pj, _, _) = s.body(i), s.body(j)
    u, turned = A(pi) @ e, B(pi) @ e
    on_i = np.array([*-u, turned @ d - u @ B(pi) @ si])
    on_j = np.array([*u, u @ B(pj) @ sj])
    return u @ d, on_i, on_j, -(u @ quadratic + 2 * wi * turned @ rate - wi**2 * u @ d)


def revolute_translational(s: State, i: int | None, j: int | None) -> Rows:
    phi, on_i, on_j, gamma = component(s, i, j, NORMAL, SI, SJ)
    return np.array([phi - VALUE]), on_i[None], on_j[None], np.array([gamma])


def translational(s: State, i: int | None, j: int | None) -> Rows:
    phi, on_i, on_j, gamma = component(s, i, j, NORMAL, SI, SJ)
    turned, one = s.body(j)[1] - s.body(i)[1], np.array([0.0, 0, 1])
    rows = np.array([on_i, -one]), np.array([on_j, one])
    return np.array([phi, turned - ANGLE]), *rows, np.array([gamma, 0])


def revolute(s: State, i: int | None, j: int | None) -> Rows:
    return tuple(part[:2] for part in weld(s, i, j))  # type: ignore[return-value]


def weld(s: State, i: int | None, j: int | None) -> Rows:
    d, _, quadratic = span(s, i, j)
    (_, pi, _, _), (_, pj, _, _) = s.body(i), s.body(j)
    on_i = np.vstack([columns(np.eye(2), B(pi) @ SI), [0, 0, -1]])
    on_j = np.vstack([columns(-np.eye(2), -B(pj) @ SJ), [0, 0, 1]])
    return np.array([*-d, pj - pi - ANGLE]), on_i, on_j, np.array([*quadratic, 0])


def line_of_centres(s: State, i: int | None, j: int | None, kind: str) -> float:
    """Haug's θ."""
    ri, rj = RADII[kind]
    return LINE + (ri * s.body(i)[1] + rj * s.body(j)[1]) / (ri + rj)


def gear(kind: str) -> Formula:
    """(x_j - x_i) sin θ - (y_j - y_i) cos θ."""
    ri, rj = RADII[kind]

    def rows(s: State, i: int | None, j: int | None) -> Rows:
        d, rate, quadratic = span(s, i, j)
        (_, pi, _, wi), (_, pj, _, wj) = s.body(i), s.body(j)
        theta = line_of_centres(s, i, j, kind)
        turning = (ri * wi + rj * wj) / (ri + rj)
        c, z = np.cos(theta), np.sin(theta)
        phi = d[0] * z - d[1] * c
        reach = d[0] * c + d[1] * z
        across = np.array([z, -c])
        on_i = columns(-across, -across @ B(pi) @ SI + reach * ri / (ri + rj))
        on_j = columns(across, across @ B(pj) @ SJ + reach * rj / (ri + rj))
        gamma = -(across @ quadratic) - 2 * turning * (c * rate[0] + z * rate[1])
        return np.array([phi]), on_i, on_j, np.array([gamma + turning**2 * phi])

    return rows


def rack_and_pinion(s: State, pinion: int | None, rack: int | None) -> Rows:
    """Pinion first, with SI its centre; SJ lies on the rack's pitch line."""
    radius = LENGTH
    across, on_rack, on_pinion, gamma = component(s, rack, pinion, NORMAL, SJ, SI)
    along, rack_rolls, pinion_rolls, gamma_rolls = component(s, rack, pinion, UNIT, SJ, SI)
    turn = s.body(pinion)[1] - s.body(rack)[1]
    phi = np.array([across - radius, along + radius * turn - OFFSET])
    rolls = np.array([0, 0, radius])
    of_pinion = np.array([on_pinion, pinion_rolls + rolls])
    of_rack = np.array([on_rack, rack_rolls - rolls])
    return phi, of_pinion, of_rack, np.array([gamma, gamma_rolls])


JOINTS: dict[str, Formula] = {
    "relative_x": relative(0),
    "relative_y": relative(1),
    "relative_phi": relative_phi,
    "distance": distance,
    "revolute_revolute": distance,
    "revolute": revolute,
    "translational": translational,
    "revolute_translational": revolute_translational,
    "weld": weld,
    "gear": gear("gear"),
    "internal": gear("internal"),
    "rack_and_pinion": rack_and_pinion,
}
