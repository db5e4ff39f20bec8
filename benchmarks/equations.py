"""The problems whose hand-reduced equation a peer can be given, in terms of its own functions."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from benchmarks.floor import andrews, chain, slider_crank
from benchmarks.problems import Problem

LINKS = 10
Solver = Callable[[Problem], None]


class Solve(Protocol):
    """Solve a problem: its equation, start and parameters, and which states are asked for."""

    def __call__(
        self,
        problem: Problem,
        equation: Any,
        start: Sequence[float],
        parameters: Sequence[float],
        answer: Callable[[Any], Sequence[float]],
    ) -> None: ...


def solvers(solve: Solve, *problems: str) -> Mapping[str, Solver]:
    """A solver for each of the problems named."""
    known: Mapping[str, Solver] = {
        "slider_crank": lambda problem: solve(
            problem,
            slider_crank.slope,
            slider_crank.START,
            slider_crank.PARAMETERS,
            lambda y: y[:1],
        ),
        "andrews": lambda problem: solve(
            problem, andrews.with_angles, andrews.START, (andrews.TORQUE,), lambda y: y[:1]
        ),
        f"chain_{LINKS}": lambda problem: solve(
            problem,
            chain.equation(LINKS),
            (0.0,) * (2 * LINKS),
            (chain.GRAVITY,),
            lambda y: y[:LINKS],
        ),
    }
    return {name: known[name] for name in problems}
