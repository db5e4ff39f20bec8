"""Contacts in space by closed forms: balls, an inclined plane, a rod, rows of spheres, a box."""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from codegen import Model
from runtime import load
from tests.space.machines import DOWN, X, Z
from tests.space.rotations import matrix_g, rotation

G = 9.81
UP = np.array([0.0, 0.0, 1.0])
MOMENTS, TIP = np.array([0.3, 0.5, 0.4]), np.array([0.1, 0.2, -0.5])


def start_of(body: str, **values: float) -> dict[str, float]:
    return {f"{body}.{letter}": value for letter, value in values.items()}


def spins(result: Any, body: str) -> Any:
    """ω' at each sample, (k, 3)."""
    return np.column_stack([result[f"{body}.omega_{c}"] for c in "xyz"])


def velocities(result: Any, body: str) -> Any:
    return np.column_stack([result.v(f"{body}.v{c}") for c in "xyz"])


@pytest.fixture(scope="module")
def ball(workshop: Path) -> Any:
    model = Model("ball", space=True, gravity=DOWN)
    e = model.parameter("e", 0.5)
    body = model.body("ball", 2.0, (0.1, 0.2, 0.25), at=(0, 0, 1.25))
    model.contact("floor", gap=body.z, free_length=0.25, restitution=e)
    start = {"ball.vx": 0.3, "ball.omega_x": 1.0, "ball.omega_y": 2.0}
    model.scene("drop", ["gravity", "floor"], start=start)
    return load(model, folder=workshop)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_ball_bounces_and_rests_at_the_times_of_the_closed_form(ball: Any, method: str) -> None:
    result = ball.simulate(2.0, 201, method=method, rtol=1e-10, progress=False)
    fall = np.sqrt(2 / G)
    times = np.array([e.time for e in result.events])
    struck = times[: len(times) - 1]
    exact = fall * (1 + 2 * np.cumsum([0, *(0.5**k for k in range(1, len(struck)))]))
    assert len(struck) > 10
    assert [e.word for e in result.events][-1] == "rests"
    assert_allclose(struck, exact, rtol=1e-9)
    assert times[-1] == pytest.approx(3 * fall, rel=1e-9)
    first = (result.t > fall) & (result.t < 2 * fall)
    since = result.t[first] - fall
    height = 0.25 + 0.5 * G * fall * since - 0.5 * G * since**2
    assert_allclose(result.q("ball.z")[first], height, atol=1e-9)
    assert_allclose(result.reaction("floor", "force")[-1], 2 * G, rtol=1e-10)
    spin = spins(result, "ball")  # of a body that nothing turns, whatever it strikes
    moments = np.array([0.1, 0.2, 0.25])
    assert_allclose(np.sum(moments * spin**2, axis=1), 0.9, rtol=1e-8)
    assert_allclose(result.v("ball.vx"), 0.3, rtol=0.0, atol=1e-12)


def test_a_ball_without_loss_keeps_its_energy(ball: Any) -> None:
    result = ball.simulate(3.0, 31, parameters={"e": 1.0}, rtol=1e-10, progress=False)
    assert len(result.events) == 3
    assert_allclose(result.energy(), result.energy()[0], rtol=1e-9)


def test_a_body_slides_down_an_inclined_plane_until_it_is_lifted(workshop: Path) -> None:
    """At rest on the plane at the start; a force that grows lifts it where it exceeds the load."""
    from codegen import t

    model = Model("incline", space=True, gravity=DOWN)
    normal = np.array([0.0, -0.6, 0.8])
    place = tuple((0.5 * normal).tolist())
    sledge = model.body("sledge", 2.0, (0.1, 0.2, 0.25), at=place, axes=(0.4, 0.1, -0.3))
    ground = model.ground.at(0, 0, 0)
    model.contact("plane", ground, sledge, direction=(0, -3, 4), free_length=0.5, restitution=0.3)
    model.force("lift", sledge, tuple(8.0 * t * n for n in normal.tolist()))
    model.scene("slide", ["gravity", "plane", "lift"], start={"sledge.vx": 0.2})
    result = load(model, folder=workshop).simulate(2.5, 26, rtol=1e-10, progress=False)
    leaves = 2 * G * 0.8 / 8.0
    assert [e.word for e in result.events] == ["leaves"]
    assert result.events[0].time == pytest.approx(leaves, rel=1e-9)
    lies = result.t < leaves
    along = -0.5 * G * 0.6 * result.t[lies] ** 2 * np.array([[0.0], [0.8], [0.6]])
    for k, letter in enumerate("yz"):
        found = result.q(f"sledge.{letter}")[lies]
        assert_allclose(found, place[k + 1] + along[k + 1], rtol=0.0, atol=1e-9)
    load_there = np.clip(2 * G * 0.8 - 8.0 * result.t, 0.0, None)
    assert_allclose(result.reaction("plane", "force"), load_there, rtol=0.0, atol=1e-9)
    since = result.t[~lies] - leaves
    gap = sum(n * result.q(f"sledge.{c}")[~lies] for n, c in zip(normal, "xyz", strict=True)) - 0.5
    assert_allclose(gap, 8.0 * since**3 / 12, rtol=0.0, atol=1e-8)


@pytest.fixture(scope="module")
def rod(workshop: Path) -> Any:
    """A body whose tip falls on the floor."""
    model = Model("rod", space=True, gravity=DOWN)
    e = model.parameter("e", 0.7)
    body = model.body("rod", 2.0, MOMENTS.tolist(), at=(0, 0, 1), axes=(0.4, -0.3, 0.8))
    model.contact("floor", model.ground, body.at(*TIP), direction=(0, 0, 2), restitution=e)
    start = start_of("rod", vx=0.3, omega_x=1.0, omega_y=-0.7, omega_z=2.0)
    model.scene("drop", ["gravity", "floor"], start=start)
    return load(model, folder=workshop)


def test_a_rod_strikes_the_floor_with_one_end(rod: Any) -> None:
    """P = -(1 + e) ġ/(1/m + (s × n)ᵀ J⁻¹ (s × n)), Δv = P n/m, J Δω = s × P n."""
    hit = rod.simulate(0.5, 2, rtol=1e-12, progress=False).events[0]
    before = hit.time * (1 - 1e-12)
    flown = rod.simulate(before, 2, rtol=1e-12, progress=False)
    assert flown.events == ()
    speed, spin, turned = velocities(flown, "rod")[-1], spins(flown, "rod")[-1], hit.q[3:7]
    assert_allclose(rotation(turned), flown.rotation("rod")[-1], rtol=0.0, atol=1e-10)
    normal = rotation(turned).T @ UP  # in body axes
    arm = np.cross(TIP, normal)
    rate = UP @ speed + arm @ spin
    assert rate < -1.0
    assert hit.q[2] + TIP @ normal == pytest.approx(0.0, abs=1e-12)
    push = -1.7 * rate / (1 / 2.0 + arm @ (arm / MOMENTS))
    after = 2 * matrix_g(turned) @ hit.v[3:7]
    assert_allclose(hit.v[:3], speed + push / 2.0 * UP, rtol=0.0, atol=1e-9)
    assert_allclose(after, spin + push * arm / MOMENTS, rtol=0.0, atol=1e-9)
    assert turned @ hit.v[3:7] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_tip_that_rests_on_the_floor_keeps_energy_until_it_leaves(rod: Any, method: str) -> None:
    result = rod.simulate(
        2.0, 201, parameters={"e": 0.3}, method=method, rtol=1e-10, progress=False
    )  # fmt: skip
    rests, leaves = (next(e.time for e in result.events if e.word == word)
                     for word in ("rests", "leaves"))  # fmt: skip
    lies = (result.t > rests) & (result.t < leaves)
    assert lies.sum() > 40
    assert (result.reaction("floor", "force")[lies] > 0.0).all()
    height = result.q("rod.z") + result.rotation("rod")[:, 2] @ TIP
    assert_allclose(height[lies], 0.0, rtol=0.0, atol=1e-14)
    assert_allclose(result.energy()[lies], result.energy()[lies][0], rtol=1e-9)
    p = np.column_stack([result.q(f"rod.e{k}") for k in range(4)])
    assert_allclose(np.sum(p**2, axis=1), 1.0, rtol=1e-14)


@pytest.fixture(scope="module")
def spheres(workshop: Path) -> Any:
    """Three spheres of radius 0.1 m that nothing else holds."""
    model = Model("spheres", space=True)
    e = model.parameter("e", 1.0)
    made = [model.body(f"s{k}", 1.0, (0.004,) * 3, at=(0.3 * k, 0, 0)) for k in range(3)]
    for one, other in ((0, 1), (1, 2)):
        pair = made[one], made[other]
        model.contact(f"c{one}{other}", *pair, free_length=0.2, restitution=e)
    model.scene("roll", ["c01", "c12"])
    return load(model, folder=workshop)


@pytest.mark.parametrize(
    ("apart", "after"), [(1e-3, (0.0, 0.0, 1.0)), (0.0, (-1 / 3, 2 / 3, 2 / 3))]
)
def test_newtons_cradle(spheres: Any, apart: float, after: tuple[float, ...]) -> None:
    """One after the other the last sphere leaves; spheres that touch share by Newton's law."""
    start = {"s0.x": -0.5, "s1.x": 0.0, "s2.x": 0.2 + apart, "s0.vx": 1.0}
    result = spheres.simulate(1.0, 2, start=start, rtol=1e-11, progress=False)
    found = [result.v(f"s{k}.vx")[-1] for k in range(3)]
    assert_allclose(found, after, rtol=0.0, atol=1e-9)


def test_spheres_that_collide_obliquely_exchange_an_impulse_along_their_centres(
    spheres: Any,
) -> None:
    start = start_of("s0", vx=1.0, vy=0.2, omega_z=3.0) | start_of("s1", x=0.5, y=0.1, z=-0.07)
    start |= start_of("s1", vx=-0.5, vz=0.1) | start_of("s2", x=9.0)
    e = 0.6
    result = spheres.simulate(1.0, 2, start=start, parameters={"e": e}, rtol=1e-11, progress=False)
    (hit,) = result.events
    first, second = np.array([1.0, 0.2, 0.0]), np.array([-0.5, 0.0, 0.1])
    line = np.array([0.5, 0.1, -0.07]) + hit.time * (second - first)
    assert np.linalg.norm(line) == pytest.approx(0.2, rel=1e-9)
    line /= 0.2
    push = -0.5 * (1 + e) * (second - first) @ line * line
    assert_allclose(velocities(result, "s0")[-1], first - push, rtol=0.0, atol=1e-9)
    assert_allclose(velocities(result, "s1")[-1], second + push, rtol=0.0, atol=1e-9)
    assert_allclose(spins(result, "s0")[-1], 3.0 * UP, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_box_falls_on_four_corners_at_once(workshop: Path, e: float) -> None:
    """One of the four reactions is not determined; their sum is the weight."""
    model = Model("box", space=True, gravity=DOWN)
    box = model.body("box", 3.0, (0.2, 0.3, 0.4), at=(0, 0, 0.6))
    rebound = model.parameter("e", e)
    names = []
    for x, y in product((-0.3, 0.3), (-0.4, 0.4)):
        corner = box.at(x, y, -0.1)
        names.append(f"k{len(names)}")
        model.contact(names[-1], model.ground, corner, direction=Z, restitution=rebound)
    model.scene("drop", ["gravity", *names])
    machine = load(model, folder=workshop)
    result = machine.simulate(2.0, 21, parameters={"e": e}, rtol=1e-9, progress=False)
    assert result.outcome.name == "OK"
    assert_allclose(result.q("box.z")[-1], 0.1, rtol=0.0, atol=1e-10)
    assert_allclose(spins(result, "box"), 0.0, rtol=0.0, atol=1e-9)
    forces = np.array([result.reaction(name, "force")[-1] for name in names])
    assert (forces >= 0).all()
    assert forces.sum() == pytest.approx(3 * G, rel=1e-9)
    rests = np.sqrt(2 * 0.5 / G) * (1 + 2 * e / (1 - e))
    assert max(event.time for event in result.events) == pytest.approx(rests, rel=1e-8)


def test_a_yielding_plane_in_a_body_pushes_by_spring_and_damper(workshop: Path) -> None:
    """The plane lies across the x' axis of a heavy body; m ẍ = -k g - c ġ, a damped half wave."""
    model = Model("buffer", space=True)
    m, k, c = 0.5, 200.0, 4.0
    axes = (0.3, -0.2, 0.5)
    wall = model.body("wall", 1e12, (1e12,) * 3, axes=axes)
    ball = model.body("ball", m, (0.1,) * 3, at=(1, 0, 0))
    plane = wall.at(0.2, 0, 0)
    model.contact("buffer", plane, ball, direction=X, free_length=0.1, stiffness=k, damping=c)
    normal = Rotation.from_rotvec(axes).as_matrix()[:, 0]
    start = dict(zip(("ball.x", "ball.y", "ball.z"), (0.5 * normal).tolist(), strict=True))
    start |= dict(zip(("ball.vx", "ball.vy", "ball.vz"), (-2.0 * normal).tolist(), strict=True))
    model.scene("hit", ["buffer"], start=start)
    machine = load(model, folder=workshop)
    begin = 0.2 / 2.0
    w = np.sqrt(k / m - (c / (2 * m)) ** 2)
    instants = begin + np.linspace(0.0, np.pi / w, 7)
    times = np.array([0.0, *instants])
    result = machine.simulate(times[-1], times, rtol=1e-10, progress=False)
    since = instants - begin
    exact = -2.0 / w * np.exp(-c / (2 * m) * since) * np.sin(w * since)
    gap = sum(n * result.q(f"ball.{a}")[1:] for n, a in zip(normal, "xyz", strict=True)) - 0.3
    assert_allclose(gap, exact, rtol=0.0, atol=1e-9)
    assert result.events[0].time == pytest.approx(begin, rel=1e-10)


def test_a_ball_bounces_on_a_plane_that_yields(workshop: Path) -> None:
    """It touches for 2 (π - atan(v w / g)) / w, w = √(k/m), and leaves as fast."""
    model = Model("trampoline", space=True, gravity=DOWN)
    m, k, radius, fall = 0.5, 5000.0, 0.1, 0.3
    ball = model.body("ball", m, (0.002,) * 3, at=(0, 0, radius + fall))
    plane: dict[str, Any] = {"direction": Z, "free_length": radius, "may_pull": False}
    model.contact("floor", model.ground, ball, **plane, stiffness=k)
    start = {"ball.vx": 0.4, "ball.omega_z": 3.0}
    model.scene(
        "drop", ["gravity", "floor"], start=start, outputs=["default", "penetration(floor)"]
    )
    result = load(model, folder=workshop).simulate(1.0, 1001, rtol=1e-11, progress=False)
    w, v, down = np.sqrt(k / m), np.sqrt(2 * G * fall), np.sqrt(2 * fall / G)
    touching = 2 * (np.pi - np.arctan(v * w / G)) / w
    exact = down + np.cumsum([0.0, touching, 2 * v / G, touching])
    assert_allclose([e.time for e in result.events[:4]], exact[: len(result.events)], rtol=1e-9)
    assert len(result.events) >= 3
    assert_allclose(result.energy(), result.energy()[0], rtol=1e-9)
    deepest = G / w**2 + np.sqrt((G / w**2) ** 2 + (v / w) ** 2)
    depth = result["floor.penetration"]
    assert depth.max() == pytest.approx(deepest, rel=1e-3)
    assert_allclose(result["floor.force"], k * depth, rtol=0.0, atol=1e-8)
    assert_allclose(result.v("ball.vx"), 0.4, rtol=0.0, atol=1e-10)
    assert_allclose(spins(result, "ball")[:, 2], 3.0, rtol=0.0, atol=1e-10)


def test_spheres_that_yield_push_along_their_centres(workshop: Path) -> None:
    """Half a wave of √(k/μ) with the reduced mass μ exchanges the speeds along the centres."""
    model = Model("soft_spheres", space=True)
    masses, k = (1.0, 3.0), 2e4
    line = np.array([2.0, 1.0, -2.0]) / 3
    places = (np.zeros(3), 0.5 * line)
    one, other = (
        model.body(f"s{n}", mass, (0.01,) * 3, at=place.tolist())
        for n, (mass, place) in enumerate(zip(masses, places, strict=True))
    )
    model.contact("touch", one, other, free_length=0.3, stiffness=k)
    names = [f"s0.v{c}" for c in "xyz"]
    start = dict(zip(names, (2.0 * line).tolist(), strict=True)) | {"s1.omega_x": 1.0}
    model.scene("hit", ["touch"], start=start)
    result = load(model, folder=workshop).simulate(0.5, 6, rtol=1e-11, progress=False)
    reduced = masses[0] * masses[1] / sum(masses)
    begin = 0.2 / 2.0
    times = [event.time for event in result.events]
    assert_allclose(times, [begin, begin + np.pi / np.sqrt(k / reduced)], rtol=1e-9)
    after = [(masses[0] - masses[1]) / sum(masses) * 2.0, 2 * masses[0] / sum(masses) * 2.0]
    for name, speed in zip(("s0", "s1"), after, strict=True):
        assert_allclose(velocities(result, name)[-1], speed * line, rtol=0.0, atol=1e-9)
    assert_allclose(spins(result, "s1"), np.outer(np.ones(6), [1.0, 0, 0]), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("by_joint", [True, False])
@pytest.mark.parametrize("rigid", [True, False])
def test_stops_limit_a_slide(workshop: Path, rigid: bool, by_joint: bool) -> None:
    """Between stops that lose nothing a slider goes to and fro with a constant speed."""
    model = Model(f"stops_{rigid}_{by_joint}", space=True)
    axis = np.array([2.0, -1.0, 2.0]) / 3
    slider = model.body("slider", 2.0, (0.1, 0.2, 0.25), axes=(0.3, 0.1, 0.2))
    guide = model.translational("guide", model.ground, slider, at=(0, 0, 0), axis=axis.tolist())
    place = slider.at(0, 0, 0)
    slide = sum(a * x for a, x in zip(axis.tolist(), place.position, strict=True))
    how: dict[str, float] = {"restitution": 1.0} if rigid else {"stiffness": 2e4}
    model.stop("ends", guide if by_joint else slide, lower=-0.2, upper=0.5, **how)
    names = ("slider.vx", "slider.vy", "slider.vz")
    model.scene("run", ["ends"], start=dict(zip(names, axis.tolist(), strict=True)))
    result = load(model, folder=workshop).simulate(1.55, 32, rtol=1e-10, progress=False)
    period = 1.4 + (0.0 if rigid else 2 * np.pi / np.sqrt(1e4))  # two half waves beyond the ends
    phase = np.mod(result.t, period)
    found = sum(a * result.q(f"slider.{c}") for a, c in zip(axis, "xyz", strict=True))
    half = 0.5 * (period - 1.4)
    out, back = phase <= 0.5, (phase >= 0.5 + half) & (phase <= 1.2 + half)
    again = phase >= 1.2 + 2 * half
    assert out.sum() > 5
    assert back.sum() > 5
    assert_allclose(found[out], phase[out], rtol=0.0, atol=1e-8)
    assert_allclose(found[back], 1.0 + half - phase[back], rtol=0.0, atol=1e-8)
    assert_allclose(found[again], phase[again] - period, rtol=0.0, atol=1e-8)
    assert_allclose(result.energy(), result.energy()[0], rtol=1e-8)
