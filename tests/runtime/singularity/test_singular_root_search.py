"""The search along a motion that passes the crossing of two branches."""

import numpy as np
import pytest

from runtime.singularity.motion_polynomial import taylor
from runtime.singularity.schur_complement import PivotOrders
from runtime.singularity.singular_root_search import Search
from tests.runtime.singularity.crossing import branch_slopes, mechanism


def on_branch(x, c=0.5, speed=1.0, t=2.0):
    """The motion on the first branch at x, which it passes at a constant speed in x."""
    s = branch_slopes(c)[0]
    q = np.array([x, s * x, -s * x * x])
    v = speed * np.array([1.0, s, -2.0 * s * x])
    return taylor(t, q, v, speed**2 * np.array([0.0, 0.0, -2.0 * s]))


def search(motion, **more):
    scaled = mechanism(**more)
    return Search(scaled, PivotOrders(scaled), motion, float(np.linalg.norm(motion.velocity)))


@pytest.mark.parametrize("x", [-0.2, -0.01, 0.1])
def test_the_position_is_met_when_the_motion_passes_it(x):
    found = search(on_branch(x)).find(-0.9 * x, 1)
    assert found is not None
    root, s = found
    np.testing.assert_allclose(root.z[:3], 0.0, atol=1e-10)
    assert s == pytest.approx(-x, abs=1e-7)
    assert root.gap < 1e-14
    assert root.freedom == 1


def test_places_along_the_motion():
    along = search(on_branch(-0.2, speed=3.0))
    z, rate = along.path.at(0.05)
    s = branch_slopes(0.5)[0]
    np.testing.assert_allclose(z[:2], [-0.05, -0.05 * s])
    np.testing.assert_allclose(rate[:2], [3.0, 3.0 * s])
    assert z[3] == pytest.approx(2.05 * along.speed)


def test_what_might_be_lost_where():
    along = search(on_branch(-1.0))
    assert along.count_weak(0.98) == 1
    assert along.count_weak(0.0) == 0


def test_nothing_is_met_where_nothing_is_near():
    assert search(on_branch(-3.0)).find(0.0, 1) is None
