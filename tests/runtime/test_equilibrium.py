"""Rest positions against exact answers, by both methods, judged and refused."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from codegen import Model, t
from codegen.errors import AnalysisError, InputError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.statics.rest_stability import Stability

BOOK = {"crank.phi": 4.6, "rod.x": 1.2, "rod.y": -1.0, "rod.phi": 0.6, "slider.x": 2.67}
METHODS = pytest.mark.parametrize("method", ["energy", "settling"])


@METHODS
def test_slider_crank_hangs_down(free: Machine, method: str) -> None:
    rest = free.equilibrium(method, guess=BOOK)
    assert rest.outcome is Outcome.OK
    assert rest.stability is Stability.STABLE
    assert rest["crank.phi"] == pytest.approx(1.5 * np.pi, abs=1e-12)
    assert rest["slider.x"] == pytest.approx(np.sqrt(3.5**2 - 4.0), abs=1e-12)
    assert rest.gradient < 1e-14
    assert rest.samples.residual.max() < 1e-14


@METHODS
def test_redundant_cranks_hang_alike(library: Callable[..., Machine], method: str) -> None:
    # From 60 degrees through the position in which the cranks lie flat, and each might turn over.
    rest = library("hard/parallel_linkage", "fall").equilibrium(method)
    for k in range(4):
        assert rest[f"crank_{k}.phi"] == pytest.approx(-0.5 * np.pi, abs=1e-7)
    assert rest.samples.residual.max() < 1e-9
    weight, inertia = 9.81 * (5.0 + 4 * 0.5), 5.0 + 4 * (1 / 12 + 1 / 4)
    assert rest.frequencies == pytest.approx([np.sqrt(weight / inertia) / (2.0 * np.pi)], rel=1e-6)


@METHODS
def test_pendulum_from_afar_and_its_frequency(pendulum: Machine, method: str) -> None:
    rest = pendulum.equilibrium(method, guess={"bar.phi": 1.2})
    assert ("bar turned by 159° from its guess; another" in rest.message) == (method == "energy")
    with pytest.raises(InputError, match=r"start: did you mean guess\?"):
        pendulum.equilibrium(start={"bar.phi": 1.2})  # type: ignore[call-arg]
    assert np.sin(rest["bar.phi"]) == pytest.approx(-1.0, abs=1e-14)
    assert rest.stable
    frequency = np.sqrt(2.0 * 9.81 / (0.5 + 2.0)) / (2.0 * np.pi)
    np.testing.assert_allclose(rest.frequencies, [frequency], rtol=1e-8)
    np.testing.assert_allclose(rest.natural_frequencies, [2.0 * np.pi * frequency], rtol=1e-8)
    np.testing.assert_allclose(rest.eigenvalues, rest.natural_frequencies**2, rtol=1e-12)
    # m g L in N m/rad of the angle; m g/L in N/m of the place, with L = 1 m
    np.testing.assert_allclose(rest.stiffness_matrix, [[2.0 * 9.81]], rtol=1e-7)
    assert rest.independent in {("bar.phi",), ("bar.x",)}
    assert rest.reaction("pin", "fy")[0] == pytest.approx(2.0 * 9.81, rel=1e-12)
    assert rest.reaction("pin", "fx")[0] == pytest.approx(0.0, abs=1e-9)


def test_upright_pendulum_is_told_to_be_unstable(pendulum: Machine) -> None:
    rest = pendulum.equilibrium(guess={"bar.phi": np.pi / 2})
    assert rest["bar.phi"] == pytest.approx(np.pi / 2, abs=1e-12)
    assert rest.stability is Stability.UNSTABLE
    assert not rest.stable
    assert rest.eigenvalues[0] == pytest.approx(-2.0 * 9.81 / 2.5, rel=1e-8)
    assert len(rest.natural_frequencies) == 0
    with pytest.raises(InputError, match="stiffness"):
        _ = rest.stiffness
    assert "small push drives it away" in rest.message


def test_settling_leaves_an_unstable_position(pendulum: Machine) -> None:
    rest = pendulum.equilibrium("settling", guess={"bar.phi": np.pi / 2})
    assert np.sin(rest["bar.phi"]) == pytest.approx(-1.0, abs=1e-14)


def test_no_gravity_no_preference(pendulum: Machine) -> None:
    rest = pendulum.equilibrium(parameters={"gy": 0.0})
    assert rest.stability is Stability.INDIFFERENT
    assert "stays where a small push leaves it" in rest.message


@METHODS
def test_force_without_potential_is_balanced(make: Callable[..., Machine], method: str) -> None:
    """A constant push on the slider against gravity: virtual work gives the crank's angle."""
    machine = make("pushed", "pushed")
    rest = machine.equilibrium(method, guess=BOOK, parameters={"push": -500.0})
    phi = rest["crank.phi"]
    root = np.sqrt(3.5**2 - 4.0 * np.sin(phi) ** 2)
    slope = -2.0 * np.sin(phi) - 4.0 * np.sin(phi) * np.cos(phi) / root
    assert -500.0 * slope - 35.0 * 9.81 * np.cos(phi) == pytest.approx(0.0, abs=1e-9)
    assert rest.stable


@pytest.fixture(scope="module")
def whirl(workshop: Path) -> Machine:
    """Two like oscillators, damped by c, and coupled by forces ±b without a potential."""
    model = Model("whirl")
    mass = model.body("mass", mass=1, inertia=1)
    b, c = model.parameter("b", 0.0), model.parameter("c", 0.0)
    model.potential("springs", 2 * (mass.x**2 + mass.y**2) + mass.phi**2)
    model.force("forces", mass, fx=-b * mass.y - c * mass.vx, fy=b * mass.x - c * mass.vy)
    model.scene("rest", ["springs", "forces"], guess={mass.x: 0.1})
    return load(model, folder=workshop)


@pytest.mark.parametrize(
    ("b", "c", "stable", "cause"),
    [
        (0.0, 0.5, True, ""),
        (0.0, -1e-3, False, "since forces that depend on velocities feed its motion"),
        (0.5, 0.0, False, "in oscillations that grow (flutter)"),
        (0.5, 0.2, False, "in oscillations that grow (flutter)"),
        (0.5, 0.3, True, ""),
    ],
)
def test_damping_takes_part_in_stability(
    whirl: Machine, b: float, c: float, stable: bool, cause: str
) -> None:
    """λ² + c λ + 4 ± i b = 0: a push grows if c < 0 or b > 2 c."""
    rest = whirl.equilibrium(parameters={"b": b, "c": c})
    assert rest.stability is (Stability.STABLE if stable else Stability.UNSTABLE)
    assert cause in rest.message
    assert len(rest.frequencies) == (3 if b == 0.0 else 1)


@METHODS
def test_no_verdict_without_balance(workshop: Path, method: str) -> None:
    """A torque above the largest moment of the weight, 9.81 N m: the hinge turns on."""
    model = Model("spun", gravity=(0, -9.81))
    bar = model.body("bar", mass=2.0, inertia=0.3)
    model.revolute("A", model.ground.at(0, 0), bar.at(0, 0.5))
    model.torque("T", bar, 14.0)
    model.scene("turn", ["gravity", "T"])
    rest = load(model, folder=workshop).equilibrium(method)
    assert rest.outcome is Outcome.UNBALANCED
    assert rest.stability is Stability.UNKNOWN
    assert len(rest.frequencies) == 0
    assert np.isnan(rest.eigenvalues).all()
    if method == "settling":
        assert "settling" not in rest.message
        assert "iterations" not in rest.message


def test_force_that_nothing_balances(make: Callable[..., Machine]) -> None:
    machine = make("runaway", "runaway")
    rest = machine.equilibrium()
    assert rest.outcome is Outcome.UNBALANCED
    assert rest.failed
    assert "No equilibrium found" in rest.message
    assert "nothing holds the machine in bar.phi, which ran away" in rest.message
    assert len(rest.t) == 1


@METHODS
def test_forces_that_depend_on_t_are_those_of_an_instant(workshop: Path, method: str) -> None:
    model = Model("pushed", gravity=(0, -9.81))
    bob = model.body("bob", 1.0, 0.1)
    model.revolute("A", model.ground.at(0, 0), bob.at(-1, 0))
    model.force("push", bob.at(0, 0), 9.81 * t, 0)
    model.scene("push", ["gravity", "push"], guess={"bob.phi": -1.2})
    model.scene("hang", ["gravity"], guess={"bob.phi": -1.2})
    pushed, hanging = (load(model, scene=name, folder=workshop) for name in ("push", "hang"))
    for instant, angle in ((0.0, -np.pi / 2), (1.0, -np.pi / 4)):
        rest = pushed.equilibrium(method, t=instant, progress=False)
        assert rest["bob.phi"] == pytest.approx(angle, abs=1e-9)
        assert f"Forces depend on t, and are those of t = {instant:g} s; give t=" in rest.message
    assert "depend on t" not in hanging.equilibrium(method, progress=False).message


def test_nothing_to_balance(driven: Machine) -> None:
    with pytest.raises(AnalysisError, match=r"0 degrees of freedom.*Leave crank_drive out of"):
        driven.equilibrium()


def test_a_joint_too_many_is_named_where_no_driver_holds_the_machine(tmp_path: Path) -> None:
    model = Model("held", gravity=(0, -9.81))
    bob = model.body("bob", mass=1.0, inertia=0.1)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.absolute("bolt", bob, "phi", 0.0)
    model.scene("rest", ["gravity"])
    with pytest.raises(AnalysisError, match=r"Leave a joint \(without=\[\.\.\.\]\) out of the"):
        load(model, folder=tmp_path).equilibrium()


def test_masses_are_needed(make: Callable[..., Machine]) -> None:
    machine = make("slider_crank", "bare", driven=True, masses=False)
    with pytest.raises(AnalysisError, match="equilibrium needs masses"):
        machine.equilibrium()


def test_unknown_method(free: Machine) -> None:
    with pytest.raises(AnalysisError, match=r"no equilibrium method 'magic'.*energy, settling"):
        free.equilibrium("magic")


def test_settling_needs_drivers_at_rest(make: Callable[..., Machine]) -> None:
    machine = make("double", "double")
    with pytest.raises(AnalysisError, match="settling needs drivers at rest, and motor moves"):
        machine.equilibrium("settling")
    rest = machine.equilibrium(guess={"lower.phi": -1.0})
    assert rest["upper.phi"] == pytest.approx(0.5, abs=1e-14)
    assert rest["lower.phi"] == pytest.approx(-np.pi / 2, abs=1e-12)
