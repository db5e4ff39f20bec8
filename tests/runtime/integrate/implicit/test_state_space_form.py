"""Unknowns and derivatives of a pendulum, its completion, and the spectrum of known equations."""

import numpy as np
import pytest

from runtime.core.workspace_rows import Y0, K
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.state_space_form import differentiate
from tests.runtime.integrate.implicit.drivers import (
    Arrays,
    estimate_spectrum,
    evaluate,
    list_unknowns,
    suits_explicit,
)
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM_P

PHI, OMEGA, G = 0.3, 1.2, 9.81


@pytest.fixture
def arrays():
    found = Arrays(SMOOTH_PENDULUM, PENDULUM_P)
    c, s = np.cos(PHI), np.sin(PHI)
    found.workspace[Y0] = c, s, PHI, -s * OMEGA, c * OMEGA, OMEGA
    found.set_independent(2)
    return found


def test_unknowns_are_the_independent_coordinates(arrays):
    assert list_unknowns(arrays.table) == 1
    assert arrays.notes[mem.COUNTS] == 2
    arrays.notes[mem.CURRENT] = 1
    list_unknowns(arrays.table)
    assert arrays.notes[mem.CURRENT] == 1
    arrays.set_independent(0)
    list_unknowns(arrays.table)
    assert arrays.notes[mem.COUNTS] == 0
    assert arrays.notes[mem.CURRENT] == 0


def test_dependent_half_follows(arrays):
    list_unknowns(arrays.table)
    exact = arrays.workspace[Y0].copy()
    arrays.workspace[Y0, :2] += 1e-3
    arrays.workspace[Y0, 3:5] -= 1e-3
    assert evaluate(arrays.table, 0.0, Y0, K) > 0
    np.testing.assert_allclose(arrays.workspace[Y0], exact, atol=1e-12)
    assert arrays.workspace[K, 5] == pytest.approx(-G * np.cos(PHI))


def test_derivatives_are_those_of_the_reduced_equation(arrays):
    list_unknowns(arrays.table)
    differentiate(arrays.table, 0.0, Y0)
    by_u, by_rate = arrays.derivatives()
    assert by_u[0, 0] == pytest.approx(G * np.sin(PHI), rel=1e-8)
    assert abs(by_rate[0, 0]) < 1e-8
    assert arrays.numbers[mem.STIFFNESS] == pytest.approx(np.sqrt(G * np.sin(PHI)), rel=1e-6)


def test_derivatives_by_a_dependent_choice(arrays):
    # x = cos φ: ẍ = g sin φ cos φ - cos φ φ̇², φ̇ = -ẋ / sin φ.
    arrays.set_independent(0)
    list_unknowns(arrays.table)
    differentiate(arrays.table, 0.0, Y0)
    by_u, by_rate = arrays.derivatives()
    x, v = np.cos(PHI), -np.sin(PHI) * OMEGA

    def acceleration(x, v):
        return G * x * np.sqrt(1.0 - x * x) - x * v * v / (1.0 - x * x)

    h = 1e-6
    assert by_u[0, 0] == pytest.approx(
        (acceleration(x + h, v) - acceleration(x - h, v)) / (2.0 * h), rel=1e-6
    )
    assert by_rate[0, 0] == pytest.approx(-2.0 * x * v / (1.0 - x * x), rel=1e-6)


@pytest.mark.parametrize("damping", [0.0, 0.3, 0.9])
def test_a_damped_vibration(arrays, damping):
    arrays.set_derivatives([[-(50.0**2)]], [[-2.0 * damping * 50.0]])
    estimate_spectrum(arrays.table, 0.1)
    assert arrays.numbers[mem.STIFFNESS] == pytest.approx(50.0)
    assert arrays.numbers[mem.DAMPING] == pytest.approx(damping)


def test_the_fastest_of_several(arrays):
    arrays.set_derivatives(np.diag([-1.0, -1e6, -4.0]), np.diag([0.0, -3e3, -1.0]))
    bound = estimate_spectrum(arrays.table, 0.1)
    exact = np.abs(np.roots([1.0, 3e3, 1e6])).max()
    assert arrays.numbers[mem.STIFFNESS] == pytest.approx(exact, rel=0.2)
    assert arrays.numbers[mem.DAMPING] == 1.0
    assert bound == pytest.approx(0.01 * 1e6 + 0.1 * 3e3)  # h² |G_u| + h |G_u̇|


def test_many_quiet_steps_suit_an_explicit_method(arrays):
    arrays.numbers[mem.STIFFNESS] = 1.0
    arrays.record["automatic"] = arrays.record["patience"] = 1
    answers = [suits_explicit(arrays.table, 0.4) for _ in range(30)]
    assert answers == [0] * 29 + [1]
    assert suits_explicit(arrays.table, 0.4) == 0
    assert suits_explicit(arrays.table, 0.6) == 0  # one that is not quiet starts the count anew
    assert arrays.notes[mem.CALM] == 0
