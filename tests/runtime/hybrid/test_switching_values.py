"""Switching functions and their rates; in sliding mode margins stand in their place."""

import numpy as np
import pytest

from runtime.core import workspace_rows as ws
from tests.runtime.hybrid import drivers
from tests.runtime.hybrid.systems import BLOCK, SLIDER, Instant

FREE = -1.7e308  # no lower bound


@pytest.mark.parametrize(
    ("low", "share", "high", "margin"),
    [
        (0.0, 0.25, 1.0, 0.75 * 0.25),
        (0.0, 1.25, 1.0, -0.25 * 1.25),
        (-1.0, 0.5, 3.0, 2.5 * 1.5 / 4.0),
        (FREE, 0.4, 1.0, 0.6),
        (FREE, 1.5, 1.0, -0.5),
        (0.0, np.nan, 1.0, -1.0),
    ],
)
def test_margin_of_a_share_between_bounds(low, share, high, margin):
    block = Instant(SLIDER, (0.3, 1.0, 1.0, 0.0))
    block.shares[0] = share
    block.arrays["share_low"][0], block.arrays["share_high"][0] = low, high
    assert drivers.compute_margin(block.context, 0.0, 0) == pytest.approx(margin, rel=1e-15)


def test_functions_that_do_not_slide_keep_g_and_its_rate():
    block = Instant(SLIDER, (0.3, 1.0, 1.0, 0.0), v=(0.2,), modes=(1,))
    block.states[ws.K, 1] = block.evaluate(t=1.0)[0]
    drivers.evaluate_switching_and_rates(block.context, 1.0)
    assert block.switching[ws.G0].tolist() == [0.2]
    assert block.switching[ws.R0].tolist() == pytest.approx([0.3 - 1.0])


@pytest.mark.parametrize(("t", "side"), [(1.0, -1.0), (-1.0, 1.0)])
def test_the_rate_of_a_margin_is_that_along_the_motion(t, side):
    # The margin is 1 - 0.3 |t| / 2.
    block = Instant(BLOCK, (0.3, 1.0, 2.0, 0.0))
    block.evaluate(t)
    drivers.evaluate_switching_and_rates(block.context, t)
    assert block.switching[ws.G0].tolist() == pytest.approx([0.85], rel=1e-14)
    assert block.switching[ws.R0].tolist() == pytest.approx([side * 0.15], rel=1e-10)
