"""The estimated error of a step: its order, and that it is large enough and no more."""

import numpy as np
import pytest

from runtime.core.workspace_rows import Y0, Y1, K
from runtime.integrate.implicit import method_memory as mem
from tests.runtime.integrate.implicit.drivers import Arrays, radau5_step
from tests.runtime.integrate.stiff import smooth_relay


def step(h, rtol=1e-6):
    """Estimate, and true error, of a step of q̈ = -4 q; in units of 1."""
    arrays = Arrays(*smooth_relay(stiffness=4.0), rtol=rtol)
    q, v = np.cos(0.3), -2.0 * np.sin(0.3)
    arrays.workspace[Y0], arrays.workspace[K] = (q, v), (v, -4.0 * q)
    assert radau5_step(arrays.table, 0.0, h) >= 0
    exact = np.cos(2.0 * h + 0.3), -2.0 * np.sin(2.0 * h + 0.3)
    allowed = arrays.rows[mem.TOLERANCE]
    size = arrays.numbers[mem.STEP_ERROR] * np.sqrt(np.mean(allowed**2))
    return size, np.abs(arrays.workspace[Y1] - exact).max()


def test_the_estimate_is_of_order_four_and_the_error_of_order_six():
    lengths = np.array([0.05, 0.07, 0.1, 0.14])
    estimates, errors = np.transpose([step(h, 1e-10) for h in lengths])
    assert np.polyfit(np.log(lengths), np.log(estimates), 1)[0] == pytest.approx(4.0, abs=0.3)
    assert np.polyfit(np.log(lengths), np.log(errors), 1)[0] == pytest.approx(6.0, abs=0.3)
    assert np.all(estimates > errors)
