"""Pinocchio: its constrained forward dynamics under SciPy's DOP853, and its tree algorithm.

The rod's end is held to the slider by a rigid constraint of three dimensions, one of which always
vanishes in a plane; the proximal solver that Pinocchio has for such constraints takes care of it,
and is exact to rounding with what is set here. Chains need no constraint: `aba`.
"""

from typing import Any

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

from benchmarks.floor import slider_crank
from benchmarks.peers.protocol import TIGHT, TOLERANCES, main, sweep
from benchmarks.problems import GRAVITY, Problem


def placed(x: float, y: float = 0.0) -> Any:
    """A frame turned like its parent's."""
    return pin.SE3(np.eye(3), np.array([x, y, 0.0]))


def added(model: Any, parent: int, joint: Any, x: float, body: tuple[float, float, float]) -> int:
    """A joint at x on its parent with a body of (mass, inertia, x of its centre)."""
    mass, inertia, centre = body
    number = model.addJoint(parent, joint, placed(x), f"joint_{model.njoints}")
    turning = np.diag([inertia, inertia, inertia])
    model.appendBodyToJoint(number, pin.Inertia(mass, np.array([centre, 0, 0]), turning), placed(0))
    return int(number)


def sweeps(problem: Problem, method: str, settings: Any, slope: Any, start: Any) -> None:
    """DOP853 over tolerances; answers are the sums of the first angles."""
    kept = len(problem.reference)
    sweep(
        problem,
        "pinocchio",
        method,
        settings,
        lambda rtol: solve_ivp(slope, (0, problem.duration), start, "DOP853", rtol=rtol, atol=rtol),
        lambda out: out.nfev,
        lambda out: np.cumsum(out.y[:kept, -1]),
    )


def crank(problem: Problem) -> None:
    """The closed loop."""
    model = pin.Model()
    model.gravity.linear = np.array([GRAVITY, 0.0, 0.0])
    turned = added(model, 0, pin.JointModelRZ(), 0.0, (200.0, 450.0, 0.0))
    rod = added(model, turned, pin.JointModelRZ(), 2.0, (35.0, 35.0, 1.75))
    slider = added(model, 0, pin.JointModelPX(), 0.0, (25.0, 0.02, 0.0))
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, model, rod, placed(3.5), slider, placed(0.0), pin.LOCAL
    )
    data, models = model.createData(), pin.StdVec_RigidConstraintModel()
    models.append(loop)
    held = pin.StdVec_RigidConstraintData()
    held.append(loop.createData())
    pin.initConstraintDynamics(model, data, models, held)
    settings = pin.ProximalSettings(1e-13, 1e-6, 20)
    push = np.array([slider_crank.PARAMETERS[1], 0.0, 0.0])

    def accelerations(q: Any, v: Any) -> Any:
        return pin.constraintDynamics(model, data, q, v, push, models, held, settings)

    # SciPy keeps what it is given from one step to the next: every answer is an array of its own.
    def whole(t: float, y: Any) -> Any:
        return np.concatenate((y[3:], accelerations(y[:3], y[3:])))

    phi, omega = slider_crank.START
    # At φ = π the rod lies along the x axis towards the slider at x = 1.5: its angle is 0.
    start = np.array([phi, -phi, 1.5, omega, 2.0 * omega / 3.5 - omega, 0.0])
    sweeps(problem, "constraintDynamics, SciPy DOP853", TIGHT, whole, start)


def chain(problem: Problem) -> None:
    """The tree."""
    links = len(problem.reference)
    model = pin.Model()
    model.gravity.linear = np.array([0.0, -GRAVITY, 0.0])
    last = 0
    for k in range(links):
        last = added(model, last, pin.JointModelRZ(), float(k > 0), (1.0, 1 / 12, 0.5))
    data, none = model.createData(), np.zeros(links)

    def slope(t: float, y: Any) -> Any:
        return np.concatenate((y[links:], pin.aba(model, data, y[:links], y[links:], none)))

    sweeps(problem, "aba, SciPy DOP853", TOLERANCES, slope, np.zeros(2 * links))


if __name__ == "__main__":
    main(["pin", "scipy"], {"slider_crank": crank, "chain_10": chain})
