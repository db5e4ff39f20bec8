"""Reactions between modes, and what sticking friction has left of its limit."""

import numpy as np
import pytest

from tests.runtime.hybrid import drivers
from tests.runtime.hybrid.systems import BLOCK, SLIDER, Instant


@pytest.mark.parametrize("push", [0.0, 0.3, -0.8])
@pytest.mark.parametrize("system", [SLIDER, BLOCK])
def test_the_reaction_holds_the_push(system, push):
    block = Instant(system, (push, 1.0, 2.0, 0.0))
    block.evaluate(t=1.0)
    drivers.mix_reactions(block.context, 1.0)
    np.testing.assert_allclose(block.arrays["reaction"], [-push, 2.0], atol=1e-15)


def test_mixing_leaves_the_stiction_force_in_the_parameters():
    block = Instant(BLOCK, (0.3, 1.0, 2.0, 0.0))
    block.evaluate(t=1.0)
    drivers.mix_reactions(block.context, 1.0)
    assert block.p[3] == pytest.approx(-0.3, rel=1e-15)


@pytest.mark.parametrize("push", [0.5, -0.5, 2.0, -3.0])
def test_margin_of_friction_is_the_part_of_its_limit_that_is_left(push):
    block = Instant(BLOCK, (push, 1.0, 2.0, 0.0))
    block.evaluate(t=1.0)
    margin = drivers.compute_margin(block.context, 1.0, 0)
    assert margin == pytest.approx(1.0 - abs(push) / 2.0, abs=1e-15)


def test_friction_without_normal_force_has_no_margin():
    block = Instant(BLOCK, (0.5, 1.0, 0.0, 0.0))
    block.evaluate(t=1.0)
    assert drivers.compute_margin(block.context, 1.0, 0) == -1.0
