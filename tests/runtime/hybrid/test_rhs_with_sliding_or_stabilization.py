"""Accelerations in sliding modes, and the part of a correction that is no rounding."""

import numpy as np
import pytest

from tests.runtime.hybrid import drivers
from tests.runtime.hybrid.systems import BLOCK, SLIDER, Instant
from tests.runtime.integrate.systems import relay

PUSH = 0.3


def test_the_share_stops_a_block():
    # a = push + 1 in mode 0 and push - 1 in mode 1.
    block = Instant(SLIDER, (PUSH, 1.0, 1.0, 0.0))
    assert block.evaluate(t=1.0) == [0.0]
    assert block.shares[0] == pytest.approx((PUSH + 1.0) / 2.0, rel=1e-15)


def test_the_stiction_force_stops_a_block_and_stands_in_the_parameters():
    block = Instant(BLOCK, (PUSH, 1.0, 2.0, 0.0))
    assert block.evaluate(t=1.0) == [0.0]
    assert block.p[3] == pytest.approx(-PUSH, rel=1e-15)


@pytest.mark.parametrize("mode", [0, 1])
def test_a_block_that_slips_has_the_force_of_its_mode(mode):
    block = Instant(BLOCK, (PUSH, 1.0, 2.0, 0.0), modes=(mode,))
    assert block.evaluate(t=1.0) == pytest.approx([PUSH + (1.0 if mode == 0 else -1.0)])


def test_two_functions_slide_by_a_share_each():
    # v > 0 and v + q > 0: the second share takes up what the first leaves.
    system, p = relay((-2.0, 0, 0, 0, 1.0, 0, 0), (-2.0, 0, 0, 0, 1.0, 0, 0), constant=1.0)
    both = Instant(system, p, modes=(2, 2))
    assert both.evaluate() == pytest.approx([0.0], abs=1e-15)
    assert both.shares.tolist() == pytest.approx([0.25, 0.25])


@pytest.mark.parametrize(("change", "part"), [(1e-16, 0.0), (1.0, 1.0), (64 * 2.0**-51, 0.5)])
def test_rounding_of_a_state_is_not_corrected(change, part):
    value, unit = np.array([1.0, 3.0]), np.array([1.0, 4.0])
    found = drivers.exclude_rounding(value, np.array([0.0, 4.0 * change]), unit)
    assert found == pytest.approx(part, abs=1e-12)
