"""Order of the methods and of their dense outputs, tolerances, fixed steps."""

import numpy as np
import pytest

from runtime.integrate.method import EXPLICIT
from runtime.integrate.problem import Options
from tests.runtime.integrate.stiff import smooth_relay
from tests.runtime.integrate.systems import PENDULUM, integrate, pendulum_problem, relay, run_relay

OMEGA = 2.0


def oscillator(t):
    return np.cos(OMEGA * t), -OMEGA * np.sin(OMEGA * t)


def errors(method, count, instants):
    """Largest error of q and v at `instants` of an oscillator with `count` equal steps in 0..4."""
    r = run_relay(
        smooth_relay(stiffness=OMEGA**2), 1.0, 0.0, 4.0, method=method, fixed_step=4.0 / count,
        t_eval=instants, tolerance=1e-12,
    )  # fmt: skip
    assert r.statistics.steps == count
    q, v = oscillator(r.t)
    return max(np.abs(r.q[:, 0] - q).max(), np.abs(r.v[:, 0] - v).max())


def slope(counts, values):
    return -np.polyfit(np.log(counts), np.log(values), 1)[0]


@pytest.mark.parametrize(("method", "order", "counts"), [
    ("dopri5", 5, (80, 113, 160, 226, 320)),
    ("tsit5", 5, (80, 113, 160, 226, 320)),
    ("dop853", 8, (16, 20, 24, 28, 34)),
    ("radau5", 5, (40, 57, 80, 113, 160)),
])  # fmt: skip
def test_order(method, order, counts):
    measured = slope(counts, [errors(method, count, [4.0]) for count in counts])
    assert measured == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize(("method", "order", "counts"), [
    ("dopri5", 5, (40, 57, 80, 113, 160)),
    ("tsit5", 5, (40, 57, 80, 113, 160)),
    ("dop853", 8, (14, 17, 20, 24, 28)),
])  # fmt: skip
def test_local_order_of_dense_output(method, order, counts):
    # Within one step a polynomial of order p is off by h^(p + 1): 4 + 1 and 7 + 1.
    values = []
    for count in counts:
        h = 4.0 / count
        instants = h * np.linspace(0.05, 0.95, 19)
        r = run_relay(
            relay(stiffness=OMEGA**2), np.cos(0.3), -OMEGA * np.sin(0.3), h, method=method,
            fixed_step=h, t_eval=instants,
        )  # fmt: skip
        assert r.statistics.steps == 1
        exact = np.cos(OMEGA * instants + 0.3)
        exact_v = -OMEGA * np.sin(OMEGA * instants + 0.3)
        values.append(max(np.abs(r.q[:, 0] - exact).max(), np.abs(r.v[:, 0] - exact_v).max()))
    assert slope(counts, values) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("method", EXPLICIT)
def test_error_follows_the_tolerance(method):
    tolerances = 10.0 ** -np.arange(4, 11.5, 0.5)
    instants = np.linspace(0.0, 20.0, 101)
    found = []
    for tolerance in tolerances:
        r = run_relay(
            relay(stiffness=OMEGA**2), 1.0, 0.0, 20.0, method=method, tolerance=tolerance,
            t_eval=instants,
        )  # fmt: skip
        found.append(np.abs(r.q[:, 0] - oscillator(instants)[0]).max())
        assert r.statistics.rejected <= 0.1 * r.statistics.steps + 2
    assert np.polyfit(np.log(tolerances), np.log(found), 1)[0] == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("method", EXPLICIT)
def test_few_steps_are_rejected(method):
    r = integrate(
        PENDULUM,
        pendulum_problem(np.pi, 0.0, 100.0),
        Options(method=method, rtol=1e-8, atol_q=1e-8, atol_v=1e-8),
    )
    assert r.statistics.rejected < 0.1 * r.statistics.steps


@pytest.mark.parametrize("method", EXPLICIT)
def test_samples_do_not_disturb_the_steps(method):
    problem = pendulum_problem(np.pi, 0.0, 10.0)
    plain = integrate(PENDULUM, problem, Options(method=method, t_eval=[10.0]))
    dense = integrate(PENDULUM, problem, Options(method=method, t_eval=np.linspace(0.0, 10.0, 777)))
    assert plain.statistics.steps == dense.statistics.steps
    assert np.array_equal(plain.q[-1], dense.q[-1])
    assert np.array_equal(plain.v[-1], dense.v[-1])


def test_statistics_count_what_was_called():
    for method in ("dopri5", "tsit5"):
        r = run_relay(relay(stiffness=1.0), 1.0, 0.0, 4.0, method=method, fixed_step=0.5, t_eval=[])
        assert (r.statistics.steps, r.statistics.rhs) == (8, 1 + 6 * 8)
    r = run_relay(
        relay(stiffness=1.0), 1.0, 0.0, 4.0, method="dop853", fixed_step=0.5, t_eval=[0.25]
    )
    assert (r.statistics.steps, r.statistics.rhs) == (8, 1 + 12 * 8 + 3)
