"""Spectral radius and damping of known equations, and when an explicit method would do."""

import numpy as np
import pytest

from runtime.integrate.implicit import method_memory as mem
from tests.runtime.integrate.implicit.drivers import Arrays, estimate_spectrum, suits_explicit
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM_P


@pytest.fixture
def arrays():
    return Arrays(SMOOTH_PENDULUM, PENDULUM_P)


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
