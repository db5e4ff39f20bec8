"""Modes just after an instant at which a function is on its surface."""

import pytest

from runtime.core import workspace_rows as ws
from runtime.core.kinds import SLIDING
from runtime.hybrid.mode_consistency import CONSISTENT
from tests.runtime.hybrid import drivers
from tests.runtime.hybrid.systems import BLOCK, Instant
from tests.runtime.integrate.systems import relay

ON_V = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)  # v > 0, which does nothing
AHEAD = 1e-3


def on_surface(switch, constant, mode, preferred=None):
    """A relay at rest in q = v = 0, its function on its surface."""
    system, p = relay(switch, constant=constant)
    there = Instant(system, p, modes=(mode,))
    there.switching[ws.BAND] = 1e-12
    there.switching[ws.PREFERRED] = mode if preferred is None else preferred
    return there


@pytest.mark.parametrize("before", [0, 1])
@pytest.mark.parametrize(("push", "mode"), [(1.0, 1), (-1.0, 0)])
def test_the_acceleration_decides_where_g_and_its_rate_vanish(push, mode, before):
    there = on_surface(ON_V, push, before)
    assert drivers.select_modes(there.context, 0.0, AHEAD) == CONSISTENT
    assert there.modes.tolist() == [mode]


@pytest.mark.parametrize(("constant", "mode"), [(1.5, SLIDING), (2.5, 1), (-0.5, 0)])
def test_a_surface_that_attracts_from_both_sides_slides(constant, mode):
    there = on_surface((-2.0, *ON_V[1:]), constant, 0)
    assert drivers.select_modes(there.context, 0.0, AHEAD) == CONSISTENT
    assert there.modes.tolist() == [mode]


def test_where_no_mode_is_consistent_modes_stay():
    # q > 0 pulls down and q < 0 pushes up: the force does not act on dq/dt.
    there = on_surface((-2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), 1.0, 1)
    assert drivers.select_modes(there.context, 0.0, AHEAD) == 0
    assert there.modes.tolist() == [1]


def test_a_function_off_its_surface_keeps_its_mode():
    there = on_surface(ON_V, 1.0, 0)
    there.switching[ws.BAND] = 0.0
    assert drivers.select_modes(there.context, 0.0, AHEAD) == CONSISTENT
    assert there.modes.tolist() == [0]


@pytest.mark.parametrize(("push", "mode"), [(0.5, SLIDING), (1.5, 1), (-1.5, 0)])
def test_a_block_at_rest_sticks_up_to_its_limit(push, mode):
    block = Instant(BLOCK, (push, 1.0, 1.0, 0.0), modes=(0,))
    assert drivers.initialize_modes(block.context, 1.0, AHEAD) == CONSISTENT
    assert block.modes.tolist() == [mode]
