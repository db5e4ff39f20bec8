"""The grid of settings and tolerances."""

from numpy.testing import assert_allclose

from runtime.studies.work_precision.study import FURTHER, RTOLS


def test_the_grid_is_that_of_the_definition() -> None:
    assert len(RTOLS) == 17
    assert_allclose((RTOLS[0], RTOLS[1], RTOLS[-1]), (1e-2, 10**-2.5, 1e-10))
    assert_allclose((FURTHER[0], FURTHER[-1]), (10**-10.5, 1e-12))
