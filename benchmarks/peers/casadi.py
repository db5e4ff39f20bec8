"""CasADi: the hand-reduced equations as expressions, by CVODES and its own Runge-Kutta."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import casadi

from benchmarks.equations import solvers
from benchmarks.floor.arithmetic import in_terms_of
from benchmarks.peers.protocol import TOLERANCES, main, point
from benchmarks.problems import Problem

MATHEMATICS = SimpleNamespace(sin=casadi.sin, cos=casadi.cos, sqrt=casadi.sqrt)
MULTISTEP = {
    "CVODES Adams": {
        "linear_multistep_method": "adams",
        "nonlinear_solver_iteration": "functional",
    },
    "CVODES BDF": {"linear_multistep_method": "bdf", "nonlinear_solver_iteration": "newton"},
}


def solve(
    problem: Problem,
    equation: Any,
    start: Sequence[float],
    parameters: Sequence[float],
    answer: Callable[[Any], Sequence[float]],
) -> None:
    """CVODES over tolerances, the fixed-step method over steps."""
    states = casadi.SX.sym("y", len(start))
    each = [states[k] for k in range(len(start))]
    slopes = casadi.vertcat(*in_terms_of(equation, MATHEMATICS)(*each, *parameters))
    system = {"x": states, "ode": slopes}

    def attempt(method: str, setting: float, kind: str, options: dict[str, Any]) -> bool:
        made = casadi.integrator("flow", kind, system, 0.0, problem.duration, options)
        found = point(
            problem,
            "casadi",
            method,
            setting,
            lambda: made(x0=list(start))["xf"].full().ravel(),
            angles=answer,
        )
        return found.milliseconds < 20_000

    for method, choice in MULTISTEP.items():
        for tolerance in TOLERANCES:
            limits = {"reltol": tolerance, "abstol": tolerance, "max_num_steps": 10_000_000}
            attempt(method, tolerance, "cvodes", {**choice, **limits})
    for doubling in range(13):
        steps = 100 * 2**doubling
        options = {"number_of_finite_elements": steps}
        if not attempt("RK4", problem.duration / steps, "rk", options):
            break


if __name__ == "__main__":
    main(["casadi"], solvers(solve, "slider_crank", "andrews", "chain_10"))
