"""The dense equations in space against complex steps, closed forms and laws of conservation."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_constraints import Layout, SpatialState, law_rates
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_motion import motion
from tests.random_mechanisms.spatial_parts import GROUND, Law, SpatialBody, SpatialMechanism

G = 9.81
STEP = 1e-30
LAW = Law(0.3, 0.4, 0.2, 3.0, 0.5)


def diagonal(*moments: float) -> parts.Matrix:
    a, b, c = moments
    return ((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c))


def of_all_kinds() -> SpatialMechanism:
    """Three bodies under one joint and driver of each kind, closed nowhere but at the drawing."""
    random = np.random.default_rng(1)

    def point() -> Any:
        return tuple(random.normal(size=3))

    turns = Rotation.random(3, random_state=2).as_matrix()
    bodies = tuple(
        SpatialBody(f"b{k}", 1.0, diagonal(1, 1, 1), point(), turns[k]) for k in range(3)
    )
    joints = (
        parts.Spherical("spherical", 0, 1, point()),
        parts.Revolute("revolute", 1, 0, point(), point()),
        parts.Universal("universal", 1, 2, point(), (1.0, 1.0, 0.0), (1.0, -1.0, 3.0)),
        parts.Translational("translational", 2, GROUND, point(), point()),
        parts.Cylindrical("cylindrical", GROUND, 1, point(), point()),
        parts.Weld("weld", 0, 2, point()),
        parts.SphericalSpherical("link", 0, 2, point(), point()),
        parts.PointDriver("point", 1, point(), "y", LAW),
        parts.DistanceDriver("distance", 0, GROUND, point(), point(), LAW),
        parts.AngleDriver("angle", "revolute", LAW),
        parts.AngleDriver("other angle", "cylindrical", LAW),
        parts.SlideDriver("slide", "translational", LAW),
    )
    others = (
        parts.Planar("planar", 0, 1, point(), point()),
        parts.PointInPlane("in plane", 1, 2, point(), point()),
        parts.Strut("strut", GROUND, 2, point(), point()),
        parts.ParallelAxes("parallel", 2, 1, point(), point()),
        parts.Screw("screw", 0, GROUND, point(), point(), -0.7),
        parts.RevoluteSpherical("hinged link", 1, 0, point(), point(), point()),
        parts.RevoluteRevolute("other link", 2, 0, point(), point(), point()),
        parts.RevoluteCylindrical("sleeve", 1, 2, point(), point(), point()),
        parts.RevoluteTranslational("block", 0, 2, point(), point(), point()),
        parts.Gear("gear", "revolute", "cylindrical", -1.3),
        parts.Rack("rack", "revolute", "translational", 0.6),
    )
    return SpatialMechanism(bodies, (*joints, *others))


def stepped(state: SpatialState, r: Any, w: Any) -> SpatialState:
    """A state i STEP later, for accelerations r and w."""
    across = np.array([np.cross(x, np.eye(3)).T for x in state.w])
    h = 1j * STEP
    return SpatialState(
        state.r + h * state.v, state.R + h * across @ state.R, state.v + h * r, state.w + h * w,
        state.turned,
    )  # fmt: skip


def test_slopes_and_second_derivatives_agree_with_complex_steps() -> None:
    layout, random = Layout(of_all_kinds()), np.random.default_rng(3)
    assert len(layout.rows) == 23
    R = Rotation.random(3, random_state=4).as_matrix()
    r, v, w, rr, ww = random.normal(size=(5, 3, 3))
    state = SpatialState(r, R, v, w, np.zeros(3))
    exact, _ = layout.scalars(state)
    later, _ = layout.scalars(stepped(state, rr, ww))

    def rate(by: Any, v: Any, w: Any) -> Any:
        return np.einsum("kbx,bx->k", by[:, :-1], np.concatenate([v, w], axis=1))

    np.testing.assert_allclose(
        rate(exact.by, v, w), later.value.imag / STEP, rtol=1e-12, atol=1e-13
    )
    second = rate(later.by, v + 1j * STEP * rr, w + 1j * STEP * ww).imag / STEP
    np.testing.assert_allclose(
        rate(exact.by, rr, ww) + exact.second, second, rtol=1e-12, atol=1e-12
    )


def test_laws_agree_with_complex_steps() -> None:
    def value(t: complex) -> complex:
        swing = np.sin(LAW.frequency * t + LAW.phase) - np.sin(LAW.phase)
        return complex(LAW.offset + LAW.rate * t + LAW.amplitude * swing)

    found = law_rates(LAW, 0.7)
    assert found[0] == pytest.approx(value(0.7).real, rel=1e-15)
    assert found[1] == pytest.approx(value(0.7 + 1j * STEP).imag / STEP, rel=1e-14)
    rates = [law_rates(LAW, 0.7 + h)[1] for h in (-1e-4, 1e-4)]
    assert found[2] == pytest.approx((rates[1] - rates[0]) / 2e-4, rel=1e-6)


def at_speed(machine: SpatialMechanism, v: Any, w: Any) -> tuple[SpatialDense, SpatialState]:
    dense = SpatialDense(machine)
    return dense, replace(dense.at_drawing, v=np.array(v, float), w=np.array(w, float))


def test_a_body_in_flight_keeps_momentum_and_energy() -> None:
    body = SpatialBody("b", 2.0, ((3, 0.1, 0.2), (0.1, 2, -0.3), (0.2, -0.3, 1)))  # type: ignore[arg-type]
    dense, state = at_speed(SpatialMechanism((body,), ()), [[1, 2, 3]], [[1.0, 4.0, -2.0]])
    end = motion(dense, state, [0.0, 5.0])[-1]

    def spin(s: SpatialState) -> Any:
        return s.R[0] @ np.array(body.inertia) @ s.R[0].T @ s.w[0]

    np.testing.assert_allclose(end.r[0], [5, 10, 15], rtol=1e-12)
    np.testing.assert_allclose(spin(end), spin(state), rtol=1e-11, atol=1e-10)
    assert dense.energy(end) == pytest.approx(dense.energy(state), rel=1e-11)


def pendulum(length: float = 0.7) -> SpatialMechanism:
    """About a slanting axis, from a slanting drawing."""
    body = SpatialBody("bob", 1.3, diagonal(0.2, 0.2, 0.2), (length, 0.0, 0.0))
    joints = (parts.Revolute("A", GROUND, 0, (0, 0, 0), (0, 1, 0)),)
    return SpatialMechanism((body,), joints, (parts.Gravity("g", (0.0, 0.0, -G)),))


def test_a_pendulum_swings_and_bears_as_in_closed_form() -> None:
    machine, length, m, J = pendulum(), 0.7, 1.3, 0.2
    dense, state = at_speed(machine, [[0, 0, 0.0]], [[0, 0, 0.0]])
    J_A = J + m * length**2
    solved = dense.solve(state)
    alpha = m * G * length / J_A
    assert solved.w[0] == pytest.approx([0, alpha, 0], abs=1e-13)
    reaction = dense.reaction("A", state, solved)
    assert reaction.force == pytest.approx([0, 0, m * G - m * length * alpha], abs=1e-12)
    assert reaction.torque == pytest.approx([0, 0, 0], abs=1e-12)
    assert reaction.determined.all()
    # from rest at 90°, the energy at the angle φ below the horizontal
    end = motion(dense, state, [0.0, 1.7])[-1]
    exact = solve_ivp(
        lambda _, y: [y[1], alpha * np.cos(y[0])], (0, 1.7), [0, 0], method="DOP853", rtol=1e-13,
        atol=1e-14,
    ).y[:, -1]  # fmt: skip
    np.testing.assert_allclose(
        end.r[0], length * np.array([np.cos(exact[0]), 0, -np.sin(exact[0])]), atol=1e-10
    )
    assert end.w[0] == pytest.approx([0, exact[1], 0], abs=1e-9)


def test_a_planar_double_pendulum_agrees_with_its_reference(root: Any) -> None:
    rows = np.loadtxt(root / "tests/data/double_pendulum.csv", delimiter=",", skiprows=1)
    angles, slim = rows[0, 1:3], diagonal(1e-3, 1 / 12, 1 / 12)

    def direction(angle: float) -> Any:
        return np.array([np.cos(angle), np.sin(angle), 0.0])

    def turned(angle: float) -> Any:
        return Rotation.from_rotvec([0, 0, angle]).as_matrix()

    knee = direction(angles[0])
    bodies = (
        SpatialBody("upper", 1.0, slim, tuple(0.5 * knee), turned(angles[0])),
        SpatialBody(
            "lower", 1.0, slim, tuple(knee + 0.5 * direction(angles[1])), turned(angles[1])
        ),
    )
    joints = (
        parts.Revolute("A", GROUND, 0, (0, 0, 0), (0, 0, 1)),
        parts.Revolute("B", 0, 1, tuple(knee), (0, 0, 1)),
    )
    dense = SpatialDense(SpatialMechanism(bodies, joints, (parts.Gravity("g", (0, -G, 0)),)))
    found = motion(dense, dense.at_drawing, rows[:5, 0].tolist())
    for state, (_, one, two, *rates) in zip(found, rows[:5], strict=True):
        np.testing.assert_allclose(state.r[0], 0.5 * direction(one), atol=1e-9)
        np.testing.assert_allclose(state.r[1], direction(one) + 0.5 * direction(two), atol=1e-9)
        np.testing.assert_allclose(state.w[:, 2], rates[:2], atol=1e-8)


def test_a_conical_pendulum_bears_its_weight_and_turns_steadily() -> None:
    """A ball on a distance: ω² = g / (l cos α)."""
    length, tilt = 0.9, 0.6
    place = length * np.array([np.sin(tilt), 0, -np.cos(tilt)])
    ball = SpatialBody("ball", 2.0, diagonal(1, 1, 1), tuple(place))
    machine = SpatialMechanism(
        (ball,), (parts.SphericalSpherical("string", GROUND, 0, (0, 0, 0), tuple(place)),),
        (parts.Gravity("g"),),
    )  # fmt: skip
    rate = np.sqrt(G / (length * np.cos(tilt)))
    speed = [0, rate * place[0], 0]
    dense, state = at_speed(machine, [speed], [[0.1, 0.2, 0.3]])
    solved = dense.solve(state)
    assert solved.r[0] == pytest.approx([-(rate**2) * place[0], 0, 0], abs=1e-12)
    pull = dense.reaction("string", state, solved).force
    assert pull == pytest.approx(-place / length * 2.0 * G / np.cos(tilt), rel=1e-12)
    end = motion(dense, state, [0.0, 2 * np.pi / rate])[-1]
    np.testing.assert_allclose(end.r[0], place, atol=1e-10)


def test_a_redundant_hinge_leaves_open_what_no_row_decides() -> None:
    """A door on two hinges of one axis: who bears the weight is open, the moments are not all."""
    door = SpatialBody("door", 10.0, diagonal(1, 1, 1), (0.5, 0.0, 0.0))
    joints = (
        parts.Revolute("low", GROUND, 0, (0, 0, -1), (0, 0, 1)),
        parts.Revolute("high", GROUND, 0, (0, 0, 1), (0, 0, 1)),
    )
    dense = SpatialDense(SpatialMechanism((door,), joints, (parts.Gravity("g"),)))
    assert dense.freedoms(dense.at_drawing) == (1, 5)
    solved = dense.solve(dense.at_drawing)
    low, high = (dense.reaction(n, dense.at_drawing, solved) for n in ("low", "high"))
    assert (low.force + high.force)[2] == pytest.approx(98.1)
    assert low.determined.tolist() == [False] * 5 + [True]


def test_effects_do_the_work_that_their_potentials_lose() -> None:
    """A spring off the centres, torsion through turns, a bushing, gravity: energy stays."""
    root = np.random.default_rng(3).normal(size=(6, 6))
    K = tuple(map(tuple, (root @ root.T + 200 * np.eye(6)).tolist()))
    none = ((0.0,) * 6,) * 6
    bodies = (
        SpatialBody("a", 1.0, diagonal(0.3, 0.2, 0.1), (0.5, 0, 0)),
        SpatialBody("b", 1.0, diagonal(0.2, 0.3, 0.1), (1.2, 0.3, 0)),
    )
    joints = (
        parts.Revolute("A", GROUND, 0, (0, 0, 0), (0.2, 1, 0.3)),
        parts.Cylindrical("B", 0, 1, (1, 0, 0), (1, 0.2, 0.4)),
    )
    effects = (
        parts.Gravity("g"),
        parts.Spring("s", 0, 1, (0.2, 0.5, 0), (1.5, 0.2, 0.4), 40.0, 0.8),
        parts.TorsionSpring("t", "A", 3.0, 8.0),
        parts.Bushing("r", 0, 1, (1.1, 0.1, 0.2), parts.IDENTITY, K, none, (1.0, -2.0, 3.0) * 2),
    )
    dense = SpatialDense(SpatialMechanism(bodies, joints, effects))
    state = dense.random_velocity(1)
    found = motion(dense, state, [0.0, 1.0, 2.0])
    energies = [dense.energy(s) for s in found]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-10)
    assert np.abs(dense.system(found[-1], 2.0).phi).max() < 1e-14
    assert max(abs(dense.angle("A", s)) for s in found) > np.pi  # it turned over


def test_drivers_drive_by_the_efforts_that_they_report() -> None:
    """The power of the driver is the rate of the energy."""
    law = Law(0.0, 1.5, 0.3, 4.0)
    machine = replace(pendulum(), joints=(*pendulum().joints, parts.AngleDriver("d", "A", law)))
    dense = SpatialDense(machine)
    found = motion(dense, dense.closed(dense.at_drawing, 0.0), [0.0, 5.0])
    state = found[-1]
    assert dense.angle("A", state) == pytest.approx(law(5.0), abs=1e-12)  # more than a turn
    _, rate, second = law_rates(law, 5.0)
    J_A, moment = 0.2 + 1.3 * 0.49, 1.3 * G * state.r[0, 0]
    solved = dense.solve(state, 5.0)
    assert dense.effort("d", solved) == pytest.approx(J_A * second - moment, rel=1e-11)
    assert dense.reaction("d", state, solved).torque[1] == pytest.approx(dense.effort("d", solved))
    assert state.w[0, 1] == pytest.approx(rate)
