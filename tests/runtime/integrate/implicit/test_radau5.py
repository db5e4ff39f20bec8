"""Radau IIA of order 5: coefficients, stages, order, dense output, stiff problems."""

import numpy as np
import pytest

from runtime.core.workspace_rows import Y0, Y1, K
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit import radau5 as c
from runtime.integrate.implicit.radau5 import POLYNOMIAL, SLOPES, STATES, A, C, accepted, restart
from runtime.integrate.problem import Options
from tests.runtime.integrate.implicit.drivers import (
    Arrays,
    predict_stages,
    radau5_propose,
    radau5_step,
    write_polynomial,
)
from tests.runtime.integrate.stiff import DRAWN, SMOOTH_PENDULUM, VAN_DER_POL, one, smooth_relay
from tests.runtime.integrate.systems import (
    integrate,
    pendulum_problem,
    pendulum_residuals,
    run_relay,
)

OMEGA = 2.0


def oscillator(t):
    return np.cos(OMEGA * t), -OMEGA * np.sin(OMEGA * t)


def slope(counts, values):
    return -np.polyfit(np.log(counts), np.log(values), 1)[0]


def test_coefficients():
    for k in (1, 2, 3):  # collocation
        np.testing.assert_allclose(c.A @ c.C ** (k - 1), c.C**k / k, atol=1e-15)
    np.testing.assert_allclose(c.T_INVERSE @ c.T, np.eye(3), atol=2e-15)
    blocks = np.array([[c.REAL, 0, 0], [0, c.COMPLEX, -c.IMAGINARY], [0, c.IMAGINARY, c.COMPLEX]])
    np.testing.assert_allclose(c.T_INVERSE @ np.linalg.inv(c.A) @ c.T, blocks, atol=2e-14)
    assert 1.0 / complex(c.COMPLEX, c.IMAGINARY) == pytest.approx(
        complex(c.C_COMPLEX, c.C_IMAGINARY), rel=1e-15
    )


def step(h, rtol=1e-6):
    """Estimate, and true error, of a step of q̈ = -4 q; in units of 1."""
    arrays = Arrays(*smooth_relay(stiffness=4.0), rtol=rtol)
    q, v = np.cos(0.3), -2.0 * np.sin(0.3)
    arrays.workspace[Y0], arrays.workspace[K] = (q, v), (v, -4.0 * q)
    assert radau5_step(arrays.table, 0.0, h) >= 0
    exact = np.cos(2.0 * h + 0.3), -2.0 * np.sin(2.0 * h + 0.3)
    allowed = arrays.rows[mem.TOLERANCE]
    size = arrays.numbers[mem.STEP_ERROR] * np.sqrt(np.mean(allowed**2))
    return size, np.abs(arrays.workspace[Y1] - exact).max()


def test_the_estimate_is_of_order_four_and_the_error_of_order_six():
    lengths = np.array([0.05, 0.07, 0.1, 0.14])
    estimates, errors = np.transpose([step(h, 1e-10) for h in lengths])
    assert np.polyfit(np.log(lengths), np.log(estimates), 1)[0] == pytest.approx(4.0, abs=0.3)
    assert np.polyfit(np.log(lengths), np.log(errors), 1)[0] == pytest.approx(6.0, abs=0.3)
    assert np.all(estimates > errors)


def test_a_stiff_error_is_filtered_twice_at_a_first_step():
    # Off the equilibrium of a stiff, strongly damped spring: an estimate that goes with h k is not
    # small, and means nothing.
    sizes = []
    for earlier_steps in (0, 1):
        arrays = Arrays(*smooth_relay(stiffness=1e8, damping=2e4))
        arrays.workspace[Y0], arrays.workspace[K] = (1e-3, 0.0), (0.0, -1e5)
        arrays.notes[mem.EQUAL], arrays.numbers[mem.H_BASE] = earlier_steps, 1e-9
        assert radau5_step(arrays.table, 0.0, 0.1) >= 0
        sizes.append(arrays.numbers[mem.STEP_ERROR])
    assert sizes[1] > 1.0
    assert sizes[0] < 0.2 * sizes[1]


@pytest.mark.parametrize(
    ("equal", "error", "rejected", "ratio"),
    [
        (0, 1e-4, 0, 9.0),
        (0, 1e-4, 1, 1.0),  # not at once after a rejection
        (0, 0.5, 0, 1.0),  # a step that could hardly grow keeps its length
        (0, 16.0, 0, 0.45),
        (1, 1e-4, 0, 4.5),  # half as long as the last one, with the same error
        (0, 1e-12, 0, 0.9 * 10**2.5),  # an error of 1e-10 counts for one that is smaller
    ],
)
def test_ratio_of_two_lengths(equal, error, rejected, ratio):
    arrays = Arrays(*smooth_relay())
    arrays.record["error"], arrays.record["safety"] = error, 0.9
    arrays.record["shrink"], arrays.record["grow"] = 1e-3, 1e3
    arrays.record["rejected_before"] = rejected
    arrays.notes[[mem.EQUAL, mem.ITERATIONS]] = equal, 1
    arrays.numbers[[mem.H_BASE, mem.ERROR_BASE]] = 2.0, error
    assert radau5_propose(arrays.table, 1.0) == pytest.approx(ratio)


def test_what_is_kept_of_a_step_and_forgotten():
    arrays, h = Arrays(*smooth_relay(constant=1.0)), 0.1
    arrays.record["patience"] = 1
    arrays.workspace[Y0], arrays.workspace[K] = (1e8, 1.0 / 3.0), (1.0 / 3.0, 1.0)
    assert radau5_step(arrays.table, 0.0, h) >= 0
    assert accepted(arrays.table, 0.0, h) == 0
    # What rounding cut off the position, whose last digit is 1e-8.
    moved = arrays.workspace[Y1, 0] - 1e8 + arrays.rows[mem.LOW, 0]
    assert moved == pytest.approx(h / 3.0 + 0.5 * h * h, rel=1e-13)
    assert abs(arrays.rows[mem.LOW, 0]) > 1e-12
    assert (arrays.numbers[mem.H_BASE], arrays.numbers[mem.ERROR_BASE]) == (h, 0.01)
    assert arrays.notes[mem.EQUAL] == arrays.notes[mem.CURRENT] == 1
    restart(arrays.table, 0.0, h)
    assert arrays.notes[mem.EQUAL] == arrays.notes[mem.CURRENT] == 0
    assert not arrays.rows[mem.LOW].any()


def test_local_order_of_dense_output():
    # Positions by a polynomial of degree 5, velocities of degree 4.
    errors, counts = [], (20, 28, 40, 57)
    for count in counts:
        h = 4.0 / count
        instants = h * np.linspace(0.05, 0.95, 19)
        r = run_relay(
            smooth_relay(stiffness=OMEGA**2), np.cos(0.3), -OMEGA * np.sin(0.3), h,
            method="radau5", fixed_step=h, t_eval=instants, tolerance=1e-13,
        )  # fmt: skip
        q, v = oscillator(instants + 0.15)
        errors.append([np.abs(r.q[:, 0] - q).max(), np.abs(r.v[:, 0] - v).max()])
    of_q, of_v = (slope(counts, column) for column in np.array(errors).T)
    assert of_q == pytest.approx(6, abs=0.3)
    assert of_v == pytest.approx(5, abs=0.3)


@pytest.mark.parametrize(("method", "most", "error_q", "error_v", "stiffness", "damping"), [
    *(("radau5", 250, 2e-6, 1e-4, k, d) for k in (1e8, 1e12) for d in (0.0, 20.0, 2e4)),
    *(("bdf", 400, 1e-6, 1e-5, k, 2.0 * np.sqrt(k)) for k in (1e4, 1e8, 1e12)),
])  # fmt: skip
def test_a_stiff_spring_costs_nothing(method, most, error_q, error_v, stiffness, damping):
    # Drawn after sin t; of Radau IIA also where it vibrates undamped, as the whole left half-plane
    # is stable. With output between the steps.
    options = Options(method=method, rtol=1e-6, t_eval=np.linspace(0.0, 10.0, 201))
    r = integrate(DRAWN, one(0.0, 1.0, 10.0, [stiffness, damping]), options)
    assert r.statistics.steps < most
    assert np.abs(r.q[:, 0] - np.sin(r.t)).max() < error_q
    assert np.abs(r.v[:, 0] - np.cos(r.t)).max() < error_v


@pytest.mark.parametrize("method", ["radau5", "bdf", "auto"])
def test_van_der_pol(method):
    # Hairer and Wanner's problem with 1e-6, in its slow time: their reference at two.
    options = Options(method=method, rtol=1e-8, atol_q=1e-8, atol_v=1e-11, t_eval=[2000.0])
    r = integrate(VAN_DER_POL, one(2.0, 0.0, 2000.0, [1000.0]), options)
    assert r.q[-1, 0] == pytest.approx(1.706167732170483, abs=1e-6)
    assert r.v[-1, 0] == pytest.approx(-0.8928097010247975e-3, abs=1e-9)
    assert r.statistics.steps < 6000  # dop853 takes some 500 000
    if method == "auto":
        assert {name for _, name in r.methods} == {"dop853", "radau5"}


@pytest.mark.parametrize("method", ["radau5", "bdf"])
def test_constraints_hold(method):
    r = integrate(
        SMOOTH_PENDULUM,
        pendulum_problem(0.3, 12.0, 20.0),
        Options(method=method, rtol=1e-6, t_eval=np.linspace(0.0, 20.0, 333)),
    )
    assert r.statistics.repartitions > 100
    # Speeds are 13 m/s, and the recovery of velocities doubles rounding twice or thrice.
    assert max(pendulum_residuals(r)) < 1e-11


def test_few_matrices_are_factored():
    r = integrate(
        SMOOTH_PENDULUM,
        pendulum_problem(0.3, 0.0, 50.0, scale=(1e3, 1e3, 1.0)),
        Options(method="radau5", rtol=1e-8),
    )
    assert r.statistics.jacobians < 0.3 * r.statistics.steps
    assert r.statistics.factorizations < 0.8 * r.statistics.steps
    assert r.statistics.iterations < 5 * r.statistics.steps


def cubic(t):
    return np.stack([1.0 + t - 2.0 * t**2 + 0.5 * t**3, 1.0 - t**3], axis=-1)


def test_without_a_past_stages_are_on_a_straight_line():
    arrays = Arrays(*smooth_relay(stiffness=1.0))
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, 2.0), (3.0, -4.0)
    predict_stages(arrays.table, 0.1)
    stages = arrays.workspace[K + STATES : K + STATES + 3]
    np.testing.assert_allclose(stages, [1.0, 2.0] + 0.1 * C[:, None] * [3.0, -4.0])


def test_a_cubic_is_continued_over_the_next_step():
    arrays, h, ratio = Arrays(*smooth_relay(stiffness=1.0)), 0.5, 1.5
    arrays.workspace[Y0], arrays.workspace[Y1] = cubic(np.array([0.0, h]))
    arrays.workspace[K + STATES : K + STATES + 3] = cubic(C * h)
    change, f2, f3 = arrays.rows[POLYNOMIAL : POLYNOMIAL + 3]
    change[:] = arrays.workspace[Y1] - arrays.workspace[Y0]
    write_polynomial(arrays.table, f2, f3)
    arrays.notes[mem.EQUAL], arrays.numbers[mem.H_BASE] = 1, h
    arrays.workspace[Y0] = arrays.workspace[Y1]
    predict_stages(arrays.table, ratio * h)
    stages = arrays.workspace[K + STATES : K + STATES + 3]
    np.testing.assert_allclose(stages, cubic(h + C * ratio * h), rtol=1e-12)


def test_stages_satisfy_the_formula():
    # q̈ = -9 q - 0.5 q̇ over a third of a turn: positions hold exactly, velocities to the tolerance.
    arrays, h = Arrays(*smooth_relay(stiffness=9.0, damping=0.5), rtol=1e-13), 0.7
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, -2.0), (-2.0, -8.0)
    assert radau5_step(arrays.table, 0.0, h) >= 0
    states = arrays.workspace[K + STATES : K + STATES + 3]
    rates = states @ np.array([[0.0, -9.0], [1.0, -0.5]])
    np.testing.assert_allclose(states[:, 0], 1.0 + h * A @ states[:, 1], rtol=1e-14)
    np.testing.assert_allclose(states[:, 1], -2.0 + h * A @ rates[:, 1], rtol=1e-10)
    slopes = arrays.workspace[K + SLOPES : K + SLOPES + 3]
    np.testing.assert_allclose(slopes[:, 1], rates[:, 1], rtol=1e-9)
    assert np.array_equal(arrays.workspace[Y1], states[2])
