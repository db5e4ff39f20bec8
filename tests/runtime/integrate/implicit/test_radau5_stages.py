"""The polynomial through the stages, and their prediction from it."""

import numpy as np

from runtime.core.workspace_rows import Y0, Y1, K
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.radau5_coefficients import C
from runtime.integrate.implicit.radau5_stages import POLYNOMIAL, STATES
from tests.runtime.integrate.implicit.drivers import Arrays, predict_stages, write_polynomial
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
