"""Singular positions near a motion: what is found, against dense linear algebra and by hand."""

import numpy as np
import pytest

from models.hard.cases import find
from runtime import Machine
from runtime.mechanism.dense_equations import Equations
from runtime.singularity.motion_polynomial import Motion, hermite, nearest_time, taylor
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.schur_complement import PivotOrders, count_weak
from runtime.singularity.search_function_table import unit_jacobian_entries
from runtime.singularity.singular_position_near_motion import SingularPositions
from runtime.singularity.singular_root_search import Search

LOOPS = 2
TURNING = -5.0  # rad/s


@pytest.fixture(scope="module")
def machine() -> Machine:
    """A row of two four-bars."""
    return find(f"n_four_bar_{LOOPS}").machine()


@pytest.fixture(scope="module")
def scaled(machine: Machine) -> ScaledConstraints:
    equations = Equations(machine.mechanism, machine.parameter_values())
    scale = 1.0 / np.sqrt(np.diag(equations.mass(np.zeros(equations.n))))
    return equations.scaled(scale, np.arange(equations.m))


def parallel(machine: Machine, angle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, v and a with all cranks at one angle, turning at a constant speed."""
    q, v, a = np.zeros((3, len(machine.coordinates)))
    c, s = np.cos(angle), np.sin(angle)
    for j, row in enumerate(machine.coordinates):
        body, axis = row.name.split(".")
        kind, number = body.split("_")
        reach, foot = (0.5, float(number)) if kind == "crank" else (1.0, int(number) - 0.5)
        if axis == "x":
            q[j], v[j], a[j] = foot + reach * c, -reach * s * TURNING, -reach * c * TURNING**2
        elif axis == "y":
            q[j], v[j], a[j] = reach * s, reach * c * TURNING, -reach * s * TURNING**2
        elif kind == "crank":
            q[j], v[j] = angle, TURNING
    return q, v, a


@pytest.mark.parametrize("angle", [0.4, 0.1, 0.01, np.pi + 0.2])
def test_the_level_position_is_found_where_it_is(
    machine: Machine, scaled: ScaledConstraints, angle: float
) -> None:
    """Every loop loses one constraint there, the motion is on its branch, and nothing is missed."""
    level = 0.0 if angle < 1.0 else np.pi
    ahead = (level - angle) / TURNING
    found = SingularPositions(scaled).find(
        taylor(0.0, *parallel(machine, angle)), 1.02 * ahead, branch=True
    )
    assert found is not None
    np.testing.assert_allclose(found.q, parallel(machine, level)[0], rtol=0.0, atol=1e-12)
    assert found.lost == LOOPS
    assert found.gap < 1e-13
    assert found.rate > 0.0
    # The cubic in time that the motion is continued by lacks as much.
    assert abs(found.t - ahead) < 2.0 * abs(ahead) ** 3 * TURNING**2
    assert found.astray < 0.1 * (TURNING * ahead) ** 2 + 1e-9


def test_the_rate_is_that_of_the_smallest_singular_value(
    machine: Machine, scaled: ScaledConstraints
) -> None:
    """Also per second, and between vectors of unit length."""
    at_level = parallel(machine, 0.0)
    found = SingularPositions(scaled).find(taylor(0.0, *at_level), 0.0, branch=True)
    assert found is not None
    span = 1e-5
    values = []
    for s in (-span, span):
        q = parallel(machine, TURNING * s)[0]
        values.append(scaled.weakest(0.0, q)[1])
    assert found.rate == pytest.approx((values[0] + values[1]) / (2.0 * span), rel=1e-3)


def test_weak_rows_are_those_of_small_singular_values(
    machine: Machine, scaled: ScaledConstraints
) -> None:
    """Within an angle of the level position that tells, and nowhere far from it."""
    for angle, weak in ((0.2, LOOPS), (0.02, LOOPS), (1.5, 0)):
        search = Search(scaled, PivotOrders(scaled), taylor(0.0, *parallel(machine, angle)), 5.0)
        entries = np.empty(scaled.places[0].size)
        unit_jacobian_entries(search.table, search.path.position, entries)
        values = np.linalg.svd(scaled.dense(entries), compute_uv=False)
        assert search.count_weak(0.0) == count_weak(values) == weak


def test_a_quintic_has_what_both_ends_have() -> None:
    """And is nearest to a place that it passes when it passes it."""
    t, h = 2.0, 0.3
    series = np.random.default_rng(1).normal(size=(6, 4))

    def state(s: float) -> tuple[np.ndarray, ...]:
        derivatives = [np.polynomial.polynomial.polyder(series, k) for k in range(3)]
        return tuple(np.polynomial.polynomial.polyval(s, one) for one in derivatives)

    made = hermite(t, h, state(0.0), state(h))
    np.testing.assert_allclose(made.series, series, rtol=1e-10, atol=1e-10)
    passed = Motion(t, series).scaled(np.ones(4), 1.0).series
    z = state(0.1)[0]
    assert nearest_time(passed, 0.11, z) == pytest.approx(0.1, abs=1e-6)
