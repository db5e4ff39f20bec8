"""Partition, correction and conservation on a pendulum in Cartesian coordinates."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from runtime.core.kernel_abi import SIGNATURES
from runtime.core.outcomes import Outcome, Site
from runtime.integrate.method import EXPLICIT
from runtime.integrate.problem import Options
from tests.runtime.integrate.systems import (
    PENDULUM,
    PENDULUM_P,
    integrate,
    kernel,
    pendulum_accelerations,
    pendulum_problem,
    pendulum_residuals,
)

G = PENDULUM_P[3]


def swing(t):
    """Angle from the downward vertical of a pendulum of 1 m let go horizontally, at rest."""
    k = np.sin(np.pi / 4.0)
    sn, cn, _, _ = ellipj(ellipk(k * k) - np.sqrt(G) * t, k * k)
    return 2.0 * np.arcsin(k * sn), -2.0 * k * np.sqrt(G) * cn


def options(method, tolerance=1e-10, **more):
    return Options(method=method, rtol=tolerance, atol_q=tolerance, atol_v=tolerance, **more)


@pytest.mark.parametrize("correction", ["step", "stage"])
@pytest.mark.parametrize("method", EXPLICIT)
def test_pendulum_against_elliptic_functions(method, correction):
    instants = np.linspace(0.0, 10.0, 501)
    r = integrate(
        PENDULUM,
        pendulum_problem(-np.pi, 0.0, 10.0),
        options(method, 1e-11, t_eval=instants, correction=correction),
    )
    assert r.outcome == Outcome.OK
    angle, rate = swing(instants)
    np.testing.assert_allclose(r.q[:, 0], -np.sin(angle), rtol=0, atol=1e-8)
    np.testing.assert_allclose(r.q[:, 1], -np.cos(angle), rtol=0, atol=1e-8)
    np.testing.assert_allclose(r.v[:, 2], -rate, rtol=0, atol=3e-8)
    assert max(pendulum_residuals(r)) < 1e-11


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_residuals_at_steps_and_samples(method, tolerance):
    problem = pendulum_problem(0.3, 7.0, 20.0)
    for instants in (None, np.linspace(0.0, 20.0, 999)):
        r = integrate(PENDULUM, problem, options(method, tolerance, t_eval=instants))
        assert r.outcome == Outcome.OK
        assert max(pendulum_residuals(r)) < 1e-11


@pytest.mark.parametrize("method", EXPLICIT)
def test_energy_is_kept(method):
    r = integrate(PENDULUM, pendulum_problem(0.3, 7.0, 100.0), options(method, 1e-12))
    energy = 0.5 * (r.v[:, 0] ** 2 + r.v[:, 1] ** 2) + G * r.q[:, 1]
    assert np.abs(energy - energy[0]).max() < 1e-8


@pytest.mark.parametrize("method", EXPLICIT)
def test_repartition_loses_nothing(method):
    # Full turns: x, then y, is singular as the independent coordinate, four times a turn.
    turning = pendulum_problem(0.0, 8.0, 20.0)
    held = integrate(PENDULUM, turning, options(method, 1e-11, t_eval=[20.0]))
    # With phi light, phi is the independent coordinate and stays it.
    light = pendulum_problem(0.0, 8.0, 20.0, scale=(1.0, 1.0, 1e-3))
    free = integrate(PENDULUM, light, options(method, 1e-11, t_eval=[20.0]))
    turns = free.final_q[2] / (2.0 * np.pi)
    assert turns > 15.0
    assert free.statistics.repartitions == 0
    assert free.partitions.independent.tolist() == [[False, False, True]]
    assert held.statistics.repartitions == held.partitions.t.size - 1
    assert 3.0 * turns < held.statistics.repartitions < 6.0 * turns
    assert np.all(held.partitions.independent.sum(axis=1) == 1)
    np.testing.assert_allclose(held.q, free.q, rtol=0, atol=3e-8)
    # And where it changes, the coordinate given up is the badly conditioned one.
    q = integrate(PENDULUM, turning, options(method, 1e-11, t_eval=held.partitions.t)).q
    chosen = held.partitions.independent[1:]
    slope = np.where(chosen[:, 0], np.abs(q[1:, 1]), np.abs(q[1:, 0]))
    assert np.all(slope > 0.5)


def test_a_corrected_step_moves_little():
    r = integrate(PENDULUM, pendulum_problem(np.pi, 0.0, 10.0), options("dop853"))
    assert 0.0 < r.statistics.largest_dq < 1e-8
    assert r.statistics.corrections < 3.5 * r.statistics.returns


@kernel(SIGNATURES["accelerations"])
def weak_accelerations(t, q, v, p, modes, a, lam):
    pendulum_accelerations(t, q, v, p, modes, a, lam)
    return 2 if t > 1.0 else 0


@kernel(SIGNATURES["accelerations"])
def broken_accelerations(t, q, v, p, modes, a, lam):
    pendulum_accelerations(t, q, v, p, modes, a, lam)
    if t > 1.0:
        a[0] = np.nan
    return 0


def with_accelerations(function):
    return replace(PENDULUM, accelerations=function)


def test_singular_names_the_constraint():
    r = integrate(
        with_accelerations(weak_accelerations), pendulum_problem(np.pi, 0.0, 5.0), options("dopri5")
    )
    assert r.outcome == Outcome.SINGULAR
    assert r.site is Site.NO_POSITION
    assert r.index == 1
    assert 1.0 < r.final_t < 1.2
    assert r.t[-1] == r.final_t


def test_not_finite_keeps_what_was_computed():
    r = integrate(
        with_accelerations(broken_accelerations),
        pendulum_problem(np.pi, 0.0, 5.0),
        options("dop853"),
    )
    assert r.outcome == Outcome.NOT_FINITE
    assert r.final_t == pytest.approx(1.0, abs=1e-10)
    assert max(pendulum_residuals(r)) < 1e-11


def test_redundant_constraints_are_named_at_the_start():
    p = np.array([1.0, 0.0, 0.0, 9.81])  # length 0, and both rows the same
    system = replace(PENDULUM, jacobian_rows=np.array([0, 0, 0, 0]))
    r = integrate(system, pendulum_problem(0.0, 0.0, 1.0, p), options("dop853"))
    assert r.outcome == Outcome.SINGULAR
    assert r.site is Site.START_RANK
    assert r.index == 1
    assert r.statistics.steps == 0
