"""Gyroscope, platform, suspension and arms in space against equations written by hand."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from models.space import six_revolute_arm
from runtime import Outcome, load
from tests.space.heavy_top import HeavyTop

G = np.array([0.0, 0.0, -9.81])
X, Y, Z = np.eye(3)


# -- tops ------------------------------------------------------------------------------------------


def test_the_heavy_top_nutates_in_closed_form() -> None:
    axes = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # the form's z′ along y
    form = HeavyTop(15.0, 1.0, 0.234375, 0.46875, axes.T @ [0, 150.0, -4.61538], axes)
    run = load("space/heavy_top").simulate(1.0, 11, rtol=1e-12, progress=False)
    exact = [form.attitude(t)[:, 2] for t in run.t]
    found = np.transpose([run.q(f"top.{c}") for c in "xyz"])
    assert_allclose(found, exact, rtol=0.0, atol=1e-8)


def test_the_gyroscope_precesses_steadily_with_its_axis_level() -> None:
    """Ω = m g l / (J ω), exactly: the moments of rings do not change to first order there."""
    around, moment = 2.0, 0.1 * 9.81 * 0.2
    start = {"turning.rate": around, "spinning.rate": moment / (2e-3 * around)}
    machine = load("space/gyroscope")
    run = machine.simulate(5.0, 51, start=start, rtol=1e-12, progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.q("tilting.angle"), 0.0, rtol=0.0, atol=1e-8)
    assert_allclose(run.q("turning.angle"), around * run.t, rtol=0.0, atol=1e-8)


def test_the_gyroscope_nods_by_its_momenta_and_its_energy() -> None:
    """p_ψ = 0 and p_φ stay: I(θ) ψ̇ = p_φ sin θ, ½ I ψ̇² + ½ I_y θ̇² = m g l sin θ."""
    level = 2.5e-3 + 1.2e-3 + 1.2e-3 + 2e-5 + 0.1 * 0.2**2  # about z, with the axis level
    upright = 2.5e-3 + 1e-3 + 2e-5  # with the axis upright, without the rotor's share
    across = 1.5e-3 + 1.2e-3 + 2e-5 + 0.1 * 0.2**2  # about y, of what nods
    run = load("space/gyroscope").simulate(0.5, 101, rtol=1e-12, progress=False)
    s = np.sin(run.q("tilting.angle"))
    moment = level * (1 - s**2) + upright * s**2
    precession = 2e-3 * 300.0 * s / moment
    assert_allclose(run.v("turning.rate"), precession, rtol=0.0, atol=1e-8)
    nodding = across * run.v("tilting.rate") ** 2
    fallen = 2 * 0.1 * 9.81 * 0.2 * s - moment * precession**2
    assert_allclose(nodding, fallen, rtol=0.0, atol=1e-10)
    assert 0.009 < s.max() < 0.01


# -- platform --------------------------------------------------------------------------------------


def platform() -> tuple[Any, Any]:
    """The joints of the base, and those of the plate in its axes, (6, 3)."""
    k = np.arange(6)
    middle, side = 2 * np.pi / 3 * (k // 2), (-1.0) ** k
    at, on = middle + side * np.pi / 18, middle + side * 5 * np.pi / 18
    base = 0.6 * np.column_stack([np.cos(at), np.sin(at), 0 * at])
    return base, 0.35 * np.column_stack([np.cos(on), np.sin(on), 0 * on])


def legs_of(place: Any, A: Any) -> tuple[Any, Any, Any]:
    """Lengths and directions of the legs, and the arms of their upper joints, (6,) and (6, 3)."""
    base, joints = platform()
    arms = joints @ A.T
    legs = place + arms - base
    lengths = np.linalg.norm(legs, axis=1)
    return lengths, legs / lengths[:, None], arms


MASS, MOMENTS = 40.0, np.array([1.3, 1.1, 2.3])


def test_the_plate_is_where_its_legs_reach_and_they_carry_it() -> None:
    run = load("space/stewart_platform", "legs").inverse_dynamics(1.0, 21, progress=False)
    place, a, p, p_tt = (
        np.transpose([read(f"plate.{c}") for c in names])
        for names in (("x", "y", "z"), ("e0", "e1", "e2", "e3"))
        for read in (run.q, run.a)
    )
    w = np.transpose([run.v(f"plate.omega_{c}") for c in "xyz"])
    e0, e, e0_tt, e_tt = p[:, :1], p[:, 1:], p_tt[:, :1], p_tt[:, 1:]
    turning = 2 * (e0 * e_tt - e0_tt * e - np.cross(e, e_tt))  # ω̇′ = 2 G p̈
    moment = MOMENTS * turning + np.cross(w, MOMENTS * w)
    force = np.transpose([run.reaction(f"leg_{k}", "force") for k in range(1, 7)])
    rest = np.sqrt(0.49 + 0.36 + 0.1225 - 0.42 * np.cos(2 * np.pi / 9))
    wanted = rest + 0.04 * np.sin(2 * np.pi * run.t[:, None] + np.arange(1, 7))
    for k, A in enumerate(run.rotation("plate")):
        lengths, along, arms = legs_of(place[k], A)
        assert_allclose(lengths, wanted[k], rtol=0.0, atol=1e-12)
        assert_allclose(force[k] @ along, MASS * (a[k] - G), rtol=0.0, atol=1e-9)
        pulled = np.cross(arms, force[k, :, None] * along).sum(axis=0)
        assert_allclose(A.T @ pulled, moment[k], rtol=0.0, atol=1e-9)
    assert np.abs(turning).max() > 0.5


def test_legs_have_the_lengths_of_a_driven_plate() -> None:
    run = load("space/stewart_platform", "pose").inverse_dynamics(1.0, 21, progress=False)
    s, c, twice = (f(n * 2 * np.pi * run.t) for f, n in ((np.sin, 1), (np.cos, 1), (np.sin, 2)))
    place = np.column_stack([0.04 * s, 0.04 * c, 0.7 + 0.02 * twice])
    e = np.column_stack([0.04 * c, 0.04 * twice, 0.08 * s])
    turns = Rotation.from_quat(np.column_stack([e, np.sqrt(1 - np.sum(e**2, axis=1))]))
    exact = [legs_of(r, A)[0] for r, A in zip(place, turns.as_matrix(), strict=True)]
    found = np.transpose([run[f"length_{k}"] for k in range(1, 7)])
    assert_allclose(found, exact, rtol=0.0, atol=1e-12)


def test_a_plate_on_springs_moves_as_newton_and_euler_say() -> None:
    rest = np.sqrt(0.49 + 0.36 + 0.1225 - 0.42 * np.cos(2 * np.pi / 9))

    def rates(_: float, y: Any) -> Any:
        r, A, v, w = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:]
        lengths, along, arms = legs_of(r, A)
        faster = np.sum((v + np.cross(A @ w, arms)) * along, axis=1)
        pulled = -(2e4 * (lengths - rest) + 200.0 * faster)[:, None] * along
        moment = A.T @ np.cross(arms, pulled).sum(axis=0)
        turning = (moment - np.cross(w, MOMENTS * w)) / MOMENTS
        spinning = A @ np.cross(w, np.eye(3)).T
        return np.concatenate([v, spinning.ravel(), G + pulled.sum(axis=0) / MASS, turning])

    start = np.concatenate([[0.05, 0, 0.7], np.eye(3).ravel(), np.zeros(6)])
    t = np.linspace(0.0, 1.0, 21)
    exact = solve_ivp(rates, (0, 1), start, "DOP853", t, rtol=1e-12, atol=1e-13).y.T
    run = load("space/stewart_platform", "springs").simulate(1.0, t, rtol=1e-11, progress=False)
    place = np.transpose([run.q(f"plate.{c}") for c in "xyz"])
    assert_allclose(place, exact[:, :3], rtol=0.0, atol=1e-8)
    assert_allclose(run.rotation("plate"), exact[:, 3:12].reshape(-1, 3, 3), rtol=0.0, atol=1e-8)


# -- suspension ------------------------------------------------------------------------------------


def turned(place: Any, hinge: Any, axis: Any, angle: float) -> Any:
    """A place turned about an axis through a hinge."""
    about = Rotation.from_rotvec(np.array(axis) / np.linalg.norm(axis) * angle)
    return about.apply(np.array(place) - hinge) + hinge


def suspension(height: float, steered: float) -> Any:
    """The rotation of the upright by lengths alone, for a height of the wheel and the rack's place.

    Unknowns are the angles of the wishbones and a rotation vector of the upright.
    """
    low, up, tie, wheel, rack = np.array([
        (0.0, 0.75, 0.18), (-0.02, 0.70, 0.50), (-0.14, 0.72, 0.28), (0.0, 0.80, 0.32),
        (-0.12, 0.36, 0.27),
    ])  # fmt: skip

    def misfit(y: Any) -> Any:
        lower = turned(low, (-0.02, 0.35, 0.21), (0.35, 0, -0.02), y[0])
        upper = turned(up, (-0.02, 0.42, 0.47), (0.27, 0, 0.02), y[1])
        A = Rotation.from_rotvec(y[2:])
        arm = lower + A.apply(tie - low) - (rack + steered * Y)
        reached = lower + A.apply(up - low) - upper
        rod = arm @ arm - (tie - rack) @ (tie - rack)
        return [*reached, rod, (lower + A.apply(wheel - low))[2] - height]

    found = root(misfit, np.zeros(5), tol=1e-15)
    assert np.abs(found.fun).max() < 1e-13
    return Rotation.from_rotvec(found.x[2:]).as_matrix()


def test_camber_and_toe_of_the_wishbones_follow_from_their_lengths() -> None:
    machine = load("space/double_wishbone", "guided")
    run = machine.inverse_dynamics(1.0, 9, progress=False)
    s, twice = np.sin(2 * np.pi * run.t), np.sin(4 * np.pi * run.t)
    for k, A in enumerate(run.rotation("upright")):
        exact = suspension(0.32 + 0.06 * s[k], 0.03 * twice[k])
        assert_allclose(A, exact, rtol=0.0, atol=1e-11)
        assert run["camber"][k] == pytest.approx(np.arcsin(exact[2, 1]), abs=1e-11)
        assert run["toe"][k] == pytest.approx(np.arctan2(exact[0, 1], exact[1, 1]), abs=1e-11)
    assert np.ptp(run["toe"]) > 0.1


def test_what_lifts_the_wheel_goes_into_energy_and_damper() -> None:
    machine = load("space/double_wishbone", "guided")
    h, middle = 1e-4, np.arange(0.05, 1.0, 0.1)
    run = machine.inverse_dynamics((middle[:, None] + h * np.arange(-2, 3)).ravel(), progress=False)
    place = np.transpose([run.q(f"lower.{c}") for c in "xyz"])
    foot = place + run.rotation("lower") @ [0.01, 0.04, 0.0]
    length = np.linalg.norm(foot - [0.0, 0.48, 0.62], axis=1)

    def rate(values: Any) -> Any:
        x = values.reshape(-1, 5)
        return (8 * (x[:, 3] - x[:, 1]) - x[:, 4] + x[:, 0]) / (12 * h)

    given = (run.power("road") + run.power("steering"))[2::5]
    lost = 2e3 * rate(length) ** 2
    assert_allclose(given, rate(run.energy()) + lost, rtol=0.0, atol=1e-6 * np.abs(given).max())
    assert lost.max() > 0.05 * np.abs(given).max()


def test_the_car_bounces_and_comes_to_rest() -> None:
    machine = load("space/double_wishbone", "bounce")
    run = machine.simulate(3.0, 301, rtol=1e-9, progress=False)
    assert run.outcome is Outcome.OK
    assert np.ptp(run.q("upright.z")) > 0.03
    rest = machine.equilibrium()
    assert rest["upright.z"] == pytest.approx(run.q("upright.z")[-1], abs=1e-5)


# -- arms ------------------------------------------------------------------------------------------

Link = tuple[Any, Any, bool, float, Any, Any]
"""Place of the joint, axis, whether it slides, mass, centre of mass and moments at the drawing."""


def motors(links: Sequence[Link], q: Any, v: Any, a: Any) -> list[float]:
    """Torques and forces of the joints of a chain, by the recursion of Newton and Euler."""
    R, shift = np.eye(3), np.zeros(3)  # a place x of the drawing has come to R x + shift
    w, alpha, acc, at = np.zeros(3), np.zeros(3), -G, np.zeros(3)  # of the joint before, in `at`
    outward = []
    for (place, axis, slides, mass, centre, moments), p, u, b in zip(links, q, v, a, strict=True):
        h = R @ axis
        joint = R @ place + shift
        arm = joint - at
        acc = acc + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))
        if slides:
            acc, joint = acc + 2 * np.cross(w, h * u) + h * b, joint + h * p
            along = np.cross(w, np.cross(w, h * p)) + np.cross(alpha, h * p)
            acc, shift = acc + along, shift + h * p
        else:
            alpha, w = alpha + h * b + np.cross(w, h * u), w + h * u
            turn = Rotation.from_rotvec(h * p).as_matrix()
            R, shift = turn @ R, turn @ (shift - joint) + joint
        at = joint
        reach = R @ centre + shift - at
        J = R @ np.diag(moments) @ R.T
        force = mass * (acc + np.cross(alpha, reach) + np.cross(w, np.cross(w, reach)))
        moment = J @ alpha + np.cross(w, J @ w)
        outward.append((at, h, slides, reach, force, moment))
    found, force, moment, beyond = [], np.zeros(3), np.zeros(3), np.zeros(3)
    for at, h, slides, reach, own, turning in reversed(outward):
        moment = moment + np.cross(beyond - at, force) + turning + np.cross(reach, own)
        force, beyond = force + own, at
        found.append(float(h @ (force if slides else moment)))
    return found[::-1]


def test_motors_of_the_six_hinges_exert_what_the_recursion_says() -> None:
    links = [
        (np.array(at), np.array(axis), False, float(model_value(mass)), np.array(c), np.array(J))
        for at, axis, mass, c, J, _ in six_revolute_arm.LINKS.values()
    ]
    amplitudes = np.array([row[-1] for row in six_revolute_arm.LINKS.values()])
    run = load("space/six_revolute_arm", "inverse_dynamics").inverse_dynamics(
        0.9, 19, progress=False
    )
    for k, t in enumerate(run.t):
        s, c = np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)
        laws = (1 - c) / 2, np.pi * s, 2 * np.pi**2 * c
        exact = motors(links, *(amplitudes * x for x in laws))
        found = [run.reaction(f"motor_{j}", "torque")[k] for j in range(1, 7)]
        assert_allclose(found, exact, rtol=0.0, atol=1e-9)


def model_value(mass: Any) -> Any:
    """A mass with the payload's default."""
    return mass.subs(six_revolute_arm.payload, 2.0) if hasattr(mass, "subs") else mass


def test_motors_of_the_scara_exert_what_the_recursion_says() -> None:
    none, quill = (0.0, np.zeros(3), np.zeros(3)), np.array([0.75, 0.01, 0.4])
    links: list[Link] = [
        (np.array([0, 0, 0.5]), Z, False, 6.0, np.array([0.2, 0, 0.5]), (0.02, 0.12, 0.13)),
        (np.array([0.4, 0, 0.5]), Z, False, 4.0, np.array([0.55, 0, 0.52]), (0.02, 0.06, 0.06)),
        (np.array([0.75, 0, 0.5]), Z, True, *none),
        (np.array([0.75, 0, 0.5]), Z, False, 4.0, quill, (0.02, 0.02, 4e-3)),
    ]
    amplitudes = np.array([1.5, -2.0, 0.15, 3.0])
    run = load("space/scara").inverse_dynamics(0.9, 19, progress=False)
    for k, t in enumerate(run.t):
        s, c = np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)
        laws = (1 - c) / 2, np.pi * s, 2 * np.pi**2 * c
        exact = motors(links, *(amplitudes * x for x in laws))
        words = ("torque", "torque", "force", "torque")
        found = [run.reaction(f"motor_{j}", w)[k] for j, w in enumerate(words, 1)]
        assert_allclose(found, exact, rtol=0.0, atol=1e-10)
