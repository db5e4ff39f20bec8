"""The force of matter that comes or goes, and the energy that it brings, by hand."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from tests.codegen.workbench import A, B, Interpreted, State

TOLERANCE = {"rtol": 1e-12, "atol": 1e-12}
PLACE, SEEDS = np.array([0.3, -0.2]), range(5)


def rates(s: State) -> tuple[float, float]:
    """ṁ and J̇ of the machine below."""
    return float(s.v[3]), float(s.v[4])


def machine(place: tuple[object, object] = tuple(PLACE), **velocity: object) -> Interpreted:
    """A free body under gravity whose matter comes at a place."""
    model = Model("tank", gravity=(0.5, -9.81))
    tank = model.body("tank", mass=5 + 2 * sympy.sin(t), inertia=2 - 0.3 * t)
    model.mass_flow("feed", tank.at(*place), **velocity)
    return Interpreted(model)


def forces(s: State, u: np.ndarray) -> np.ndarray:
    """Q of ṁ u at the point and of gravity on x, y, φ."""
    _, phi, _, _ = s.body(0)
    push = rates(s)[0] * u
    return np.array([*(push + s.q[3] * np.array([0.5, -9.81])), (B(phi) @ PLACE) @ push])


def test_rates_of_matter_are_those_of_its_laws() -> None:
    made = machine(relative=(0, 0))
    for s in map(made.state, SEEDS):
        expected = [2.0 * np.cos(s.t), -0.3]
        assert_allclose(made.vector("velocity_rhs", s), expected, **TOLERANCE)


def test_flow_of_a_velocity_relative_to_the_body() -> None:
    made = machine(relative=(1.5, -0.7))
    for s in map(made.state, SEEDS):
        u = A(s.body(0)[1]) @ np.array([1.5, -0.7])
        assert_allclose(made.vector("applied_forces", s)[:3], forces(s, u), **TOLERANCE)


@pytest.mark.parametrize("place", [tuple(PLACE), (0.3 + t - 0.7, -0.2)])
def test_flow_of_a_velocity_in_global_axes(place: tuple[object, object]) -> None:
    """The body's own point counts, also where the place moves in the body."""
    made = machine(place, velocity=(0.2, sympy.cos(t)))
    for s in map(made.state, SEEDS):
        _, phi, v, omega = s.body(0)
        u = np.array([0.2, np.cos(s.t)]) - v - B(phi) @ PLACE * omega
        assert_allclose(made.vector("applied_forces", s)[:3], forces(s, u), **TOLERANCE)


def test_masses_are_pushed_by_nothing_and_bring_their_energy() -> None:
    made = machine(relative=(1.5, -0.7))
    for s in map(made.state, SEEDS):
        r, phi, v, omega = s.body(0)
        flow, slower = rates(s)
        q = made.vector("applied_forces", s)
        assert_allclose(q[3:], 0.0, atol=1e-14)
        push = flow * A(phi) @ np.array([1.5, -0.7])
        at = v + B(phi) @ PLACE * omega
        brought = (flow * v @ v + slower * omega**2) / 2 + push @ at
        rises = -s.v[3] * np.array([0.5, -9.81]) @ r  # of the potential energy
        powers = made.vector("powers", s, lam=np.zeros(made.m))
        assert_allclose(powers.sum(), brought + rises, **TOLERANCE)
