"""No two rows, matrices or pivots share a place, and none is left over."""

import numpy as np

from runtime.integrate.implicit import method_memory as mem
from tests.runtime.integrate.implicit.drivers import Arrays, number_all
from tests.runtime.integrate.stiff import SMOOTH_PENDULUM
from tests.runtime.integrate.systems import PENDULUM_P


def test_places():
    arrays = Arrays(SMOOTH_PENDULUM, PENDULUM_P)
    assert mem.memory(3) == (arrays.numbers.size, arrays.notes.size)
    number_all(arrays.table)
    numbered = arrays.numbers[mem.NUMBERS :]
    np.testing.assert_array_equal(numbered, np.arange(1.0, numbered.size + 1.0))
    assert not arrays.numbers[: mem.NUMBERS].any()
    assert arrays.notes[mem.COUNTS :].tolist() == [1] * 3 + [2] * 3 + [3] * 6
    assert not arrays.notes[: mem.COUNTS].any()
