"""A step of the formulas: what it solves for, and what it takes for its error."""

import numpy as np
import pytest

from runtime.core.workspace_rows import Y0, Y1, K
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.bdf import restart
from runtime.integrate.implicit.bdf_history import AHEAD, ALPHA, DIFFERENCE, NOW
from tests.runtime.integrate.implicit.drivers import Arrays, bdf_evaluate, bdf_step
from tests.runtime.integrate.stiff import DRAWN, smooth_relay


def first_step(h, **coefficients):
    arrays = Arrays(*smooth_relay(**coefficients), method="bdf")
    stiffness, constant = coefficients.get("stiffness", 0.0), coefficients.get("constant", 0.0)
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, 2.0), (2.0, constant - stiffness)
    restart(arrays.table, 0.0, h)
    assert bdf_step(arrays.table, 0.0, h) >= 0
    return arrays


def test_a_parabola_has_no_error():
    arrays = first_step(0.1, constant=-9.81)
    expected = 1.0 + 0.2 - 0.5 * 9.81 * 0.01, 2.0 - 0.981
    np.testing.assert_allclose(arrays.workspace[Y1], expected, rtol=1e-14)
    assert arrays.numbers[mem.STEP_ERROR] < 1e-6


def test_a_stiff_force_is_that_before_rounding():
    # A unit in the last place of the position is a force of 1e-4.
    stiffness, t, h = 1e12, 1.0, 1e-3
    arrays = Arrays(DRAWN, [stiffness, 0.0], method="bdf")
    arrays.workspace[Y0] = np.sin(t), np.cos(t)
    arrays.workspace[K] = np.cos(t), -np.sin(t)
    restart(arrays.table, t, h)
    assert bdf_step(arrays.table, t, h) >= 0
    assert bdf_evaluate(arrays.table, t + h, h / ALPHA[2]) == 0
    y, (start, ahead, difference) = arrays.workspace[Y1], arrays.rows[[NOW, AHEAD, DIFFERENCE], 0]
    force = stiffness * ((ahead + difference) - (y[0] - start))
    assert abs(force) > 1e-7
    a, p = np.zeros(1), np.array([stiffness, 0.0])
    DRAWN.accelerations(t + h, y[:1], y[1:], p, np.zeros(0, np.int64), a, np.zeros(0))
    kept = arrays.workspace[K + mem.LAST, 1]
    assert kept == pytest.approx(a[0] - force, abs=1e-3 * abs(force))


def test_the_error_of_a_vibration_falls_with_its_order():
    # From a parabola the first step is of order 2: its estimate goes with the third power.
    lengths = np.array([0.01, 0.02, 0.04])
    errors = [first_step(h, stiffness=4.0).numbers[mem.STEP_ERROR] for h in lengths]
    assert np.polyfit(np.log(lengths), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.3)
    assert errors[0] > 0.0
