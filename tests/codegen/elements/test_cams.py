"""Cams and followers against formulas written out by hand, complex steps, and balances."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, alpha, t
from codegen.check.declaration import check_model
from codegen.errors import ModelError
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.workbench import A, B, Interpreted, State, python_functions

TOLERANCE = {"rtol": 1e-12, "atol": 1e-13}
FACE, AXIS = np.array([0.3, -0.2]), np.array([1.2, 0.5])
NORMAL = np.array([-AXIS[1], AXIS[0]]) / np.linalg.norm(AXIS)
X = 0.9 * sympy.cos(alpha) + 0.05 * sympy.sin(2 * alpha)
Y = 0.6 * sympy.sin(alpha)
PACE = 0.608  # |c'(0)| = √0.37 to three digits


def profile(a: float) -> list[np.ndarray]:
    """The curve and its first three derivatives, written by hand."""
    c, s, c2, s2 = np.cos(a), np.sin(a), np.cos(2 * a), np.sin(2 * a)
    return [
        np.array([0.9 * c + 0.05 * s2, 0.6 * s]),
        np.array([-0.9 * s + 0.1 * c2, 0.6 * c]),
        np.array([-0.9 * c - 0.2 * s2, -0.6 * s]),
        np.array([0.9 * s - 0.4 * c2, -0.6 * c]),
    ]


def two_bodies() -> tuple[Model, object, object]:
    model = Model("pair")
    first = model.body("first", mass=2.0, inertia=0.5)
    return model, first, model.body("second", mass=3.0, inertia=0.7)


def cam_flat_follower() -> Model:
    model, first, second = two_bodies()
    model.cam_flat_follower("touch", first.curve(X, Y), second.at(*FACE), axis=tuple(AXIS))
    return model


def point_follower() -> Model:
    model, first, second = two_bodies()
    model.point_follower("touch", first.curve(X, Y), second.at(*FACE))
    return model


def cam_follower() -> Model:
    model, first, second = two_bodies()
    model.cam_follower("touch", first.curve(X, Y), second.circle(0.4, center=FACE))
    return model


JOINTS: dict[str, Callable[[], Model]] = {
    "cam_flat_follower": cam_flat_follower,
    "point_follower": point_follower,
    "cam_follower": cam_follower,
}


def test_flat_follower_is_haugs() -> None:
    machine = Interpreted(cam_flat_follower())
    for seed in range(5):
        s = machine.state(seed)
        (ri, pi, vi, wi), (rj, pj, vj, wj) = s.body(0), s.body(1)
        a, rate = s.q[6], s.v[6]
        c, c1, c2, c3 = profile(a)
        n, turned = A(pj) @ NORMAL, B(pj) @ NORMAL
        d = ri + A(pi) @ c - rj - A(pj) @ FACE
        assert_allclose(
            machine.vector("constraints", s), [n @ d, n @ A(pi) @ c1 / PACE], **TOLERANCE
        )
        by_hand = np.array(
            [
                [*n, n @ B(pi) @ c, *-n, turned @ d - n @ B(pj) @ FACE, n @ A(pi) @ c1],
                [0, 0, n @ B(pi) @ c1, 0, 0, turned @ A(pi) @ c1, n @ A(pi) @ c2],
            ]
        )
        by_hand[1] /= PACE
        assert_allclose(machine.jacobian(s), by_hand, **TOLERANCE)
        speed = vi + wi * B(pi) @ c + rate * A(pi) @ c1 - vj - wj * B(pj) @ FACE
        bend = -(wi**2) * A(pi) @ c + 2 * wi * rate * B(pi) @ c1 + rate**2 * A(pi) @ c2
        bend += wj**2 * A(pj) @ FACE
        slope = wi * B(pi) @ c1 + rate * A(pi) @ c2
        curl = -(wi**2) * A(pi) @ c1 + 2 * wi * rate * B(pi) @ c2 + rate**2 * A(pi) @ c3
        gamma = [
            -(n @ bend + 2 * wj * turned @ speed - wj**2 * n @ d),
            -(n @ curl + 2 * wj * turned @ slope - wj**2 * n @ A(pi) @ c1) / PACE,
        ]
        assert_allclose(machine.vector("acceleration_rhs", s), gamma, **TOLERANCE)


def test_point_follower_is_haugs_in_the_axes_of_the_curve() -> None:
    machine = Interpreted(point_follower())
    for seed in range(5):
        s = machine.state(seed)
        (ri, pi, _, _), (rj, pj, _, _) = s.body(0), s.body(1)
        c, c1, c2, _ = profile(s.q[6])
        reach = rj + A(pj) @ FACE - ri
        d = A(pi).T @ reach - c
        left = np.array([[0.0, -1.0], [1.0, 0.0]])
        rows = []
        for tangent, change in ((c1, c2), (left @ c1, left @ c2)):
            on_j = [*(A(pi) @ tangent), tangent @ A(pi).T @ B(pj) @ FACE]
            on_i = [*(-A(pi) @ tangent), tangent @ B(pi).T @ reach]
            rows.append([*on_i, *on_j, change @ d - tangent @ c1])
        assert_allclose(machine.jacobian(s), np.array(rows) / PACE, **TOLERANCE)
        expected = np.array([c1 @ d, left @ c1 @ d]) / PACE
        assert_allclose(machine.vector("constraints", s), expected, **TOLERANCE)


def on_the_constraints(machine: Interpreted, seed: int) -> State:
    """A state near `seed`'s that satisfies Φ and Φ_q q̇ = ν."""
    s = machine.state(seed)
    for _ in range(60):
        phi, jacobian = machine.vector("constraints", s), machine.jacobian(s)
        step = np.linalg.lstsq(jacobian, -phi, rcond=None)[0]
        s = State(t=s.t, q=s.q + step / max(1.0, 2 * np.linalg.norm(step)), v=s.v)
    assert_allclose(machine.vector("constraints", s), 0, atol=1e-13)
    jacobian = machine.jacobian(s)
    s.v -= np.linalg.lstsq(jacobian, jacobian @ s.v, rcond=None)[0]
    return s


@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("seed", range(3))
def test_accelerations_solve_the_equations_and_contact_does_no_work(kind: str, seed: int) -> None:
    machine = Interpreted(JOINTS[kind]())
    s = on_the_constraints(machine, seed)
    a, lam = machine.solution(s)
    jacobian = machine.jacobian(s)
    mass = machine.mass(s)
    assert_allclose(mass[6:, 6:], 0, atol=0)
    size = np.abs(lam).max()
    assert_allclose(mass @ a + jacobian.T @ lam, 0, atol=1e-11 * size)
    assert_allclose(jacobian @ a, machine.vector("acceleration_rhs", s), rtol=1e-9, atol=1e-10)
    # No force on the pair from outside: momentum and angular momentum stay as they are.
    force = -jacobian.T @ lam
    assert_allclose(force[:2] + force[3:5], 0, atol=1e-11 * size)
    (ri, *_), (rj, *_) = s.body(0), s.body(1)
    moment = force[2] + force[5] + ri[0] * force[1] - ri[1] * force[0]
    moment += rj[0] * force[4] - rj[1] * force[3]
    assert_allclose(moment, 0, atol=1e-11 * size)
    # A frictionless contact pushes along the normal and does no work.
    assert_allclose(force @ s.v, 0, atol=1e-10 * size)
    table = machine.lowered.description.reactions
    values = machine.vector("reactions", s, lam=lam)
    found = {component: x for (_, component, _), x in zip(table, values, strict=True)}
    assert_allclose(found["fx"], 0, atol=1e-11 * size)
    assert_allclose(np.hypot(found["fx"], found["fy"]), np.linalg.norm(force[3:5]), rtol=1e-12)
    if kind != "cam_flat_follower":  # there the torque is about the point of the face
        assert_allclose(found["torque"], 0, atol=1e-11 * size)


@pytest.mark.parametrize("size", [1e200, 1.0, 1e-200])
def test_convexity_is_judged_at_any_size(size: float) -> None:
    """Numpy's warnings of overflow are errors in the tests."""
    model, first, second = two_bodies()
    model.cam_flat_follower("flat", first.circle(size), second)
    model.cam_follower(
        "roll", first.polar(size * (1 + 0.4 * sympy.cos(2 * alpha))), second.circle(size / 9)
    )
    found = " ".join(check_model(model))
    assert "not convex" not in found
    assert "or a cusp" not in found


def test_roller_may_follow_a_hollow_cam_and_a_point_an_open_slot() -> None:
    model, first, second = two_bodies()
    hollow = first.polar(1 + 0.4 * sympy.cos(2 * alpha))
    model.cam_follower("roll", hollow, second.circle(0.1))
    model.point_follower("slot", first.curve(alpha, alpha**2), second)
    assert valid_scenes(model, None)


def test_parameters_may_shape_a_cam() -> None:
    model, first, second = two_bodies()
    offset = model.parameter("offset", 0.2, "m")
    model.cam_flat_follower("lift", first.circle(1.0, center=(offset, 0)), second)
    machine = Interpreted(model)
    s = machine.state(1)
    assert machine.vector("constraints", s).shape == (2,)
    machine.p = [0.3]
    assert abs(machine.vector("constraints", s)[0]) > 0


def test_coordinate_of_a_joint_can_be_named_in_a_scene_and_a_joint_left_out() -> None:
    model, first, second = two_bodies()
    lift = model.cam_flat_follower("lift", first.circle(1.0), second)
    model.scene("held", start={"lift.alpha": 1.0}, guess={lift.alpha: 2.0})
    model.scene("open", without=["lift"])
    held, free = Interpreted(model, "held"), Interpreted(model, "open")
    assert held.lowered.description.coordinates[-1] == ("lift.alpha", "lift.alphadot", "rad")
    assert (held.n, held.m, free.n, free.m) == (7, 2, 6, 0)
    assert ("lift", "cam and flat-faced follower") in free.lowered.description.left_out


@pytest.mark.parametrize(("phi", "side"), [(0.0, 1.0), (np.pi, -1.0)])
def test_contact_is_sought_where_the_cam_reaches_the_follower(phi: float, side: float) -> None:
    model, first, second = two_bodies()
    oval = first.curve(0.3 * sympy.cos(alpha), 0.2 * sympy.sin(alpha))
    flat = model.cam_flat_follower("flat", oval, second)
    pin = model.point_follower("pin", oval, second.at(0.4, 0))
    roll = model.cam_follower("roll", oval, second.circle(0.1, center=(-0.4, 0)))
    model.scene("near", guess={second.phi: phi})
    (scene,) = valid_scenes(model, "near")
    found = dict(scene.guess)
    assert_allclose(np.sin(found["flat.alpha"]), side, atol=1e-4)
    assert_allclose(np.cos(found["pin.alpha"]), side, atol=1e-4)
    assert_allclose(np.cos(found["roll.alpha"]), -side, atol=1e-3)
    assert_allclose(np.cos(found["roll.beta"]), 1, atol=1e-3)
    own = Interpreted(model).equations.coordinates[6:]
    assert {flat.alpha, pin.alpha, roll.alpha, roll.beta} == set(own)


def test_scene_that_says_where_a_contact_is_keeps_its_word() -> None:
    model, first, second = two_bodies()
    lift = model.cam_flat_follower("lift", first.circle(1.0), second)
    model.scene("named", guess={lift.alpha: 1.25})
    assert valid_scenes(model, "named")[0].guess == (("lift.alpha", 1.25),)


def test_radius_of_a_cam_may_be_a_parameter() -> None:
    for cam in ("circle", "polar"):
        model, first, second = two_bodies()
        r = model.parameter("r", 0.7, "m", sign="positive")
        model.cam_flat_follower("lift", getattr(first, cam)(r), second)
        model.cam_follower("roll", getattr(first, cam)(r), second.circle(r / 4))
        model.point_follower("slot", getattr(first, cam)(r), second)
        assert Interpreted(model).m == 7


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.05), (0.0, -0.3), (0.02, 0.0)])
def test_roller_begins_outside_the_cam(x: float, y: float) -> None:
    model, first, second = two_bodies()
    model.cam_follower("roll", first.circle(0.1), second.circle(0.02))
    model.scene("near", guess={second.x: x, second.y: y})
    found = dict(valid_scenes(model, "near")[0].guess)
    a, b = found["roll.alpha"], found["roll.beta"]
    assert_allclose([np.cos(a), np.sin(a)], np.array([x, y]) / np.hypot(x, y), atol=0.02)
    assert_allclose([np.cos(b), np.sin(b)], -np.array([x, y]) / np.hypot(x, y), atol=0.02)


def test_size_of_a_cam_does_not_matter_to_what_is_watched() -> None:
    for size in (1e-6, 1.0, 1e3):
        model, first, second = two_bodies()
        model.cam_follower("roll", first.circle(size), second.circle(size / 3))
        machine = Interpreted(model)
        q = np.zeros(8)
        q[3], q[7] = size * 4 / 3, np.pi
        s = State(t=0.0, q=q, v=np.zeros(8))
        assert_allclose(machine.vector("constraints", s), 0, atol=1e-12 * max(size, 1.0))
        functions = python_functions(machine.text())
        a, lam = np.zeros(8), np.zeros(3)
        p = np.zeros(len(functions["PARAMETERS"]) + len(functions["CONSTANTS"]))
        functions["constants"](p)
        assert functions["accelerations"](0.0, q, s.v, p, np.zeros(0, int), a, lam) == 0, size


def test_place_of_a_contact_may_be_driven() -> None:
    model, first, second = two_bodies()
    roll = model.point_follower("roll", first.circle(1.0), second)
    model.driver("run", roll.alpha, 2 * t)
    machine = Interpreted(model)
    assert machine.lowered.description.reactions[-1] == ("run", "torque", "N m")
    assert machine.vector("velocity_rhs", machine.state(1))[-1] == 2.0


@pytest.mark.parametrize("size", [1e160, 1e300])
def test_a_profile_of_any_size_is_searched_without_a_warning(size: float) -> None:
    model = Model("huge")
    cam, other = (model.body(name, mass=1.0, inertia=1.0) for name in ("cam", "other"))
    model.point_follower("pin", cam.circle(size), other)
    model.cam_flat_follower("flat", cam.circle(size), other)
    model.cam_follower("disc", cam.circle(size), other.circle(size))
    places = dict(model.scene("run").guess)
    assert places.keys() == {"pin.alpha", "flat.alpha", "disc.alpha", "disc.beta"}


def enveloped(lift: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    """The profile on which a flat face has the lift, a function of the angle of its normal."""
    slope = lift.diff(alpha)
    x, y = sympy.cos(alpha), sympy.sin(alpha)
    return lift * x - slope * y, lift * y + slope * x


def c_shape() -> list[tuple[float, float]]:
    """A band of 10 mm round half a circle of 25 mm and more, with a mouth of 23.8 mm."""
    end, width, mean = 2.4, 0.005, 0.025
    arc, cap = np.linspace(-end, end, 60), np.linspace(0, np.pi, 12)[1:-1]
    tips = [mean * np.exp(1j * a) for a in (end, -end)]
    ends = [np.exp(1j * (end + cap)), np.exp(1j * (np.pi - end + cap))]
    caps = [tip + width * way for tip, way in zip(tips, ends, strict=True)]
    outer, inner = ((mean + s * width) * np.exp(1j * arc[::s]) for s in (1, -1))
    return [(float(z.real), float(z.imag)) for z in (*outer, *caps[0], *inner, *caps[1])]


WAVES = 0.05 + 0.004 * sympy.cos(4 * alpha)
CUTS = {
    # radius of the hollows 117.6 mm
    "hollow": (lambda m, cam: cam.polar(WAVES), 0.118, r"radius 0\.118 m, .* hollows is 0\.1176 m"),
    "fits": (lambda m, cam: cam.polar(WAVES), 0.117, ""),
    "mouth": (
        lambda m, cam: m.curve_through("c", cam, c_shape()),
        0.012,
        r"cuts 0\.0002\d+ m deep",
    ),
    "passes": (lambda m, cam: m.curve_through("c", cam, c_shape()), 0.0118, ""),
}


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("case", CUTS)
def test_a_roller_that_cuts_into_its_cam_is_refused(case: str, swapped: bool) -> None:
    """Also where the tangent point is free, and the roller is in the profile elsewhere."""
    profile, radius, expected = CUTS[case]
    model, cam, follower = two_bodies()
    curves = profile(model, cam), follower.circle(radius)
    model.cam_follower("roll", *(curves[::-1] if swapped else curves))
    model.driver("turn", cam.phi, t)
    if not expected:
        valid_scenes(model, None)
        return
    with pytest.raises(ModelError, match=f"curve of 'roll' on body 'first': .*{expected}"):
        valid_scenes(model, None)


@pytest.mark.parametrize("inside", [False, True])
def test_which_radius_counts_depends_on_the_side_of_the_contact(inside: bool) -> None:
    """Inside a ring it is that of the lobes, 24.7 mm, at which the roller is hollowed round."""
    model, cam, roller = two_bodies()
    roll = model.cam_follower("roll", cam.polar(WAVES), roller.circle(0.03))
    model.driver("turn", cam.phi, t)
    guess = {roll.alpha: 0.0, roll.beta: 0.0} if inside else {}
    model.scene("run", drivers=["turn"], guess=guess)
    if not inside:
        valid_scenes(model, None)
        return
    with pytest.raises(ModelError, match=r"radius 0\.03 m, .* at α = .* hollows is 0\.02471 m"):
        valid_scenes(model, None)


@pytest.mark.parametrize("share", [0.98, 1.02, 1.9])
def test_the_radius_of_curvature_under_a_flat_face_stays_positive(share: float) -> None:
    """With the lift R + h cos 3θ it is R - 8 h cos 3θ: one that vanishes is no cusp at a sample."""
    model, cam, follower = two_bodies()
    x, y = enveloped(0.05 + share * 0.05 / 8 * sympy.cos(3 * alpha))
    model.cam_flat_follower("lift", cam.curve(x, y), follower)
    if share < 1.0:
        valid_scenes(model, None)
        return
    with pytest.raises(ModelError, match=r"at α = .* turns by 180°; .* undercut"):
        valid_scenes(model, None)
