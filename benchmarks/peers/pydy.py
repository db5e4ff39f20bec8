"""PyDy: Kane's equations of SymPy with the loop's rod angle dependent, compiled by Cython.

The right-hand side is solved symbolically, which for one freedom is faster than a linear system a
call, and integrated by SciPy. In all coordinates the loop drifts open, which costs most of the
digits; so the crank alone is integrated as well, with the rod put in by hand before each call.
"""

import math
from typing import Any

import numpy as np
import sympy
from pydy.codegen.ode_function_generators import generate_ode_function
from scipy.integrate import solve_ivp
from sympy.physics.mechanics import (
    KanesMethod,
    Particle,
    Point,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
    inertia,
)

from benchmarks.floor import slider_crank
from benchmarks.peers.telling import DECADES, TOLERANCES, main, sweep
from benchmarks.problems import GRAVITY, Problem


TORQUE = sympy.Symbol("torque")


def compiled() -> Any:
    """(y, t, [torque]) → dy/dt of crank angle, rod angle and their speeds."""
    q1, q2, u1, u2 = dynamicsymbols("q1 q2 u1 u2")
    ground, crank, rod = ReferenceFrame("N"), ReferenceFrame("A"), ReferenceFrame("B")
    crank.orient(ground, "Axis", (q1, ground.z))
    rod.orient(ground, "Axis", (q2, ground.z))
    crank.set_ang_vel(ground, u1 * ground.z)
    rod.set_ang_vel(ground, u2 * ground.z)
    pivot = Point("O")
    pivot.set_vel(ground, 0)
    pin = pivot.locatenew("P", 2 * crank.x)
    pin.v2pt_theory(pivot, ground, crank)
    middle = pin.locatenew("G", sympy.Rational(7, 4) * rod.x)
    middle.v2pt_theory(pin, ground, rod)
    end = pin.locatenew("S", sympy.Rational(7, 2) * rod.x)
    end.v2pt_theory(pin, ground, rod)
    across = end.pos_from(pivot).dot(ground.y)
    torque, weight = TORQUE, GRAVITY * ground.x
    bodies = [
        RigidBody("crank", pivot, crank, 200, (inertia(crank, 0, 0, 450), pivot)),
        RigidBody("rod", middle, rod, 35, (inertia(rod, 0, 0, 35), middle)),
        Particle("slider", end, 25),
    ]
    loads = [(crank, torque * ground.z), (middle, 35 * weight), (end, 25 * weight)]
    kane = KanesMethod(
        ground,
        [q1],
        [u1],
        kd_eqs=[q1.diff() - u1, q2.diff() - u2],
        q_dependent=[q2],
        configuration_constraints=[across],
        u_dependent=[u2],
        velocity_constraints=[end.vel(ground).dot(ground.y)],
    )
    kane.kanes_equations(bodies, loads)
    return generate_ode_function(kane.rhs(), [q1, q2], [u1, u2], [TORQUE], generator="cython")


def crank(problem: Problem) -> None:
    """SciPy's DOP853 and LSODA, the crank alone and all coordinates."""
    made, push = compiled(), np.array([slider_crank.PARAMETERS[1]])
    phi, omega = slider_crank.START
    y = np.empty(4)

    def closed(t: float, state: Any) -> tuple[float, float]:
        phi, omega = state.tolist()
        s, c = 2.0 * math.sin(phi), 2.0 * math.cos(phi)
        y[:] = phi, -math.asin(s / 3.5), omega, -c * omega / math.sqrt(12.25 - s * s)
        return omega, made(y, t, push)[2]

    def whole(t: float, state: Any) -> Any:
        return made(state, t, push)

    def sweeps(name: str, settings: Any, slope: Any, start: Any) -> None:
        for method in ("DOP853", "LSODA"):
            sweep(
                problem,
                "pydy",
                f"{name}, SciPy {method}",
                settings,
                lambda rtol, method=method: solve_ivp(
                    slope, (0.0, problem.duration), start, method, rtol=rtol, atol=rtol
                ),
                lambda out: out.nfev,
                lambda out: out.y[:1, -1],
            )

    sweeps("crank alone, loop closed by hand", TOLERANCES, closed, [phi, omega])
    sweeps("all coordinates", DECADES, whole, [phi, 0.0, omega, 2.0 * omega / 3.5])


if __name__ == "__main__":
    main(["pydy", "sympy", "cython", "scipy"], {"slider_crank": crank})
