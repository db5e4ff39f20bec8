"""Friction in joints in space: dense equations, closed forms, the plane, and what is refused."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import sin

from codegen import Model, t
from codegen.derive.effect_terms import effect_terms
from codegen.driver import build
from codegen.elements.space.friction import JointFrictionInSpace
from codegen.errors import ModelError
from runtime import load
from tests.random_mechanisms import spatial_parts as parts
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_generator import OTHER, RandomSpatialMechanism
from tests.random_mechanisms.spatial_loops import Drawing
from tests.random_mechanisms.spatial_statics import MET, Statics
from tests.space.machines import DOWN, Z

G = 9.81
LAWS = {
    "R1": {"radius": 0.1, "length": 0.6, "collar": 0.2},
    "T2": {"radius": 0.15, "length": 0.8},
    "C3": {"radius": 0.2, "length": 0.7},
}


@pytest.mark.parametrize("rubbing", [("R1",), ("T2",), ("C3",), ("R1", "T2", "C3")])
def test_accelerations_and_reactions_agree_with_newton_and_euler(rubbing: tuple[str, ...]) -> None:
    """A chain of a hinge, a guide and a shaft on oblique axes."""
    to = Drawing(np.random.default_rng(7))
    to.join("R", parts.GROUND, to.body((0.3, 0.1, 0.2)), (0.0, 0.0, 0.0))
    for k, letter in enumerate("TC"):
        at = to.near(to.place(k), 0.5)
        to.join(letter, k, to.body(to.near(at, 0.6)), at)
    laws = tuple(parts.Friction(f"rub{n}", n, 0.15, 0.3, **LAWS[n]) for n in rubbing)
    forces = (parts.Gravity("gravity"), *laws)
    mechanism = parts.SpatialMechanism(tuple(to.bodies), tuple(to.joints), forces)
    dense = SpatialDense(mechanism)
    state = dense.random_velocity(2)
    machine = RandomSpatialMechanism(0, OTHER, "free", (), mechanism, state, 4, 0, 0.1)
    statics = Statics(machine)
    for seed in range(4):
        assert statics.difference(dense.random_velocity(seed), 0.0) < MET


ANGLE, MU, STATIC = 0.3, 0.2, 0.35


@pytest.fixture(scope="module")
def incline(workshop: Path) -> Any:
    """A block on an incline, in an oblique frame, that a given force pulls along."""
    model: Any = Model("incline", space=True, gravity=DOWN)
    block = model.body("block", 2.0, (0.1, 0.2, 0.25), axes=(0.3, 0.2, 0.1))
    axis = (np.cos(ANGLE), 0, -np.sin(ANGLE))
    guide = model.translational("guide", model.ground, block, at=(0, 0, 0), axis=axis)
    model.friction("rub", guide, model.parameter("mu", MU), static=model.parameter("mu_s", STATIC))
    pull = [a * (12 * sin(3 * t) - 6) for a in axis]
    model.force("pull", block, tuple(pull))
    model.scene("slide", ["gravity", "rub"])
    model.scene("pulled", ["gravity", "rub", "pull"])
    return load(model, folder=workshop), load(model, "pulled", folder=workshop)


def test_a_block_slides_up_and_sticks_or_slides_down(incline: Any) -> None:
    """a = -g (sin α ± μ cos α); it stays where tan α < μ_s."""
    machine, _ = incline
    down = G * (np.sin(ANGLE) + MU * np.cos(ANGLE))
    stop = 1.0 / down
    for static, word in ((STATIC, "sticks"), (0.25, "reverses")):
        result = machine.simulate(
            1.0, 21, start={"guide.speed": -1.0}, parameters={"mu_s": static}, rtol=1e-10,
            progress=False,
        )  # fmt: skip
        (event,) = result.events
        assert event.word == word
        assert event.time == pytest.approx(stop, rel=1e-10)
        after = 0.5 * G * (np.sin(ANGLE) - MU * np.cos(ANGLE)) * (1.0 - stop) ** 2
        end = -stop / 2 + (after if word == "reverses" else 0.0)
        assert result.q("guide.slide")[-1] == pytest.approx(end, rel=1e-9)
        pressing, along = 2 * G * np.cos(ANGLE), 2 * G * np.sin(ANGLE)
        assert_allclose(result.reaction("rub", "normal"), pressing, rtol=1e-10)
        assert_allclose(result.reaction("rub", "limit"), static * pressing, rtol=1e-10)
        force = result.reaction("rub", "force")[-1]
        assert force == pytest.approx(-along if word == "sticks" else -MU * pressing, rel=1e-9)


def test_a_block_that_is_pulled_breaks_loose_and_sticks_as_in_the_plane(
    incline: Any, workshop: Path
) -> None:
    model: Any = Model("flat_incline", gravity=(0, -G))
    block, axis = model.body("block", 2.0, 0.1), (np.cos(ANGLE), -np.sin(ANGLE))
    guide = model.translational("guide", model.ground, block, axis=axis, angle=0)
    model.friction("rub", guide, MU, static=STATIC)
    model.force(
        "pull", block, fx=axis[0] * (12 * sin(3 * t) - 6), fy=axis[1] * (12 * sin(3 * t) - 6)
    )
    model.scene("pulled", ["gravity", "rub", "pull"])
    words = {"rtol": 1e-10, "progress": False}
    flat = load(model, folder=workshop).simulate(3.0, 31, **words)
    found = incline[1].simulate(3.0, 31, **words)
    assert [e.word for e in found.events] == [e.word for e in flat.events]
    assert len(found.events) >= 2
    times = [[e.time for e in one.events] for one in (found, flat)]
    assert_allclose(*times, rtol=1e-9)
    assert_allclose(found.q("block.x"), flat.q("block.x"), rtol=0.0, atol=1e-9)
    assert_allclose(found["rub.force"], flat["rub.force"], rtol=0.0, atol=1e-7)


def test_a_flywheel_on_an_oblique_axis_runs_down(workshop: Path) -> None:
    """The pin bears m g sin β and the collar m g cos β: J ω̇ = -μ m g (R sin β + R_h cos β)."""
    model: Any = Model("oblique_flywheel", space=True, gravity=DOWN)
    tilt, radius, collar = 0.7, 0.05, 0.08
    axis = (np.sin(tilt), 0, np.cos(tilt))
    wheel = model.body("wheel", 5.0, (0.3, 0.3, 0.5), axes=(0, tilt, 0))
    axle = model.revolute("axle", model.ground, wheel, at=(0, 0, 0), axis=axis)
    model.friction("rub", axle, 0.2, radius=radius, collar=collar)
    model.dry_friction("brake", slip=0.3 * axle.rate, normal=10.0, coefficient=0.4)
    model.scene("run_down", ["gravity", "rub", "brake"], start={"axle.rate": 3.0})
    result = load(model, folder=workshop).simulate(1.0, 21, rtol=1e-10, progress=False)
    torque = 0.2 * 5 * G * (radius * np.sin(tilt) + collar * np.cos(tilt))
    slowing = (torque + 0.3 * 0.4 * 10.0) / 0.5
    stop = 3.0 / slowing
    assert stop < 1.0
    assert result.events[0].time == pytest.approx(stop, rel=1e-9)
    moving = result.t < stop
    rate = 3.0 - slowing * result.t[moving]
    assert_allclose(result.v("axle.rate")[moving], rate, rtol=0.0, atol=1e-9)
    assert_allclose(result.v("axle.rate")[~moving], 0.0, rtol=0.0, atol=1e-12)
    assert_allclose(result.reaction("rub", "torque")[moving], -torque, rtol=1e-9)
    assert result.q("axle.angle")[-1] == pytest.approx(3.0 * stop / 2, rel=1e-9)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_ring_that_turns_and_slides_on_a_rod_slows_down_on_a_straight_line(
    method: str, workshop: Path
) -> None:
    """With J = m R² the slip v keeps its direction: F(|v|) falls by μ g t, F' = √(v² + c²)/v."""
    model: Any = Model("ring_on_rod", space=True, gravity=DOWN)
    radius, mass, creep, mu = 0.2, 2.0, 0.05, 0.3
    about = mass * radius**2
    ring = model.body("ring", mass, (about, about, about))
    rod = model.cylindrical("rod", model.ground, ring, at=(0, 0, 0), axis=(0, 1, 0))
    model.friction("rub", rod, mu, creep, radius)
    outputs = ["default", "rod.angle", "rod.slide", "rate(rub)"]
    start = {"rod.speed": 0.6, "rod.rate": 0.8 / radius}
    model.scene("run", ["gravity", "rub"], start=start, outputs=outputs)
    result = load(model, folder=workshop).simulate(
        0.5, 26, method=method, rtol=1e-9, progress=False
    )
    speed, rim = result.v("rod.speed"), radius * result.v("rod.rate")
    assert_allclose(rim * 0.6, speed * 0.8, rtol=0.0, atol=1e-7)
    size = np.hypot(speed, rim)
    root = np.hypot(size, creep)
    fallen = root + creep * np.log(size / (creep + root))
    assert size[-1] < 0.02
    assert_allclose(fallen[0] - fallen, mu * G * result.t, rtol=0.0, atol=1e-6)
    assert_allclose(result.reaction("rub", "force"), -mu * mass * G, rtol=1e-9)
    power = -mu * mass * G * size**2 / root
    assert_allclose(result.power("rub"), power, rtol=0.0, atol=1e-6)
    assert_allclose(result["rub.rate.angle"], result.v("rod.rate"), rtol=0.0, atol=1e-12)


def joined() -> Any:
    model: Any = Model("joined", space=True)
    a, b, c = (model.body(n, 1.0, (1, 1, 1), at=(k, 0, 0)) for k, n in enumerate("abc"))
    model.revolute("hinge", model.ground, a, at=(0, 0, 0), axis=Z)
    model.translational("guide", a, b, at=(1, 0, 0), axis=Z)
    model.cylindrical("shaft", b, c, at=(2, 0, 0), axis=Z)
    model.spherical("ball", model.ground, c, at=(2, 1, 0))
    return model


MISTAKES: dict[str, tuple[Callable[[Any, Any], Any], str]] = {
    "ball": (
        lambda m, j: m.friction("F", j["ball"], 0.1),
        ("friction in space 'F': 'ball' is no joint that rubs; give a revolute, a translational or "
        "a cylindrical joint."),
    ),
    "name": (
        lambda m, j: m.friction("F", "hinge", 0.1),
        ("'hinge' is no joint that rubs; give a revolute, a translational or a cylindrical joint "
        "itself, not its name."),
    ),
    "no pin": (
        lambda m, j: m.friction("F", j["hinge"], 0.1),
        "friction in space 'F': revolute joint 'hinge' needs radius=, its pin's, in m.",
    ),
    "shaft that sticks": (
        lambda m, j: m.friction("F", j["shaft"], 0.1, radius=0.1),
        ("friction in space 'F': cylindrical joint 'shaft' turns and slides, and does not stick; "
        "give creep=, in m/s."),
    ),
    "shaft whose fidelity is to stick": (
        lambda m, j: m.friction("F", j["shaft"], 0.1, 0.01, 0.1, fidelity="sticking"),
        "the fidelity 'sticking' needs a joint that only turns or only slides in its declaration.",
    ),
    "collar of a guide": (
        lambda m, j: m.friction("F", j["guide"], 0.1, collar=0.1),
        "translational joint 'guide' slides and has no thrust face; leave out collar=.",
    ),
    "static below kinetic": (
        lambda m, j: m.friction("F", j["guide"], 0.3, static=0.2),
        "the static coefficient 0.2 is below the kinetic one, 0.3; give one that is not,",
    ),
    "negative": (
        lambda m, j: m.friction("F", j["guide"], -0.3),
        "the coefficient of friction is -0.3; give a number that is not negative.",
    ),
    "no velocity": (
        lambda m, j: m.dry_friction("F", slip=j["guide"].slide, normal=1, coefficient=0.1),
        "is no velocity, for it contains none; write one,",
    ),
}  # fmt: skip


def test_a_slip_of_one_component_is_that_component(monkeypatch: pytest.MonkeyPatch) -> None:
    model: Any = Model("one_slip", space=True)
    hinge = model.revolute("hinge", model.ground, model.body("a", 1.0, (1, 1, 1)), at=Z, axis=Z)
    rub = model.friction("rub", hinge, 0.2, creep=0.1, radius=0.05)
    alone, law = effect_terms(rub, hinge.bodies), rub.friction()
    listed = replace(law, along=(law.along,))
    monkeypatch.setattr(JointFrictionInSpace, "friction", lambda of: listed)
    assert effect_terms(rub, hinge.bodies) == alone


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_told(case: str, tmp_path: Path) -> None:
    mistake, text = MISTAKES[case]
    model = joined()

    def declare_and_build() -> None:
        mistake(model, model.joints)
        model.scene("s", [*model.effects])
        build(model, out=tmp_path, compile=False)

    with pytest.raises(ModelError) as refusal:
        declare_and_build()
    assert text in str(refusal.value)
