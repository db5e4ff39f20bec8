"""numbalsoda: LSODA and DOP853 called from compiled code on the hand-reduced equations."""

from typing import Any

import numpy as np
from numba import cfunc
from numbalsoda import dop853, lsoda, lsoda_sig

from benchmarks.floor import andrews, slider_crank
from benchmarks.peers.protocol import TOLERANCES, main, sweep
from benchmarks.problems import Problem

METHODS = {"LSODA": lsoda, "DOP853": dop853}


def solve(problem: Problem, address: Any, start: Any) -> None:
    """Both methods over tolerances; the first state is asked for."""
    instants, states = np.array([0.0, problem.duration]), np.array(start)
    for name, method in METHODS.items():

        def run(tolerance: float, method: Any = method) -> Any:
            found, right = method(address, states, instants, rtol=tolerance, atol=tolerance)
            if not right:
                raise RuntimeError("the solver gave up")
            return found[-1, :1]

        sweep(problem, "numbalsoda", name, TOLERANCES, run)


def crank(problem: Problem) -> None:
    """The slider-crank in its crank's angle."""
    slope, (inertia, torque) = slider_crank.slope, slider_crank.PARAMETERS

    @cfunc(lsoda_sig)
    def rates(t: Any, y: Any, dy: Any, p: Any) -> None:
        dy[0], dy[1] = slope(y[0], y[1], inertia, torque)

    solve(problem, rates.address, slider_crank.START)


def squeezer(problem: Problem) -> None:
    """Andrews' mechanism with its eight states."""
    slope, torque = andrews.with_angles, andrews.TORQUE

    @cfunc(lsoda_sig)
    def rates(t: Any, y: Any, dy: Any, p: Any) -> None:
        found = slope(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], torque)
        for k in range(8):
            dy[k] = found[k]

    solve(problem, rates.address, andrews.START)


if __name__ == "__main__":
    main(["numbalsoda"], {"slider_crank": crank, "andrews": squeezer})
