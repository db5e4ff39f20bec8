"""The drivers of Haug's section 3.5 by hand: rows of what is driven, less the law."""

import numpy as np

from tests.codegen.elements.hand.joints import component
from tests.codegen.elements.hand.pair import SI, SJ, UNIT, Formula, Rows, State, columns, span
from tests.codegen.workbench import A, B


def relative(k: int) -> Formula:
    """x_j^P - x_i^P, or y."""

    def rows(s: State, i: int | None, j: int | None) -> Rows:
        d, _, quadratic = span(s, i, j)
        e = np.eye(2)[k]
        on_i = columns(-e, -e @ B(s.body(i)[1]) @ SI)
        return d[k], on_i, columns(e, e @ B(s.body(j)[1]) @ SJ), -quadratic[k]

    return rows


def relative_phi(s: State, i: int | None, j: int | None) -> Rows:
    one = np.array([[0.0, 0, 1]])
    return s.body(j)[1] - s.body(i)[1], -one, one, np.zeros(1)


def distance(s: State, i: int | None, j: int | None) -> Rows:
    """L = |d| has L̇ = dᵀ ḋ / L and L̈ = (ḋᵀ ḋ + dᵀ d̈ - L̇²) / L."""
    d, rate, quadratic = span(s, i, j)
    length = np.sqrt(d @ d)
    u = d / length
    on_i = columns(-u, -u @ B(s.body(i)[1]) @ SI)
    on_j = columns(u, u @ B(s.body(j)[1]) @ SJ)
    gamma = -(rate @ rate + d @ quadratic - (u @ rate) ** 2) / length
    return length, on_i, on_j, gamma


def translation(s: State, i: int | None, j: int | None) -> Rows:
    along, on_i, on_j, gamma = component(s, i, j, UNIT, SI, SJ)
    return along, on_i[None], on_j[None], gamma


def point(k: int) -> Formula:
    """x_j^P, or y."""

    def rows(s: State, i: int | None, j: int | None) -> Rows:
        r, phi, _, omega = s.body(j)
        e = np.eye(2)[k]
        gamma = e @ A(phi) @ SJ * omega**2
        return (r + A(phi) @ SJ)[k], np.zeros((1, 3)), columns(e, e @ B(phi) @ SJ), gamma

    return rows


def point_phi(s: State, i: int | None, j: int | None) -> Rows:
    return s.body(j)[1], np.zeros((1, 3)), np.array([[0.0, 0, 1]]), np.zeros(1)


DRIVERS: dict[str, Formula] = {
    "point_x": point(0),
    "point_y": point(1),
    "point_phi": point_phi,
    "relative_x": relative(0),
    "relative_y": relative(1),
    "relative_phi": relative_phi,
    "rotation": relative_phi,
    "translation": translation,
    "distance": distance,
}
