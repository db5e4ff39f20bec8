"""The problems on which machines are compared at equal error, and what their answers are.

An answer is one or several angles at the end of a run, or a point in space, and the error is the
largest difference from the reference, rad or m. Nothing here needs the program that is measured, so
that a contestant in another environment reads the same.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from scipy.special import ellipj, ellipk

GRAVITY = 9.81


@dataclass(frozen=True)
class Problem:
    """What is asked.

    Attributes
    ----------
    name, title
        For the command line and for people.
    duration
        s.
    reference
        The angles at the end, rad, or the coordinates of a point, m.
    trusted
        How far the reference can be trusted; no error below it is told from it.
    unit
        Of all of them.
    """

    name: str
    title: str
    duration: float
    reference: tuple[float, ...]
    trusted: float
    unit: str = "rad"

    def error(self, answer: Sequence[float]) -> float:
        """Largest difference from the reference; infinite where it is not a number."""
        differences = [abs(a - r) for a, r in zip(answer, self.reference, strict=True)]
        return max(differences) if all(map(math.isfinite, differences)) else math.inf


def crank_of_loops(loops: int, t: float) -> float:
    """Angle from the upright, rad, of the parallel four-bars in a row, by an elliptic function.

    All bars move as the first crank: J ψ'' = G sin ψ with J = (n + 1)/3 + n, G = g ((n + 1)/2 + n),
    and from ψ' = 1 rad/s upright ψ turns over and over: ψ = π + 2 am(u, m).
    """
    ratio = GRAVITY * ((loops + 1) / 2 + loops) / ((loops + 1) / 3 + loops)
    square = 1.0 + 4.0 * ratio
    m = 4.0 * ratio / square
    return float(math.pi + 2.0 * ellipj(t * math.sqrt(square) / 2.0 - ellipk(m), m)[3])


def n_four_bar(loops: int) -> Problem:
    """The parallel four-bars in a row; the answer is the first crank's angle from the level."""
    angle = math.pi / 2 - crank_of_loops(loops, 10.0)
    title = f"N-four-bar, N = {loops}, 10 s"
    return Problem(f"n_four_bar_{loops}", title, 10.0, (angle,), 1e-13)


SLIDER_CRANK = Problem(
    "slider_crank", "slider-crank without gas, 5 s, φ(5)", 5.0, (1007.754839355,), 5e-10
)
# The Test Set for IVP Solvers prints 15.81077119629904. Both equations of the floor, and all
# coordinates and the reduced ones of the program, agree on the number here to 1e-12.
ANDREWS = Problem("andrews", "Andrews' mechanism, β(0.03)", 0.03, (15.8107711951535,), 1e-12)
# By the floor at 1e-15; reduced coordinates, Exudyn's tree and MuJoCo agree with it to 4e-14.
CHAIN = Problem(
    "chain_10",
    "pendulum of 10 bars, 2 s, all angles",
    2.0,
    (
        -2.1173724574387185,
        -2.0135879604566447,
        -2.18071750937139,
        -2.4502670709995567,
        -2.4697051419308087,
        -2.6650397293755805,
        -2.6689335528058917,
        -2.7178278605927644,
        -2.714161154171939,
        -2.7530196424194013,
    ),
    1e-13,
)
# By SciPy at 1e-13, which the program in all coordinates meets.
LONG_CHAIN = Problem(
    "chain_100",
    "pendulum of 100 bars, 1 s, all angles",
    1.0,
    tuple(json.loads(Path(__file__).with_name("chain_100.json").read_text("utf-8"))),
    1e-11,
)
LOOPS = (2, 5, 10, 40)
# Machines in space, by the program at 1e-14 in both formulations. To what is trusted agree: the
# dense Newton-Euler equations of the tests, by SciPy, with Bricard's linkage, the platform and the
# arm; a solution of Bricard's linkage in one coordinate; Pinocchio's tree with a loop with the
# slider-crank, and MuJoCo's trees with the platform and the arm to 2e-13.
IN_SPACE = (
    Problem(
        "bricard",
        "Bricard's linkage, 9 s, centre of bar 3",
        9.0,
        (0.4158369373175, -1.2639112257588, -0.1497272183454),
        2e-12,
        "m",
    ),
    Problem(
        "spatial_slider_crank",
        "spatial slider-crank, free, 5 s, centre of the rod",
        5.0,
        (0.1118744009069, 0.0879631289326, 0.0473983794038),
        1e-12,
        "m",
    ),
    Problem(
        "stewart_platform",
        "Stewart platform on six springs, 2 s, centre of the plate",
        2.0,
        (-0.0019445412955, 0.0205434204278, 0.7193026188358),
        1e-13,
        "m",
    ),
    Problem(
        "six_revolute_arm",
        "arm with six hinges, let go, 2 s, centre of the tool",
        2.0,
        (0.7162779049437, -0.0938617032768, 0.7497786865586),
        1e-11,
        "m",
    ),
)
PROBLEMS = {
    problem.name: problem
    for problem in (
        SLIDER_CRANK,
        ANDREWS,
        *(n_four_bar(n) for n in LOOPS),
        CHAIN,
        LONG_CHAIN,
        *IN_SPACE,
    )
}
