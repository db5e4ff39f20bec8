"""Motion on surfaces, its reactions, and what sticking friction has left of its limit."""

import numpy as np
import pytest

from runtime.core.kernel_abi import SIGNATURES
from runtime.core.kinds import SLIDING
from runtime.core.outcomes import Outcome
from runtime.integrate.method import EXPLICIT
from runtime.integrate.problem import Options, Problem
from tests.runtime.hybrid import drivers
from tests.runtime.hybrid.systems import BLOCK, SLIDER, Instant
from tests.runtime.integrate.systems import free_system, integrate, kernel, relay, run_relay

TOLERANCES = (1e-5, 1e-8, 1e-12)


def along_v(force, level=0.0, ramp=0.0):
    """v > level + ramp t, with a force while it holds."""
    return (force, 0.0, 0.0, 0.0, 1.0, -ramp, -level)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_slides_along_a_ramp_of_velocity(method, tolerance):
    # a = -1 above v = t/2, 2 below; from v = 3 it is met at t = 2, and then v = t/2.
    instants = np.linspace(0.0, 10.0, 101)
    r = run_relay(
        relay(along_v(-3.0, ramp=0.5), constant=2.0),
        0.0, 3.0, 10.0, method=method, tolerance=tolerance, t_eval=instants,
    )  # fmt: skip
    assert r.outcome == Outcome.OK
    assert r.events.direction.tolist() == [0]
    assert r.events.t[0] == pytest.approx(2.0, abs=1e-13)
    on = instants > 2.0 + 1e-9
    np.testing.assert_allclose(r.v[on, 0], 0.5 * instants[on], rtol=0, atol=1e-12)
    np.testing.assert_allclose(r.q[on, 0], 4.0 + (instants[on] ** 2 - 4.0) / 4.0, atol=1e-11)
    assert set(r.modes[on, 0]) == {SLIDING}
    assert r.statistics.steps < 40


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_slides_along_a_line_of_position_and_velocity(method, tolerance):
    # The relay of a controller: v = -q is met at t = √2 - 1, and q decays on it.
    switch = (-4.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
    instants = np.linspace(0.0, 5.0, 51)
    r = run_relay(
        relay(switch, constant=2.0),
        1.0, 0.0, 5.0, method=method, tolerance=tolerance, t_eval=instants,
    )  # fmt: skip
    met = np.sqrt(2.0) - 1.0
    assert r.events.t.tolist() == pytest.approx([met], abs=1e-14)
    on = instants > met
    expected = (1.0 - met**2) * np.exp(met - instants[on])
    np.testing.assert_allclose(r.q[on, 0], expected, atol=20 * tolerance)
    np.testing.assert_allclose(r.v[on, 0], -r.q[on, 0], atol=10 * tolerance)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_lets_go_where_one_side_does(method, tolerance):
    # a = 2 - q below v = 1, 3 less above it: carried along at v = 1 from q = 0 on, until q = 2,
    # where even the side that does not hinder has no more push.
    r = run_relay(
        relay(along_v(-3.0, level=1.0), constant=2.0, stiffness=1.0),
        0.0, 1.0, 4.0, method=method, tolerance=tolerance,
    )  # fmt: skip
    assert r.modes[1, 0] == SLIDING
    assert r.events.direction.tolist() == [-1]
    assert r.events.t[0] == pytest.approx(2.0, abs=1e-12)
    # Then q = 2 + sin(t - 2).
    assert r.final_q[0] == pytest.approx(2.0 + np.sin(2.0), abs=100 * tolerance)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_share_exactly_at_its_bound_stays(method, side):
    # At rest under ±1, the most that friction bears; an event that does nothing is no push.
    watched = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0)
    system = relay(along_v(-2.0), watched, constant=1.0 + side)
    r = run_relay(system, 0.0, 0.0, 3.0, method=method)
    assert r.outcome == Outcome.OK
    assert np.abs(r.q).max() == 0.0
    assert r.events.index.tolist() == [1]


@pytest.mark.parametrize("method", EXPLICIT)
def test_a_hold_is_torn_loose_by_the_event_of_another(method):
    # At rest under 0.5 against 1; from t = 1 on another 2 act.
    switches = along_v(-2.0), (2.0, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0)
    r = run_relay(relay(*switches, constant=1.5), 0.0, 0.0, 3.0, method=method)
    assert sorted(zip(r.events.index.tolist(), r.events.direction.tolist(), strict=True)) == [
        (0, 1),
        (1, 1),
    ]
    np.testing.assert_allclose(r.events.t, 1.0, atol=1e-14)
    assert r.final_v[0] == pytest.approx(2.0 * 1.5, abs=1e-12)


@pytest.mark.parametrize("method", EXPLICIT)
def test_a_hold_is_let_go_downwards(method):
    # The push grows with -q while it is carried along at v = -1.
    r = run_relay(
        relay(along_v(-2.0, level=-1.0), constant=1.0, stiffness=-1.0),
        0.0, -1.0, 2.0, method=method,
    )  # fmt: skip
    assert r.events.direction.tolist() == [-1]
    assert r.events.t[0] == pytest.approx(1.0, abs=1e-12)
    # Then a = 1 + q from q = -1, v = -1.
    assert r.final_q[0] == pytest.approx(-1.0 - np.sinh(1.0), abs=1e-9)


# Two carts with a spring between them and dry friction under each; a force on the first, and from
# an instant on another. p = F, w, k, r1, r2, t_on, F_on.


@kernel(SIGNATURES["accelerations"])
def carts_accelerations(t, q, v, p, modes, a, lam):
    f1 = -p[3] if modes[0] != 0 else p[3]
    f2 = -p[4] if modes[1] != 0 else p[4]
    late = p[6] if modes[2] != 0 else 0.0
    spring = p[2] * (q[1] - q[0])
    a[0] = p[0] * np.sin(p[1] * t) + spring + f1 + late
    a[1] = -spring + f2
    return 0


@kernel(SIGNATURES["switching"])
def carts_switching(t, q, v, p, g):
    g[0], g[1], g[2] = v[0], v[1], t - p[5]


@kernel(SIGNATURES["switching_rates"])
def carts_rates(t, q, v, a, p, rate):
    rate[0], rate[1], rate[2] = a[0], a[1], 1.0


def run_carts(p, t_end, **options):
    system = free_system(
        coordinates=2,
        accelerations=carts_accelerations,
        switches=3,
        switching=carts_switching,
        switching_rates=carts_rates,
        sticking=(0, 1),
    )
    problem = Problem(0.0, t_end, np.zeros(2), np.zeros(2), np.array(p), np.ones(2))
    return integrate(system, problem, Options(**options))


@pytest.mark.parametrize("method", EXPLICIT)
def test_two_hold_at_once_and_let_go_one_after_the_other(method):
    # A force of 2 from t = 1 on: the first cart goes at once, as q = 1 - cos(t - 1) with k = 1 and
    # friction 1, and the second at q = 0.5, its own friction.
    r = run_carts((0.0, 1.0, 1.0, 1.0, 0.5, 1.0, 2.0), 3.0, method=method, rtol=1e-11)
    assert r.final_modes.tolist() == [1, 1, 1]
    by_index = dict(zip(r.events.index.tolist(), r.events.t.tolist(), strict=True))
    assert by_index[0] == pytest.approx(1.0, abs=1e-14)
    assert by_index[1] == pytest.approx(1.0 + np.arccos(0.5), abs=1e-10)
    before = r.t < 1.0
    assert np.abs(r.q[before]).max() == 0.0
    # From there on the centre has the acceleration 0.25.
    late = 3.0 - by_index[1]
    together = 0.5 + np.sin(np.arccos(0.5)) * late + 0.25 * late**2
    assert r.final_q.sum() == pytest.approx(together, abs=1e-9)


@pytest.mark.parametrize("method", EXPLICIT)
def test_the_methods_and_tolerances_agree_on_stick_and_slip(method):
    p = (3.0, 1.3, 4.0, 1.0, 0.7, 100.0, 0.0)
    fine = run_carts(p, 20.0, method="dop853", rtol=1e-13)
    r = run_carts(p, 20.0, method=method, rtol=1e-9)
    assert fine.outcome == r.outcome == Outcome.OK
    assert (fine.events.direction == 0).sum() > 5
    assert r.events.index.tolist() == fine.events.index.tolist()
    assert r.events.direction.tolist() == fine.events.direction.tolist()
    np.testing.assert_allclose(r.events.t, fine.events.t, atol=1e-6)
    np.testing.assert_allclose(r.final_q, fine.final_q, atol=1e-7)


@pytest.mark.parametrize("method", EXPLICIT)
def test_samples_inside_a_hold_cost_no_accuracy(method):
    p = (3.0, 1.3, 4.0, 1.0, 0.7, 100.0, 0.0)
    plain = run_carts(p, 20.0, method=method, rtol=1e-10)
    dense = run_carts(p, 20.0, method=method, rtol=1e-10, t_eval=np.linspace(0.0, 20.0, 2001))
    assert plain.final_q.tolist() == dense.final_q.tolist()
    held = dense.modes[:, 0] == SLIDING
    assert held.sum() > 100
    assert np.abs(dense.v[held, 0]).max() < 1e-12


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
