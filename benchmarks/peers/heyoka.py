"""heyoka: Taylor series of the hand-reduced equations, compiled."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import heyoka

from benchmarks.equations import solvers
from benchmarks.floor.arithmetic import in_terms_of
from benchmarks.peers.protocol import TOLERANCES, main, point
from benchmarks.problems import Problem

MATHEMATICS = SimpleNamespace(sin=heyoka.sin, cos=heyoka.cos, sqrt=heyoka.sqrt)


def solve(
    problem: Problem,
    equation: Any,
    start: Sequence[float],
    parameters: Sequence[float],
    answer: Callable[[Any], Sequence[float]],
) -> None:
    """A grid of tolerances; compilation is no part of the time."""
    states = [heyoka.expression(f"y{k}") for k in range(len(start))]
    slopes = in_terms_of(equation, MATHEMATICS)(*states, *parameters)
    system = [
        (state, slope if isinstance(slope, heyoka.expression) else heyoka.expression(slope))
        for state, slope in zip(states, slopes, strict=True)
    ]
    for tolerance in (*TOLERANCES, 1e-14, 1e-15):
        integrator = heyoka.taylor_adaptive(
            system, list(start), tol=tolerance, compact_mode=len(start) > 8
        )

        def run(integrator: Any = integrator) -> Any:
            integrator.time = 0.0
            integrator.state[:] = start
            steps = integrator.propagate_until(problem.duration)[3]
            return answer(integrator.state.copy()), steps

        point(problem, "heyoka", "Taylor", tolerance, run, lambda out: out[1], lambda out: out[0])


if __name__ == "__main__":
    main(["heyoka"], solvers(solve, "slider_crank", "andrews", "chain_10"))
