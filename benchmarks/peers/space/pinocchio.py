"""Pinocchio in space: `aba` of trees, `constraintDynamics` of loops, under SciPy's DOP853.

A hinge that closes a loop is held at two points of its axis by rigid constraints of three rows, of
which one always follows from the others; the proximal solver takes care of it.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numba
import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp

from benchmarks.peers.protocol import TOLERANCES as EVERY
from benchmarks.peers.protocol import main, sweep
from benchmarks.problems import Problem
from benchmarks.space_machines import ARM, BRICARD, Chain, Platform, SliderCrank, X, Y, Z

HINGES = {X: pin.JointModelRX, Y: pin.JointModelRY, Z: pin.JointModelRZ}
TOLERANCES = EVERY[::2]
PROXIMAL = (1e-13, 1e-8, 20)
"""Accuracy, regularisation, and most iterations."""


def placed(at: Any) -> Any:
    """A frame turned like its parent's."""
    return pin.SE3(np.eye(3), np.asarray(at, float))


def inertia(mass: float, lever: Any, about: Any) -> Any:
    """About the centre of mass; three principal moments or a matrix."""
    about = np.asarray(about, float)
    whole = np.diag(about) if about.ndim == 1 else about
    return pin.Inertia(mass, np.asarray(lever, float), whole)


def started(gravity: Sequence[float]) -> Any:
    """A model without joints."""
    model = pin.Model()
    model.gravity.linear = np.array(gravity)
    return model


def solve(
    problem: Problem, method: str, model: Any, accelerations: Any, where: Any, rates: Any
) -> None:
    """DOP853 over tolerances for a machine whose q̇ is v; the answer is a point of a joint."""
    n, data = model.nq, model.createData()
    (joint, point), start = where, np.concatenate([np.zeros(n), rates])

    # SciPy keeps what it is given from one step to the next: every answer is an array of its own.
    def slope(t: float, y: Any) -> Any:
        return np.concatenate((y[n:], accelerations(y[:n], y[n:])))

    def answer(out: Any) -> Any:
        pin.forwardKinematics(model, data, out.y[:n, -1])
        return data.oMi[joint].act(np.asarray(point, float))

    sweep(
        problem,
        "pinocchio",
        method,
        TOLERANCES,
        lambda rtol: solve_ivp(slope, (0, problem.duration), start, "DOP853", rtol=rtol, atol=rtol),
        lambda out: out.nfev,
        answer,
    )


def of_tree(model: Any) -> Callable[[Any, Any], Any]:
    """(q, v) → accelerations."""
    data, none = model.createData(), np.zeros(model.nv)
    return lambda q, v: pin.aba(model, data, q, v, none)


def of_loops(model: Any, points: Sequence[Any]) -> Callable[[Any, Any], Any]:
    """The same where points of two joints' bodies (joint, place, joint, place) coincide."""
    data, none = model.createData(), np.zeros(model.nv)
    models, held = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    for i, here, j, there in points:
        made = pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, model, i, placed(here), j, placed(there), pin.LOCAL
        )
        models.append(made)
        held.append(made.createData())
    pin.initConstraintDynamics(model, data, models, held)
    settings = pin.ProximalSettings(*PROXIMAL)
    return lambda q, v: pin.constraintDynamics(model, data, q, v, none, models, held, settings)


def chained(problem: Problem, chain: Chain, body: str) -> None:
    """Links one on the other, and the hinge that closes them."""
    model, last, origin, where = started(chain.gravity), 0, np.zeros(3), (0, np.zeros(3))
    for link in chain.links:
        hinge = np.array(link.hinge, float)
        last = model.addJoint(last, HINGES[link.axis](), placed(hinge - origin), link.name)
        lever, origin = np.array(link.centre) - hinge, hinge
        model.appendBodyToJoint(last, inertia(link.mass, lever, link.moments), placed(np.zeros(3)))
        where = (last, lever) if link.name == body else where
    if chain.closing is None:
        solve(problem, "aba, SciPy DOP853", model, of_tree(model), where, np.zeros(model.nv))
        return
    at, axis = map(np.array, chain.closing)
    points = [(last, p - origin, 0, p) for p in (at, at + axis)]
    accelerations = of_loops(model, points)
    method = "constraintDynamics, SciPy DOP853"
    solve(problem, method, model, accelerations, where, np.zeros(model.nv))


def crank(problem: Problem) -> None:
    """The rod turns on the slider, and its other end is held at the crank's pin."""
    s, none = SliderCrank, np.zeros(3)
    model = started(s.gravity)
    A, B, C, middle = map(np.array, (s.A, s.B, s.C, s.middle))
    slider = model.addJoint(0, pin.JointModelPX(), placed(C), "slider")
    model.appendBodyToJoint(slider, inertia(s.slider[0], none, s.slider[1]), placed(none))
    turned = model.addJoint(slider, pin.JointModelRX(), placed(none), "cross")
    across = pin.JointModelRevoluteUnaligned(np.array(s.across))
    rod = model.addJoint(turned, across, placed(none), "rod")
    model.appendBodyToJoint(rod, inertia(s.rod[0], middle - C, s.rod_inertia()), placed(none))
    pivot = model.addJoint(0, pin.JointModelRX(), placed(A), "crank")
    model.appendBodyToJoint(pivot, inertia(s.crank[0], none, s.crank[1]), placed(none))
    accelerations = of_loops(model, [(rod, B - C, pivot, B - A)])
    method = "constraintDynamics, SciPy DOP853"
    solve(problem, method, model, accelerations, (rod, middle - C), np.array(s.rates))


@numba.njit
def of_springs(y: Any, legs: Any, stiffness: float, rest: float) -> Any:
    """q̇ from v in the axes of the plate, and the springs' force and moment in them."""
    x, y_, z, w = y[3], y[4], y[5], y[6]
    turn = np.array(
        [
            [1 - 2 * (y_ * y_ + z * z), 2 * (x * y_ - w * z), 2 * (x * z + w * y_)],
            [2 * (x * y_ + w * z), 1 - 2 * (x * x + z * z), 2 * (y_ * z - w * x)],
            [2 * (x * z - w * y_), 2 * (y_ * z + w * x), 1 - 2 * (x * x + y_ * y_)],
        ]
    )
    force, moment, rates = np.zeros(3), np.zeros(3), np.empty(7)
    for k in range(len(legs)):
        arm, away = legs[k, 1], y[:3] - legs[k, 0]
        d0 = turn[0, 0] * away[0] + turn[1, 0] * away[1] + turn[2, 0] * away[2] + arm[0]
        d1 = turn[0, 1] * away[0] + turn[1, 1] * away[1] + turn[2, 1] * away[2] + arm[1]
        d2 = turn[0, 2] * away[0] + turn[1, 2] * away[1] + turn[2, 2] * away[2] + arm[2]
        pull = stiffness * (rest / np.sqrt(d0 * d0 + d1 * d1 + d2 * d2) - 1.0)
        f0, f1, f2 = pull * d0, pull * d1, pull * d2
        force += np.array([f0, f1, f2])
        moment += np.array(
            [arm[1] * f2 - arm[2] * f1, arm[2] * f0 - arm[0] * f2, arm[0] * f1 - arm[1] * f0]
        )
    a, b, c = y[10], y[11], y[12]
    for i in range(3):
        rates[i] = turn[i, 0] * y[7] + turn[i, 1] * y[8] + turn[i, 2] * y[9]
    rates[3] = 0.5 * (w * a + y_ * c - z * b)
    rates[4] = 0.5 * (w * b + z * a - x * c)
    rates[5] = 0.5 * (w * c + x * b - y_ * a)
    rates[6] = -0.5 * (x * a + y_ * b + z * c)
    return rates, force, moment


def platform(problem: Problem) -> None:
    """A free body with a wrench from compiled code; its attitude is a quaternion."""
    p = Platform
    model = started(p.gravity)
    plate = model.addJoint(0, pin.JointModelFreeFlyer(), placed(np.zeros(3)), "plate")
    model.appendBodyToJoint(plate, inertia(p.mass, np.zeros(3), p.moments), placed(np.zeros(3)))
    data, none, pushes = model.createData(), np.zeros(6), pin.StdVec_Force()
    pushes.extend([pin.Force.Zero(), pin.Force.Zero()])
    legs = np.array(p.legs())

    def slope(t: float, y: Any) -> Any:
        rates, force, moment = of_springs(y, legs, p.stiffness, p.rest)
        pushes[1] = pin.Force(force, moment)
        return np.concatenate((rates, pin.aba(model, data, y[:7], y[7:], none, pushes)))

    e0, *vector = p.attitude
    start = np.array([*p.place, *vector, e0, *none])
    slope(0.0, start)  # compiled before it is timed
    sweep(
        problem,
        "pinocchio",
        "aba, SciPy DOP853",
        TOLERANCES,
        lambda rtol: solve_ivp(slope, (0, problem.duration), start, "DOP853", rtol=rtol, atol=rtol),
        lambda out: out.nfev,
        lambda out: out.y[:3, -1],
    )


SOLVERS = {
    "bricard": lambda problem: chained(problem, BRICARD, "b3"),
    "spatial_slider_crank": crank,
    "stewart_platform": platform,
    "six_revolute_arm": lambda problem: chained(problem, ARM, "tool"),
}

if __name__ == "__main__":
    main(["pin", "scipy"], SOLVERS)
