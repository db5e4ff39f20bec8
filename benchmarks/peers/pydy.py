"""PyDy: Kane's equations of SymPy with the loop's rod angle dependent, compiled by Cython.

The right-hand side is solved symbolically, which for one freedom is faster than a linear system a
call, and integrated by SciPy.
"""

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
from benchmarks.peers.protocol import TIGHT, main, sweep
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
    """SciPy's DOP853, and LSODA, to which PyDy's own choice of integrator comes down."""
    made, push = compiled(), np.array([slider_crank.PARAMETERS[1]])
    phi, omega = slider_crank.START
    start = [phi, 0.0, omega, 2.0 * omega / 3.5]

    def slope(t: float, y: Any) -> Any:
        # It answers the same array each time, and SciPy keeps what it is given.
        return made(y, t, push).copy()

    for method in ("DOP853", "LSODA"):
        sweep(
            problem,
            "pydy",
            f"Cython, SciPy {method}",
            TIGHT,
            lambda rtol, method=method: solve_ivp(
                slope, (0.0, problem.duration), start, method, rtol=rtol, atol=rtol
            ),
            lambda out: out.nfev,
            lambda out: out.y[:1, -1],
        )


if __name__ == "__main__":
    main(["pydy", "sympy", "cython", "scipy"], {"slider_crank": crank})
