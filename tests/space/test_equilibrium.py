"""Rest positions of machines in space, against closed forms and minimisers of one's own."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from codegen import Model
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.statics.equilibrium import METHODS, Stability
from runtime.sweeps.sweep import sweep
from tests.space.machines import DOWN, X, Z

G = 9.81


def pendulum() -> Model:
    model = Model("spherical_pendulum", space=True, gravity=DOWN)
    moments = (0.3, 0.5, 0.4)
    bob = model.body("bob", 2.0, moments, at=(0.3, 0.1, -0.4), axes=(0.4, -0.2, 0.3))
    model.spherical("O", model.ground, bob, at=(0, 0, 0))
    model.scene("hang", ["gravity"])
    return model


@pytest.mark.parametrize("method", METHODS)
def test_a_spherical_pendulum_hangs_and_may_turn(method: str, workshop: Path) -> None:
    """K = m g l (1 - u uᵀ) and the inertia about the pivot, in body axes; u is along the arm."""
    rest = load(pendulum(), folder=workshop).equilibrium(method=method, progress=False)
    length = np.sqrt(0.26)
    assert rest.outcome is Outcome.OK
    assert rest.stability is Stability.INDIFFERENT
    assert rest.message.startswith("Indifferent: it stays where a small push leaves bob. ")
    assert_allclose([rest[f"bob.{c}"] for c in "xyz"], [0, 0, -length], rtol=0.0, atol=1e-12)
    assert_allclose([rest[f"O.f{c}"] for c in "xyz"], [0, 0, 2 * G], rtol=0.0, atol=1e-10)
    drawn = Rotation.from_rotvec([0.4, -0.2, 0.3]).as_matrix()
    u = drawn.T @ [0.3, 0.1, -0.4] / length
    away = np.eye(3) - np.outer(u, u)
    about = np.diag([0.3, 0.5, 0.4]) + 2.0 * length**2 * away
    expected = eigh(2.0 * G * length * away, about, eigvals_only=True)
    assert_allclose(rest.eigenvalues, expected, rtol=1e-7, atol=1e-8)
    assert_allclose(rest.natural_frequencies, np.sqrt(expected[1:]), rtol=1e-7)


def test_an_upright_top_is_unstable_and_falls(workshop: Path) -> None:
    model = Model("standing_top", space=True, gravity=DOWN)
    top = model.body("top", 2.0, (0.3, 0.3, 0.1), at=Z)
    model.spherical("O", model.ground, top, at=(0, 0, 0))
    model.scene("stand", ["gravity"])
    machine = load(model, folder=workshop)
    rest = machine.equilibrium(progress=False)
    assert rest.stability is Stability.UNSTABLE
    assert_allclose(rest.eigenvalues, [-2 * G / 2.3, -2 * G / 2.3, 0.0], rtol=1e-7, atol=1e-9)
    hanging = machine.equilibrium(method="settling", progress=False)
    assert hanging.stability is Stability.INDIFFERENT
    assert hanging["top.z"] == pytest.approx(-1.0, abs=1e-12)


CORNERS = ((0.5, 0.0), (-0.3, 0.4), (-0.2, -0.5))
SPRINGS = (50.0, 60.0, 70.0)


def plate() -> Model:
    model = Model("plate", space=True, gravity=DOWN)
    plate = model.body("plate", 3.0, (0.2, 0.3, 0.5), at=(0, 0, -1))
    mass = model.parameter("load", 0.0, "kg")
    for k, ((x, y), stiffness) in enumerate(zip(CORNERS, SPRINGS, strict=True)):
        ends = model.ground.at(1.2 * x, y, 0), plate.at(x, y, 0.05)
        model.spring(f"s{k}", *ends, stiffness=stiffness, free_length=0.7)
    model.force("extra", plate.at(0.1, 0.2, 0), (0, 0, -G * mass))
    model.scene("hang", ["gravity", "s0", "s1", "s2", "extra"])
    return model


def least_energy(load: float) -> tuple[Any, Any]:
    """The place and the attitude of the plate of least energy, by rotation vectors."""

    def energy(x: Any) -> float:
        turn = Rotation.from_rotvec(x[3:])
        held = x[:3] + turn.apply([(a, b, 0.05) for a, b in CORNERS])
        lengths = np.linalg.norm(held - [(1.2 * a, b, 0.0) for a, b in CORNERS], axis=1)
        point = x[:3] + turn.apply([0.1, 0.2, 0.0])
        springs = float(np.sum(0.5 * np.array(SPRINGS) * (lengths - 0.7) ** 2))
        return springs + 3.0 * G * x[2] + load * G * point[2]

    found = minimize(energy, [0, 0, -1, 0, 0, 0.0], method="BFGS", options={"gtol": 1e-10})
    found = minimize(energy, found.x, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 0.0})
    return found.x[:3], Rotation.from_rotvec(found.x[3:]).as_matrix()


@pytest.mark.parametrize("method", METHODS)
def test_a_plate_hangs_where_its_energy_is_least(method: str, workshop: Path) -> None:
    machine = load(plate(), folder=workshop)
    rest = machine.equilibrium(method=method, parameters={"load": 0.5}, progress=False)
    place, turned = least_energy(0.5)
    assert rest.stability is Stability.STABLE
    assert_allclose([rest[f"plate.{c}"] for c in "xyz"], place, rtol=0.0, atol=3e-8)
    assert_allclose(rest.rotation("plate")[0], turned, rtol=0.0, atol=3e-8)


def test_rest_positions_in_a_sweep(tmp_path: Path, workshop: Path) -> None:
    machine, loads = load(plate(), folder=workshop), [0.0, 0.5]
    study = sweep(
        plate(), over={"load": loads}, quantities=["plate.z"], analysis="equilibrium", workers=0,
        out=tmp_path / "study.zarr", folder=workshop, progress=False,
    )  # fmt: skip
    places = [machine.equilibrium(parameters={"load": one})["plate.z"] for one in loads]
    assert_allclose(study["plate.z"].values, places, rtol=1e-12)


def hanging_rods() -> Model:
    """Two rods with ball joints at their ends, and a spring at the last end."""
    model = Model("hanging_rods", space=True, gravity=DOWN)
    moment = model.parameter("J", 1e-3, "kg m^2")
    axes, along = ((0.9, 0, 0.3), (0.06, -1, -0.2)), np.array([0.31, 0.2, -0.93])
    rods, last = [], model.ground.at(0, 0, 0)
    for k, mass in enumerate((2.0, 1.0)):
        at = tuple((k + 0.5) * along)
        rods.append(model.body(f"rod{k}", mass, (0.3, 0.3, moment), at=at, axes=axes))
        model.spherical(f"S{k}", last, rods[k].at(0, 0, -0.5))
        last = rods[k].at(0, 0, 0.5)
    model.spring("k", model.ground.at(0.4, 0.1, -0.7), last, stiffness=30.0, free_length=0.5)
    model.scene("hang", ["gravity", "k"])
    return model


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("moment", [0.1, 1e-6])
def test_rods_that_may_turn_about_themselves_are_named(
    moment: float, method: str, workshop: Path
) -> None:
    machine = load(hanging_rods(), folder=workshop)
    rest = machine.equilibrium(method=method, parameters={"J": moment}, progress=False)
    assert rest.stability is Stability.INDIFFERENT
    assert "leaves rod0, rod1. " in rest.message
    assert len(rest.natural_frequencies) == 4


def test_a_tripod_carries_its_load(workshop: Path) -> None:
    """Legs of 0.6 kg with ball joints at both ends, feet on a circle of 0.8 m, 1.1 m below."""
    model = Model("tripod", space=True, gravity=DOWN)
    load_ = model.body("load", 5.0, (0.2, 0.2, 0.1), at=(0.2, 0.1, 0.8))
    feet = [(0.8 * np.cos(a), 0.8 * np.sin(a), 0.0) for a in 2 * np.pi / 3 * np.arange(3)]
    for k, (x, y, _) in enumerate(feet):
        down = (-x, -y, 1.1)
        leg = model.body(
            f"leg{k}", 0.6, (0.1, 0.1, 0.001), at=(x / 2, y / 2, 0.55), axes=((-y, x, 0), down)
        )
        model.spherical(f"foot{k}", model.ground, leg, at=(x, y, 0))
        model.spherical(f"head{k}", leg, load_, at=(0, 0, 1.1))
    model.scene("stand", ["gravity"])
    rest = load(model, folder=workshop).equilibrium(progress=False)
    assert rest.stability is Stability.INDIFFERENT
    assert "leaves load, leg0, leg1, leg2. " in rest.message
    up = (5.0 + 1.8) * G / 3
    inwards = 0.8 * (up - 0.3 * G) / 1.1  # moments of a leg about its head
    for k, foot in enumerate(feet):
        expected = [*(-inwards * np.array(foot[:2]) / 0.8), up]
        found = [rest[f"foot{k}.f{c}"] for c in "xyz"]
        assert_allclose(found, expected, rtol=0.0, atol=1e-9)
    apart = np.sqrt(0.2**2 + 0.1**2 + 0.3**2)
    assert rest["load.z"] == pytest.approx(1.1 - apart, abs=1e-12)


@pytest.mark.parametrize(("speed", "height"), [(10.2959, 0.046667), (10.7121, 0.048571)])
def test_a_governor_at_a_given_spin(speed: float, height: float, workshop: Path) -> None:
    """Haug 12.6, its spindle at rest in axes that turn with it: the balls' centrifugal potential.

    Expected are heights and speeds by virtual work; the balls are as hard to turn about any axis.
    """
    model = Model("governor", space=True, gravity=(0, -G, 0))
    collar = model.body("collar", 1.0, (0.15, 0.125, 0.15), at=(0, 0.05, 0))
    spin = model.parameter("spin", 10.0, "rad/s")
    model.translational("slide", model.ground, collar, at=(0, 0.05, 0), axis=(0, 1, 0))
    arm = 0.16 / np.sqrt(2)
    for k, side in enumerate((1, -1)):
        ball = model.body(f"ball{k}", 1.0, (0.1, 0.1, 0.1), at=(side * arm, 0.2 - arm, 0))
        model.revolute(f"R{k}", model.ground, ball, at=(0, 0.2, 0), axis=Z)
        model.distance(f"D{k}", ball.at(-side * arm / 2, arm / 2, 0), collar, 0.10922)
        model.potential(f"whirl{k}", -0.5 * 1.0 * spin**2 * (ball.x**2 + ball.z**2))
    top = model.ground.at(0, 0.2, 0)
    model.spring("s", top, collar, stiffness=1000.0, free_length=0.15, damping=30.0)
    model.scene("turn", ["gravity", "s", "whirl0", "whirl1"])
    machine = load(model, folder=workshop)
    rest = machine.equilibrium(parameters={"spin": speed}, progress=False)
    assert rest.stability is Stability.STABLE
    assert rest["collar.y"] == pytest.approx(height, abs=2e-6)


def test_a_body_that_nothing_holds_runs_away(workshop: Path) -> None:
    model = Model("falling", space=True, gravity=DOWN)
    model.body("stone", 1.0, (0.1, 0.2, 0.2))
    model.scene("fall", ["gravity"])
    rest = load(model, folder=workshop).equilibrium(progress=False)
    assert rest.outcome is Outcome.UNBALANCED
    assert "nothing holds the machine in stone.z, which ran away without end" in rest.message


def test_states_rest_with_the_position(workshop: Path) -> None:
    """A force that grows until the body has its height."""
    model = Model("levitated", space=True, gravity=DOWN)
    bob = model.body("bob", 2.0, (0.3, 0.3, 0.1), at=(0, 0, -1), axes=(0.1, 0.2, 0.0))
    model.cylindrical("guide", model.ground, bob, at=(0, 0, -1), axis=Z)
    pull = model.state("pull", 40.0 * (-0.7 - bob.z), start=1.0, unit="N")
    model.force("lift", bob, (0, 0, pull))
    model.scene("rest", ["gravity", "lift"])
    rest = load(model, folder=workshop).equilibrium(progress=False)
    assert rest.outcome is Outcome.OK
    assert rest["bob.z"] == pytest.approx(-0.7, abs=1e-9)
    assert rest["pull"] == pytest.approx(2.0 * G, rel=1e-9)


def test_a_spring_loaded_slider_crank_of_axes_apart(workshop: Path) -> None:
    """One freedom: the crank's angle of least energy by a search along closed forms."""
    model = Model("sprung_crank", space=True, gravity=DOWN)
    crank = model.body("crank", 0.12, (1e-4, 1e-5, 1e-4), at=(0, 0.1, 0.12), axes=(1.2, 0, 0))
    slider = model.body("slider", 2.0, (1e-4,) * 3, at=(0.2, 0, 0))
    model.revolute("A", model.ground, crank, at=(0, 0.1, 0.12), axis=X)
    model.distance("rod", crank.at(0, 0.08, 0), slider, 0.3)
    model.translational("guide", model.ground, slider, at=(0.2, 0, 0), axis=X)
    model.spring("s", model.ground.at(0.6, 0, 0), slider, stiffness=80.0, free_length=0.3)
    load_ = crank.at(0, 0.08, 0)
    model.force("weight", load_, (0, 0, -5.0))
    model.scene("rest", ["gravity", "s", "weight"])
    rest = load(model, folder=workshop).equilibrium(progress=False)

    def energy(angle: float) -> float:
        pin = np.array([0, 0.1 + 0.08 * np.cos(angle), 0.12 + 0.08 * np.sin(angle)])
        x = np.sqrt(0.09 - pin[1] ** 2 - pin[2] ** 2)
        return float(40.0 * (0.3 - x) ** 2 + 5.0 * pin[2])

    found = minimize(lambda a: energy(a[0]), [1.2], method="Nelder-Mead",
                     options={"xatol": 1e-9, "fatol": 0.0})  # fmt: skip
    turned = rest.rotation("crank")[0] @ [0, 1, 0]
    assert_allclose(turned, [0, np.cos(found.x[0]), np.sin(found.x[0])], rtol=0.0, atol=3e-7)
    assert rest.stability is Stability.STABLE
    assert rest["A.fz"] + rest["guide.fz"] == pytest.approx(2.12 * G + 5.0, rel=1e-9)
    stretch = 0.6 - rest["slider.x"] - 0.3
    assert abs(rest["A.fx"]) == pytest.approx(80.0 * stretch, rel=1e-9)
