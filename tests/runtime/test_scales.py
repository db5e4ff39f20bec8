"""Sound machines in extreme units: small and large lengths, point masses, heavy bodies."""

from collections.abc import Callable
from math import pi
from pathlib import Path

import numpy as np
import pytest
import sympy

from codegen import Model, alpha
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

SWUNG = -0.6541487368022  # the angle of a point mass on a rod of 1 m after 2 s, from φ = 0 at rest


@pytest.fixture(scope="module")
def loaded(workshop: Path) -> Callable[[Model], Machine]:
    """Load a model beside the other machines of these tests."""
    return lambda model: load(model, "run", folder=workshop)


def pendulum(name: str, mass: float, inertia: float) -> Model:
    """A body on a rod of 1 m, by numbers and by parameters of these values."""
    model = Model(name, gravity=(0, -9.81))
    m = model.parameter("M", mass, unit="kg", sign="positive")
    j = model.parameter("J", inertia, unit="kg m^2", sign="positive")
    bob = model.body("bob", m, j)
    model.revolute("pin", model.ground.at(0, 0), bob.at(-1, 0))
    model.scene("run", effects=["gravity"], start={"bob.phi": 0, "bob.omega": 0})
    return model


@pytest.fixture(scope="module")
def bob(loaded: Callable[[Model], Machine]) -> Machine:
    """A pendulum that was built for ordinary masses."""
    return loaded(pendulum("bob", 1.0, 0.1))


@pytest.mark.parametrize(
    ("mass", "inertia"),
    [(1.0, 1e-9), (1.0, 1e-10), (1.0, 1e-12), (1e15, 0.1), (1e12, 1e-12), (1e-12, 1e-24)],
)
def test_a_point_mass_swings_whatever_its_inertia(
    bob: Machine, mass: float, inertia: float
) -> None:
    """A body of nearly no inertia is sound; its constraints are independent."""
    result = bob.simulate(2.0, parameters={"M": mass, "J": inertia}, progress=False)
    assert result.outcome is Outcome.OK, result.message
    assert result.q("bob.phi")[-1] == pytest.approx(SWUNG, abs=3e-8)
    # The pull of the rod by hand, in the axes of the ground.
    phi, omega = result.q("bob.phi"), result.v("bob.omega")
    pull = -mass * (omega**2 - 9.81 * np.sin(phi))
    along = result.reaction("pin", "fx") * np.cos(phi) + result.reaction("pin", "fy") * np.sin(phi)
    np.testing.assert_allclose(along, pull, rtol=0, atol=1e-6 * abs(pull).max())


@pytest.mark.parametrize(("mass", "inertia"), [(1.0, 1e-10), (1e15, 0.1)])
def test_a_point_mass_may_be_declared_as_a_body(
    loaded: Callable[[Model], Machine], mass: float, inertia: float
) -> None:
    """The module that is built for such masses bears them by itself."""
    machine = loaded(pendulum(f"bob_{mass:.0e}".replace("+", ""), mass, inertia))
    result = machine.simulate(2.0, progress=False)
    assert result.outcome is Outcome.OK, result.message
    assert result.q("bob.phi")[-1] == pytest.approx(SWUNG, abs=3e-8)


def press(name: str) -> Model:
    """A slider-crank with a cam on its crank, in the length L and the mass M."""
    model = Model(name)
    length = model.parameter("L", 1.0, unit="m", sign="positive")
    mass = model.parameter("M", 1.0, unit="kg", sign="positive")
    model.gravity("gravity", (0, -9.81 * length))
    crank = model.body("crank", mass, mass * length**2 / 12)
    rod = model.body("rod", mass, 0.3 * mass * length**2)
    slider, valve = (model.body(k, 2 * mass, mass * length**2) for k in ("slider", "valve"))
    model.revolute("A", model.ground.at(0, 0), crank.at(-length / 2, 0))
    model.revolute("B", crank.at(length / 2, 0), rod.at(-length, 0))
    model.revolute("C", rod.at(length, 0), slider.at(0, 0))
    model.translational("G", model.ground, slider)
    model.translational("H", model.ground, valve, axis=(0, 1))
    profile = length * (0.5 + 0.03 * sympy.cos(2 * alpha))
    model.cam_flat_follower("lift", crank.polar(profile), valve.at(0, 0))
    model.scene("run", effects=["gravity"], start={"crank.phi": 0.5, "crank.omega": 3})
    return model


@pytest.fixture(scope="module")
def presses(loaded: Callable[[Model], Machine]) -> tuple[Machine, float]:
    """The press, and where its crank ends in units of its own."""
    machine = loaded(press("press"))
    return machine, run_press(machine, 1.0, 1.0)


def run_press(machine: Machine, length: float, mass: float) -> float:
    """The crank's angle after 2 s."""
    guess = {"crank.x": length / 2, "rod.x": 2 * length, "slider.x": 3 * length}
    result = machine.simulate(2.0, parameters={"L": length, "M": mass}, guess=guess, progress=False)
    assert result.outcome is Outcome.OK, result.message
    return float(result.q("crank.phi")[-1])


@pytest.mark.parametrize("length", [1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9, 1e12])
@pytest.mark.parametrize("mass", [1e-12, 1.0, 1e12])
def test_a_machine_moves_alike_in_any_units(
    presses: tuple[Machine, float], length: float, mass: float
) -> None:
    """Gravity grows with the lengths, so that the motion is the same."""
    machine, expected = presses
    assert run_press(machine, length, mass) == pytest.approx(expected, abs=1e-7)


def test_a_cam_closes_where_its_arm_is_the_cosine_of_a_right_angle(
    loaded: Callable[[Model], Machine],
) -> None:
    """The contact lies at α = π/2, where no angle moves the follower: that is no length scale."""
    model = Model("lift", gravity=(0, -9.81))
    cam, valve = model.body("cam", 1.0, 0.01), model.body("valve", 1.0, 0.01)
    model.revolute("A", model.ground.at(0, 0), cam.at(0, 0))
    model.translational("G", model.ground, valve, axis=(0, 1))
    model.cam_flat_follower("lift", cam.polar(0.1 + 0.01 * sympy.cos(2 * alpha)), valve)
    model.scene("run", effects=["gravity"], start={"cam.phi": 0, "cam.omega": 3})
    machine = loaded(model)
    heights = [
        machine.assemble({"lift.alpha": pi / 2 - turn}, start={"cam.phi": turn}).q[4]
        for turn in (0.0, pi / 2, pi)
    ]
    np.testing.assert_allclose(heights, [0.09, 0.11, 0.09], rtol=0, atol=1e-12)
    assert machine.simulate(0.5, progress=False).outcome is Outcome.OK


@pytest.mark.parametrize("way", [1e3, 1e6, -1e7])
def test_a_machine_far_from_the_origin_moves_as_one_at_it(
    loaded: Callable[[Model], Machine], way: float
) -> None:
    """Joints close to the last digits of their coordinates, which are 1e-10 m at 1e6 m."""
    ends = []
    for at in (0.0, way):
        model = Model(f"far_{at:g}".replace("-", "m").replace("+", ""), gravity=(0, -9.81))
        a, b = (model.body(name, mass=1.0, inertia=0.1) for name in "ab")
        model.revolute("O", model.ground.at(at, -at), a.at(-0.5, 0))
        model.revolute("A", a.at(0.5, 0), b.at(-0.5, 0))
        model.scene("run", ["gravity"], start={a.phi: 0.3, b.phi: 0.2, a.omega: 0.0, b.omega: 0.0})
        run = loaded(model).simulate(1.0, [1.0], progress=False)
        assert run.outcome is Outcome.OK
        ends.append([float(run.q(name)[-1]) for name in ("a.phi", "b.phi")])
    assert ends[1] == pytest.approx(ends[0], abs=1e-7 + 1e-13 * abs(way))
