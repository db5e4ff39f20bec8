"""The polynomial through the stages, and their prediction from it."""

import numpy as np

from runtime.core.workspace_rows import Y0, Y1, K
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.radau5_stages import POLYNOMIAL, SLOPES, STATES, A, C
from tests.runtime.integrate.implicit.drivers import (
    Arrays,
    predict_stages,
    radau5_step,
    write_polynomial,
)
from tests.runtime.integrate.stiff import smooth_relay


def cubic(t):
    return np.stack([1.0 + t - 2.0 * t**2 + 0.5 * t**3, 1.0 - t**3], axis=-1)


def test_without_a_past_stages_are_on_a_straight_line():
    arrays = Arrays(*smooth_relay(stiffness=1.0))
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, 2.0), (3.0, -4.0)
    predict_stages(arrays.table, 0.1)
    stages = arrays.workspace[K + STATES : K + STATES + 3]
    np.testing.assert_allclose(stages, [1.0, 2.0] + 0.1 * C[:, None] * [3.0, -4.0])


def test_a_cubic_is_continued_over_the_next_step():
    arrays, h, ratio = Arrays(*smooth_relay(stiffness=1.0)), 0.5, 1.5
    arrays.workspace[Y0], arrays.workspace[Y1] = cubic(np.array([0.0, h]))
    arrays.workspace[K + STATES : K + STATES + 3] = cubic(C * h)
    change, f2, f3 = arrays.rows[POLYNOMIAL : POLYNOMIAL + 3]
    change[:] = arrays.workspace[Y1] - arrays.workspace[Y0]
    write_polynomial(arrays.table, f2, f3)
    arrays.notes[mem.EQUAL], arrays.numbers[mem.H_BASE] = 1, h
    arrays.workspace[Y0] = arrays.workspace[Y1]
    predict_stages(arrays.table, ratio * h)
    stages = arrays.workspace[K + STATES : K + STATES + 3]
    np.testing.assert_allclose(stages, cubic(h + C * ratio * h), rtol=1e-12)


def test_stages_satisfy_the_formula():
    # q̈ = -9 q - 0.5 q̇ over a third of a turn: positions hold exactly, velocities to the tolerance.
    arrays, h = Arrays(*smooth_relay(stiffness=9.0, damping=0.5), rtol=1e-13), 0.7
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, -2.0), (-2.0, -8.0)
    assert radau5_step(arrays.table, 0.0, h) >= 0
    states = arrays.workspace[K + STATES : K + STATES + 3]
    rates = states @ np.array([[0.0, -9.0], [1.0, -0.5]])
    np.testing.assert_allclose(states[:, 0], 1.0 + h * A @ states[:, 1], rtol=1e-14)
    np.testing.assert_allclose(states[:, 1], -2.0 + h * A @ rates[:, 1], rtol=1e-10)
    slopes = arrays.workspace[K + SLOPES : K + SLOPES + 3]
    np.testing.assert_allclose(slopes[:, 1], rates[:, 1], rtol=1e-9)
    assert np.array_equal(arrays.workspace[Y1], states[2])
