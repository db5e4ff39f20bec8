"""BDF: what a step solves for and errs by, order of each, changes of step and partition."""

from math import comb

import numpy as np
import pytest
from numba import njit

from runtime.core.outcomes import Outcome
from runtime.core.workspace_rows import ATOL, ROWS, Y0, Y1, K
from runtime.integrate import loop as driver
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.bdf import accepted, restart
from runtime.integrate.implicit.bdf_history import AHEAD, ALPHA, DIFFERENCE, GAMMA, KAPPA, NOW, PAST
from runtime.integrate.problem import Options, Problem
from runtime.integrate.run import Run
from runtime.integrate.step import Signal, take_trial_step
from tests.runtime.integrate.implicit.drivers import Arrays, bdf_evaluate, bdf_propose, bdf_step
from tests.runtime.integrate.stiff import DRAWN, SMOOTH_PENDULUM, one, smooth_relay
from tests.runtime.integrate.systems import integrate, pendulum_problem, run_relay

OMEGA = 2.0


def oscillator(t):
    return np.array([np.cos(OMEGA * t), -OMEGA * np.sin(OMEGA * t)])


@njit
def _attempt(table, t, h):
    return take_trial_step(table, t, h)


class Stepper:
    """One formula with its past from the solution, at a step that stays."""

    def __init__(self, order, h):
        system, p = smooth_relay(stiffness=OMEGA**2)
        q, v = oscillator(0.0)
        options = Options(method="bdf", rtol=1e-13, atol_q=1e-13, atol_v=1e-13)
        self.run = Run(
            system, Problem(0.0, 1e3, np.array([q]), np.array([v]), p, np.ones(1)), options
        )
        self.run.start()
        arrays = self.run.state.wiring.arrays
        rows = arrays["method_floats"][mem.NUMBERS : mem.NUMBERS + 2 * mem.ROWS].reshape(-1, 2)
        past = np.array([oscillator(-i * h) for i in range(7)])
        for j in range(7):
            rows[PAST + j] = sum((-1) ** i * comb(j, i) * past[i] for i in range(j + 1))
        arrays["method_floats"][mem.H_BASE] = h
        arrays["method_integers"][[mem.STEP_ORDER, mem.NEXT_ORDER]] = order
        self.h, self.t = h, 0.0

    def step(self):
        table = self.run.state.table
        _attempt(table, self.t, self.h)
        accepted(table, self.t, self.h)
        self.t += self.h
        rows = self.run.state.rows.reshape(ROWS, 2)
        rows[Y0], rows[K] = rows[Y1], rows[K + 1]
        return rows[Y1].copy()


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_order_of_each_formula(order):
    errors, counts = [], np.array([200, 283, 400, 566, 800])
    for count in counts:
        stepper = Stepper(order, 2.0 / count)
        for _ in range(count):
            y = stepper.step()
        errors.append(np.abs(y - oscillator(2.0)).max())
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_step_satisfies_the_formula(order):
    # h a and h v are the differences of v and of q, with the term that makes NDF of BDF.
    stepper = Stepper(order, 0.05)
    t = stepper.h * np.arange(-order - 1, 1)
    y = np.array([*oscillator(t).T, stepper.step()])[::-1]
    differences = [
        sum((-1) ** i * comb(m, i) * y[i] for i in range(m + 1)) for m in range(order + 2)
    ]
    left = sum(differences[m] / m for m in range(1, order + 1))
    left = left - KAPPA[order] * GAMMA[order] * differences[order + 1]
    slope = np.array([y[0][1], -(OMEGA**2) * y[0][0]])
    np.testing.assert_allclose(left, stepper.h * slope, atol=2e-14)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_errors_of_the_orders_beside(order):
    # In units of a tolerance that stays: h^(k+1), and one power less and more.
    counts, errors = np.array([20, 28, 40]), []
    for count in counts:
        stepper = Stepper(order, 2.0 / count)
        stepper.run.state.record["rtol"], stepper.run.state.rows[ATOL] = 1e-6, 1e-6
        for _ in range(count):
            stepper.step()
        numbers = stepper.run.state.wiring.arrays["method_floats"]
        errors.append(numbers[[mem.LOWER, mem.STEP_ERROR, mem.HIGHER]])
    powers = [-np.polyfit(np.log(counts), np.log(e), 1)[0] for e in np.transpose(errors) if e.all()]
    expected = [order, order + 1, order + 2][order == 1 : 2 + (order < 5)]
    assert powers == pytest.approx(expected, abs=0.4)


@pytest.mark.parametrize(
    ("order", "equal", "lower", "error", "higher", "damping", "expected", "ratio"),
    [
        (3, 2, 1e-9, 1e-9, 1e-9, 1.0, 3, 1.0),  # fewer than k + 1 steps of one length
        (3, 3, 1.0, 1e-4, 1.0, 1.0, 3, 9.0),
        (3, 3, 1e-6, 1e-4, 1.0, 1.0, 2, 90.0),
        (3, 3, 1.0, 1e-4, 1e-10, 1.0, 4, 90.0),
        (3, 3, 1.0, 0.5, 1.0, 1.0, 3, 1.0),  # a step that could hardly grow keeps its length
        (3, 3, 1.0, 3.0, 2.0, 1.0, 2, 0.9),
        (1, 1, 1e-9, 1e-4, 1.0, 1.0, 1, 90.0),  # there is no order below, nor one above five
        (5, 5, 1.0, 1e-6, 1e-9, 1.0, 5, 9.0),
        (3, 3, 1.0, 1e-4, 1e-10, 0.1, 2, 0.9),  # a vibration, 1 rad a step, that order 3 would feed
        (2, 2, 1.0, 1 / 64, 1e-4, 0.1, 2, 3.6),  # and one that order 3 would feed, at 9 rad
    ],
)
def test_choice_of_order(order, equal, lower, error, higher, damping, expected, ratio):
    arrays = Arrays(*smooth_relay(), method="bdf")
    arrays.record["error"], arrays.record["safety"] = error, 0.9
    arrays.record["shrink"], arrays.record["grow"] = 1e-3, 1e3
    arrays.notes[[mem.STEP_ORDER, mem.EQUAL, mem.ITERATIONS]] = order, equal, 1
    arrays.numbers[[mem.LOWER, mem.HIGHER]] = lower, higher
    arrays.numbers[[mem.STIFFNESS, mem.DAMPING]] = 1.0, damping
    assert bdf_propose(arrays.table, 1.0) == pytest.approx(ratio)
    assert arrays.notes[mem.NEXT_ORDER] == expected


@pytest.mark.parametrize(("fixed", "following"), [(0, 2), (1, 4)])
def test_an_accepted_step_changes_the_order(fixed, following):
    arrays = Arrays(*smooth_relay(), method="bdf")
    arrays.record["fixed"], arrays.record["rejected"], arrays.record["patience"] = fixed, 7, 1
    arrays.notes[[mem.STEP_ORDER, mem.NEXT_ORDER, mem.EQUAL, mem.SETTLED]] = 3, 2, 3, 5
    assert accepted(arrays.table, 0.0, 0.1) == 0
    assert arrays.notes[[mem.STEP_ORDER, mem.EQUAL, mem.SETTLED]].tolist() == [following, 0, 6]
    assert arrays.notes[mem.REJECTED] == 7
    assert arrays.record["exponent"] == pytest.approx(1.0 / (following + 1))


def test_past_at_another_distance_is_that_of_the_same_polynomial():
    # A shorter and a longer step: errors stay those of order 5.
    errors = []
    for h in (0.02, 0.01):
        stepper = Stepper(5, h)
        for factor in (1.0, 0.37, 2.5, 1.0, 0.5, 2.0):
            stepper.h = stepper.h * factor
            stepper.step()
        errors.append(np.abs(stepper.step() - oscillator(stepper.t)).max())
    assert np.log2(errors[0] / errors[1]) > 5.0


def test_the_order_rises_from_one_to_five():
    r = run_relay(smooth_relay(stiffness=OMEGA**2), 1.0, 0.0, 20.0, method="bdf", tolerance=1e-8)
    q, v = oscillator(r.t)
    assert max(np.abs(r.q[:, 0] - q).max(), np.abs(r.v[:, 0] - v).max()) < 2e-6
    # With order 1 alone steps of about 1e-4 would be needed, with order 2 of about 3e-3.
    assert r.statistics.steps < 2500


def test_a_change_of_partition_costs_neither_order_nor_restart():
    # x or y is the independent coordinate, and changes twice a turn.
    problem = pendulum_problem(0.3, 12.0, 20.0)
    run = Run(SMOOTH_PENDULUM, problem, Options(method="bdf", rtol=1e-8, t_eval=[20.0]))
    notes, before, orders = run.state.wiring.arrays["method_integers"], 0, []
    code = Signal.GOING if run.start() == Outcome.OK else None
    while code == Signal.GOING:
        code = driver.advance(run.state.table, 1)
        run.recording.flush()
        if run.state.record["repartitions"] > before:
            before = int(run.state.record["repartitions"])
            orders.append(int(notes[mem.STEP_ORDER]))
    assert code == Outcome.OK
    assert len(orders) > 100
    # A restart would show as order 1; the order that the motion asks for is 5, at times 4.
    assert min(orders[5:]) >= 4
    assert sum(order == 5 for order in orders) > 0.9 * len(orders)
    exact = integrate(SMOOTH_PENDULUM, problem, Options(rtol=1e-13, t_eval=[20.0]))
    # An angle of 244 rad is asked for to 1e-8 of itself, and x and y follow from it.
    assert np.abs(run.state.y[0] - exact.q[-1]).max() < 1e-7 * exact.q[-1, 2]


def test_orders_that_do_not_damp_a_vibration_are_left():
    # Damped by a tenth: outside the angles of orders 3 to 5, which would feed the vibration.
    problem = one(0.0, 1.0, 10.0, [1e6, 200.0])
    r = integrate(DRAWN, problem, Options(method="bdf", rtol=1e-5, t_eval=[10.0]))
    assert abs(r.q[-1, 0] - np.sin(10.0)) < 1e-5
    assert r.statistics.rejected < 0.25 * r.statistics.steps
    assert r.statistics.steps < 1500


def first_step(h, **coefficients):
    arrays = Arrays(*smooth_relay(**coefficients), method="bdf")
    stiffness, constant = coefficients.get("stiffness", 0.0), coefficients.get("constant", 0.0)
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, 2.0), (2.0, constant - stiffness)
    restart(arrays.table, 0.0, h)
    assert bdf_step(arrays.table, 0.0, h) >= 0
    return arrays


def test_a_parabola_has_no_error():
    arrays = first_step(0.1, constant=-9.81)
    expected = 1.0 + 0.2 - 0.5 * 9.81 * 0.01, 2.0 - 0.981
    np.testing.assert_allclose(arrays.workspace[Y1], expected, rtol=1e-14)
    assert arrays.numbers[mem.STEP_ERROR] < 1e-6


def test_a_stiff_force_is_that_before_rounding():
    # A unit in the last place of the position is a force of 1e-4.
    stiffness, t, h = 1e12, 1.0, 1e-3
    arrays = Arrays(DRAWN, [stiffness, 0.0], method="bdf")
    arrays.workspace[Y0] = np.sin(t), np.cos(t)
    arrays.workspace[K] = np.cos(t), -np.sin(t)
    restart(arrays.table, t, h)
    assert bdf_step(arrays.table, t, h) >= 0
    assert bdf_evaluate(arrays.table, t + h, h / ALPHA[2]) == 0
    y, (start, ahead, difference) = arrays.workspace[Y1], arrays.rows[[NOW, AHEAD, DIFFERENCE], 0]
    force = stiffness * ((ahead + difference) - (y[0] - start))
    assert abs(force) > 1e-7
    a, p = np.zeros(1), np.array([stiffness, 0.0])
    DRAWN.accelerations(t + h, y[:1], y[1:], p, np.zeros(0, np.int64), a, np.zeros(0))
    kept = arrays.workspace[K + mem.LAST, 1]
    assert kept == pytest.approx(a[0] - force, abs=1e-3 * abs(force))


def test_the_error_of_a_vibration_falls_with_its_order():
    # From a parabola the first step is of order 2: its estimate goes with the third power.
    lengths = np.array([0.01, 0.02, 0.04])
    errors = [first_step(h, stiffness=4.0).numbers[mem.STEP_ERROR] for h in lengths]
    assert np.polyfit(np.log(lengths), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.3)
    assert errors[0] > 0.0
