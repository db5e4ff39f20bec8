"""SciPy's DOP853 on the hand-reduced equations, lambdified by SymPy with common parts taken out."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import sympy
from scipy.integrate import solve_ivp

from benchmarks.equations import solvers
from benchmarks.floor.arithmetic import in_terms_of
from benchmarks.peers.protocol import TOLERANCES, main, point
from benchmarks.problems import Problem

MATHEMATICS = SimpleNamespace(sin=sympy.sin, cos=sympy.cos, sqrt=sympy.sqrt)


def solve(
    problem: Problem,
    equation: Any,
    start: Sequence[float],
    parameters: Sequence[float],
    answer: Callable[[Any], Sequence[float]],
) -> None:
    """A grid of tolerances."""
    states = sympy.symbols(f"y:{len(start)}")
    slopes = in_terms_of(equation, MATHEMATICS)(*states, *parameters)
    slope = sympy.lambdify([states], slopes, "math", cse=True)
    for tolerance in TOLERANCES:

        def run(tolerance: float = tolerance) -> Any:
            return solve_ivp(
                lambda t, y: slope(y.tolist()),
                (0.0, problem.duration),
                list(start),
                method="DOP853",
                rtol=tolerance,
                atol=tolerance,
            )

        point(
            problem,
            "scipy",
            "DOP853",
            tolerance,
            run,
            lambda out: out.nfev,
            lambda out: answer(out.y[:, -1]),
        )


if __name__ == "__main__":
    main(["scipy", "sympy"], solvers(solve, "slider_crank", "andrews"))
