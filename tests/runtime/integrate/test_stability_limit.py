"""The longest step in which a vibration does not grow, from what two states reveal of it."""

import numpy as np
import pytest

from codegen.tableaus import tableaus
from runtime.integrate.stability_limit import FLOATS
from tests.runtime.integrate.stability_drivers import amplification, stable_length

POWERS = np.array([float(x) for x in reversed(tableaus()["dopri5"].stability_function)])
OMEGA = 50.0
EDGE = 1.0 / OMEGA  # dopri5 is stable on the imaginary axis up to about one radian


def memory(omega, damping=0.0):
    """Sums over states of q̈ = -ω² q - c q̇, as the step's two states differ at several phases."""
    phases = np.linspace(0.0, 3.0, 7)
    q, v = np.cos(phases), omega * np.sin(phases)
    a = -(omega**2) * q - damping * v
    return np.array([q @ q, q @ v, v @ v, a @ q, a @ v, a @ a, 0.0])


@pytest.mark.parametrize("damping", [0.0, 5.0])
def test_amplification_is_that_of_the_stability_function(damping):
    z = 0.03 * np.roots([1.0, damping, OMEGA**2])[0]
    expected = abs(np.polyval(POWERS, z))
    assert amplification(POWERS, 0.03, OMEGA**2, damping) == pytest.approx(expected)


def test_short_steps_stay():
    assert stable_length(memory(OMEGA), POWERS, 0.5 * EDGE) == 0.5 * EDGE


def test_long_steps_are_cut_once_the_vibration_has_grown():
    kept = memory(OMEGA)
    assert kept.size == FLOATS
    lengths = [stable_length(kept, POWERS, 1.5 * EDGE) for _ in range(1000)]
    assert lengths[0] == 1.5 * EDGE  # a little growth is let pass
    assert 0.5 * EDGE < lengths[-1] < EDGE
    assert amplification(POWERS, lengths[-1], OMEGA**2, 0.0) <= 1.0


def test_damping_permits_longer_steps():
    kept = memory(OMEGA, damping=2.0 * OMEGA * 0.9)
    lengths = [stable_length(kept, POWERS, 1.3 * EDGE) for _ in range(1000)]
    assert set(lengths) == {1.3 * EDGE}
