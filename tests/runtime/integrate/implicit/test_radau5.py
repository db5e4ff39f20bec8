"""Radau IIA of order 5: coefficients, order, dense output, stiff and oscillating problems."""

import numpy as np
import pytest

from runtime.integrate.implicit import radau5_coefficients as c
from runtime.integrate.problem import Options
from runtime.integrate.run import integrate
from tests.runtime.integrate.stiff import (
    DRAWN,
    SMOOTH_PENDULUM,
    VAN_DER_POL,
    one,
    smooth_relay,
)
from tests.runtime.integrate.systems import pendulum_problem, pendulum_residuals, run_relay

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


def test_order():
    errors, counts = [], (40, 57, 80, 113, 160)
    for count in counts:
        r = run_relay(
            smooth_relay(stiffness=OMEGA**2), 1.0, 0.0, 4.0, method="radau5",
            fixed_step=4.0 / count, t_eval=[4.0], tolerance=1e-12,
        )  # fmt: skip
        assert r.statistics.steps == count
        q, v = oscillator(4.0)
        errors.append(max(abs(r.q[-1, 0] - q), abs(r.v[-1, 0] - v)))
    assert slope(counts, errors) == pytest.approx(5, abs=0.15)


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


@pytest.mark.parametrize("damping", [0.0, 20.0, 2e4])
@pytest.mark.parametrize("stiffness", [1e8, 1e12])
def test_a_stiff_spring_costs_nothing(stiffness, damping):
    # Also where it vibrates undamped, as the whole left half-plane is stable; with output between
    # the steps.
    options = Options(method="radau5", rtol=1e-6, t_eval=np.linspace(0.0, 10.0, 201))
    r = integrate(DRAWN, one(0.0, 1.0, 10.0, [stiffness, damping]), options)
    assert r.statistics.steps < 250
    assert np.abs(r.q[:, 0] - np.sin(r.t)).max() < 2e-6
    assert np.abs(r.v[:, 0] - np.cos(r.t)).max() < 1e-4


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
