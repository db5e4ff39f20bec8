"""Reductions of a series to a number."""

import numpy as np
from numpy.testing import assert_allclose

from runtime.studies.quantity import REDUCTIONS, Series


def test_reductions_of_a_wave_are_those_of_the_curve() -> None:
    t = np.linspace(0.0, 10.0, 801)
    wave = Series(t, 3.0 + 2.0 * np.sin(4.0 * t + 0.3), np.zeros(0))
    found = {word: how.reduce(wave) for word, how in REDUCTIONS.items()}
    assert_allclose(found["max"], 5.0, rtol=1e-6)
    assert_allclose(found["min"], 1.0, rtol=1e-5)
    assert_allclose(found["range"], 4.0, rtol=1e-5)
    assert_allclose(found["peak"], 5.0, rtol=1e-6)
    assert_allclose(found["mean"], 3.0 + (np.cos(0.3) - np.cos(40.3)) / 20.0, rtol=1e-5)
    assert_allclose(found["period"], np.pi / 2.0, rtol=1e-3)
    assert_allclose(found["rate"], (wave.x[-1] - wave.x[0]) / 10.0, rtol=1e-12)
    step = Series(np.array([0.0, 1.0, 1.001, 2.0]), np.array([0.0, 1.0, 4.0, 3.9]), np.array([1.0]))
    assert REDUCTIONS["max"].reduce(step) == 4.0
