"""Linkages that close in many ways, and all their ways by a solver that shares nothing with ours.

Each linkage becomes, with one angle known, a chain of triangles and one equation. Its roots are
isolated on a fine grid along both branches of the triangle, and refined by Brent's method. Points
are complex numbers, angles are those of the bodies' x axes.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from codegen import Model

COARSE, FINE = 2_000, 20_000


def circles(a: complex, ra: float, b: complex, rb: float, side: int) -> complex:
    """The point at `ra` from a and `rb` from b, on the left of a→b for side 1; nan if none."""
    d = abs(b - a)
    x = (d * d + ra * ra - rb * rb) / (2 * d)
    y2 = ra * ra - x * x
    return a + (b - a) / d * complex(x, side * np.sqrt(y2)) if y2 >= 0.0 else complex(np.nan)


def roots(function: Callable[[float], float]) -> list[float]:
    """The roots of a function of an angle that has no value, nan, in some intervals."""
    grid = np.linspace(-np.pi, np.pi, COARSE + 1).tolist()
    known = [not np.isnan(function(x)) for x in grid]
    ends = [_end(function, a, b) for (a, b), (p, q) in _pairs(grid, known) if p != q]
    ends = [*grid[: known[0]], *ends, *grid[len(grid) - known[-1] :]]
    found = []
    for low, high in zip(ends[::2], ends[1::2], strict=True):
        cosines = np.cos(np.linspace(np.pi, 0.0, FINE + 1))  # closer where a branch ends
        places = [low, *(0.5 * (low + high + (high - low) * cosines)).tolist()[1:-1], high]
        for (a, b), (fa, fb) in _pairs(places, [function(x) for x in places]):
            if fa * fb <= 0.0 and fb != 0.0:
                found.append(float(brentq(function, a, b, xtol=1e-15, rtol=1e-14)))
    return found


def _pairs(first: list, second: list) -> Iterator[tuple[tuple, tuple]]:
    return zip(pairwise(first), pairwise(second), strict=True)


def _end(function: Callable[[float], float], a: float, b: float) -> float:
    """The last place between a and b at which a function has a value, to the last digits."""
    good, bad = (b, a) if np.isnan(function(a)) else (a, b)
    for _ in range(60):
        middle = 0.5 * (good + bad)
        good, bad = (good, middle) if np.isnan(function(middle)) else (middle, bad)
    return good


TRIAD = {"crank": 1.3, "coupler": 1.2, "rocker": 2.0, "reach": 1.0 + 1.9j, "link": 1.7}
"""Lengths of a triad, m: a four-bar's own, and a link from a point of its coupler."""


def triad_modes(
    a: complex, d: complex, k: complex, size: dict[str, complex] = TRIAD
) -> list[list[float]]:
    """Angles of crank, coupler, rocker and link, which are pinned to a, d and k; one row a mode."""

    def places(alpha: float, side: int) -> tuple[complex, complex, complex]:
        b = a + size["crank"] * np.exp(1j * alpha)
        c = circles(b, size["coupler"], d, size["rocker"], side)
        return b, c, b + size["reach"] * (c - b) / size["coupler"]

    found = []
    for side in (1, -1):
        for x in roots(lambda x, s=side: abs(places(x, s)[2] - k) ** 2 - size["link"] ** 2):
            b, c, q = places(x, side)
            found.append([x, *(float(np.angle(z)) for z in (c - b, c - d, q - k))])
    return found


def six_bar() -> Model:
    """Stephenson's six-bar, driven at the crank whose link holds the coupler of the four-bar.

    At this angle six modes close, two of which differ by a thousandth of a turn.
    """
    model = Model("six_bar")
    size = {n: model.parameter(f"{n}_length", abs(x)) for n, x in TRIAD.items() if n != "reach"}
    angle = model.parameter("angle", 0.26854, unit="rad")
    _triad(model, size, model.ground.at(0, 0), model.ground.at(2.2, 0))
    driver = model.body("input", mass=1.0, inertia=0.1)
    model.revolute("K0", model.ground.at(-0.1, 1.6), driver.at(0, 0))
    model.revolute("K", driver.at(0.5, 0), model.bodies["link"].at(0, 0))
    model.driver("drive", driver.phi, angle)
    model.scene("driven", drivers=["drive"], analysis="kinematics")
    return model


def _triad(model: Model, size: dict, a: object, d: object) -> None:
    bodies = [model.body(n, mass=1.0, inertia=0.1) for n in ("crank", "coupler", "rocker", "link")]
    crank, coupler, rocker, link = bodies
    model.revolute("A", a, crank.at(0, 0))
    model.revolute("B", crank.at(size["crank"], 0), coupler.at(0, 0))
    model.revolute("C", coupler.at(size["coupler"], 0), rocker.at(size["rocker"], 0))
    model.revolute("D", d, rocker.at(0, 0))
    reach = TRIAD["reach"]
    model.revolute("Q", coupler.at(reach.real, reach.imag), link.at(size["link"], 0))


def seven_bar() -> Model:
    """The triad on two driven cranks and the ground."""
    model = Model("seven_bar")
    size = {n: model.parameter(f"{n}_length", abs(x)) for n, x in TRIAD.items() if n != "reach"}
    first = model.body("first", mass=1.0, inertia=0.1)
    second = model.body("second", mass=1.0, inertia=0.1)
    _triad(model, size, first.at(0.4, 0), model.ground.at(2.2, 0))
    model.revolute("O1", model.ground.at(-0.3, 0.2), first.at(0, 0))
    model.revolute("O2", model.ground.at(-0.1, 1.6), second.at(0, 0))
    model.revolute("K", second.at(0.5, 0), model.bodies["link"].at(0, 0))
    model.driver("first_drive", first.phi, model.parameter("first_angle", 0.7, unit="rad"))
    model.driver("second_drive", second.phi, model.parameter("second_angle", 0.3, unit="rad"))
    model.scene("driven", drivers=["first_drive", "second_drive"], analysis="kinematics")
    return model


BUTTERFLY: dict[str, complex] = {
    "A": -0.2 + 0.6j, "P": 2.2 + 0.4j, "G": 2.2 + 0.2j,  # on the ground
    "E": 1.6 + 1.4j, "F": -0.1 + 0.9j,  # on the first wing, from P
    "H": 1.6 + 0.6j, "Q": 1.0 + 1.1j,  # on the second, from B
    "J": 0.8 - 0.6j, "K": 1.2 + 0.4j,  # on the third, from Q
    "a": 1.2, "EH": 2.1, "GJ": 1.5, "FK": 1.4,
}  # fmt: skip
"""Places in the frames of the links, m, and lengths of the bars, m."""


def parameters_of(size: dict[str, complex]) -> dict[str, float]:
    """The values of the parameters of the double butterfly."""
    return {
        name + part: float(getattr(complex(value), kind))
        for name, value in size.items()
        for part, kind in (("_x", "real"), ("_y", "imag"))
        if isinstance(value, complex) or part == "_x"
    }


def double_butterfly() -> Model:
    """Two pairs of ternary links, each pinned together, and four bars between the pairs."""
    model = Model("double_butterfly")
    size = {n: model.parameter(n, x, unit="m") for n, x in parameters_of(BUTTERFLY).items()}
    ground = model.ground

    def at(body: object, name: str) -> object:
        return body.at(size[f"{name}_x"], size[f"{name}_y"])

    names = ("crank", "wing_2", "wing_3", "wing_4", "bar_EH", "bar_GJ", "bar_FK")
    crank, two, three, four, eh, gj, fk = (model.body(n, mass=1.0, inertia=0.1) for n in names)
    model.revolute("A", at(ground, "A"), crank.at(0, 0))
    model.revolute("B", crank.at(size["a_x"], 0), three.at(0, 0))
    model.revolute("P", at(ground, "P"), two.at(0, 0))
    model.revolute("E", at(two, "E"), eh.at(0, 0))
    model.revolute("H", at(three, "H"), eh.at(size["EH_x"], 0))
    model.revolute("Q", at(three, "Q"), four.at(0, 0))
    model.revolute("G", at(ground, "G"), gj.at(0, 0))
    model.revolute("J", at(four, "J"), gj.at(size["GJ_x"], 0))
    model.revolute("F", at(two, "F"), fk.at(0, 0))
    model.revolute("K", at(four, "K"), fk.at(size["FK_x"], 0))
    model.driver("drive", crank.phi, model.parameter("angle", 0.6, unit="rad"))
    model.scene("driven", drivers=["drive"], analysis="kinematics")
    return model


def butterfly_modes(alpha: float, size: dict[str, complex] = BUTTERFLY) -> list[list[float]]:
    """Angles of the bodies but the crank, in the order of the model, one row a mode."""
    b = size["A"] + size["a"] * np.exp(1j * alpha)

    def third(beta: float, side: int) -> complex:
        """exp(i angle) of the third wing."""
        e = size["P"] + size["E"] * np.exp(1j * beta)
        return (circles(b, abs(size["H"]), e, size["EH"], side) - b) / size["H"]

    def fourth(beta: float, side: int) -> tuple[complex, float]:
        """exp(i angle) of the fourth wing times a determinant, and the determinant."""
        q = b + size["Q"] * third(beta, side)
        rows, right = [], []
        for centre, arm, length in (
            (size["G"], size["J"], size["GJ"]),
            (size["P"] + size["F"] * np.exp(1j * beta), size["K"], size["FK"]),
        ):
            w = 2.0 * np.conj(q - centre) * arm
            rows.append((w.real, -w.imag))
            right.append(length**2 - abs(q - centre) ** 2 - abs(arm) ** 2)
        (m, n), (o, p) = rows
        u, v = right
        return complex(p * u - n * v, m * v - o * u), m * p - n * o

    def residual(beta: float, side: int) -> float:
        z, determinant = fourth(beta, side)
        return abs(z) ** 2 - determinant**2

    found = []
    for side in (1, -1):
        for x in roots(lambda x, s=side: residual(x, s)):
            z, determinant = fourth(x, side)
            tau, psi, turn = third(x, side), z / determinant, np.exp(1j * x)
            q = b + size["Q"] * tau
            e, f = (size["P"] + size[n] * turn for n in "EF")
            bars = b + size["H"] * tau - e, q + size["J"] * psi - size["G"], q + size["K"] * psi - f
            found.append([float(np.angle(y)) for y in (turn, tau, psi, *bars)])
    return found


def disagreement(found: list[list[float]], true: list[list[float]]) -> float:
    """The largest difference, rad, of rows paired one to one; infinite where numbers differ."""
    if len(found) != len(true):
        return np.inf
    turned = np.array(found)[:, None] - np.array(true)[None]
    apart = np.abs(np.angle(np.exp(1j * turned))).max(axis=2)
    return float(apart.min(axis=1).max()) if len({*apart.argmin(axis=1)}) == len(true) else np.inf
