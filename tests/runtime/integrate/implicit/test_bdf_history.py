"""The past of BDF: a polynomial of the formula's degree is kept, continued and interpolated."""

from fractions import Fraction
from math import comb

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from runtime.core.workspace_rows import Y0, Y1, F, K
from runtime.integrate.implicit import method_memory as mem
from runtime.integrate.implicit.bdf import restart
from runtime.integrate.implicit.bdf_history import (
    AHEAD,
    ALPHA,
    DIFFERENCE,
    GAMMA,
    NOW,
    PAST,
    PSI,
    newton_form,
)
from tests.runtime.integrate.implicit.drivers import Arrays, extend_history, extrapolate_history
from tests.runtime.integrate.stiff import smooth_relay

H = 0.1
ORDERS = pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
RATIOS = pytest.mark.parametrize("ratio", [0.37, 1.0, 2.5])


def motion(order):
    """Position and velocity, two polynomials of this degree, each on its own."""
    draw = np.random.default_rng(order)
    parts = [Polynomial(draw.normal(size=order + 1)) for _ in range(2)]
    return lambda t: np.stack([part(t) for part in parts], axis=-1)


def differences(values):
    """Backward differences 0, 1, … at the first of these values, which go back in time."""
    return np.array([
        sum((-1) ** i * comb(j, i) * values[i] for i in range(j + 1)) for j in range(len(values))
    ])  # fmt: skip


def with_past(order):
    arrays, y = Arrays(*smooth_relay(), method="bdf"), motion(order)
    arrays.rows[PAST : PAST + order + 1] = differences(y(-H * np.arange(order + 1)))
    arrays.notes[[mem.STEP_ORDER, mem.EQUAL, mem.FREEDOMS]] = order, 3, 1
    arrays.numbers[mem.H_BASE] = H
    return arrays, y


@pytest.mark.parametrize("degree", range(6))
def test_nested_form_is_the_polynomial(degree):
    powers = [Fraction(3 * i * i - 7, i + 2) for i in range(degree + 1)]
    found = newton_form(powers)
    for x in (Fraction(0), Fraction(1), Fraction(1, 3), Fraction(-5, 7)):
        value = found[-1]
        for i in range(degree - 1, -1, -1):
            value = found[i] + (x if i % 2 == 0 else 1 - x) * value
        assert value == sum(c * x**i for i, c in enumerate(powers))


@ORDERS
@RATIOS
def test_a_change_of_length_keeps_a_polynomial(order, ratio):
    arrays, y = with_past(order)
    extrapolate_history(arrays.table, ratio * H)
    expected = differences(y(-ratio * H * np.arange(order + 1)))
    np.testing.assert_allclose(arrays.rows[NOW : NOW + order + 1], expected, atol=1e-13)
    assert arrays.notes[mem.EQUAL] == (3 if ratio == 1.0 else 0)


@ORDERS
@RATIOS
def test_a_polynomial_is_continued(order, ratio):
    arrays, y = with_past(order)
    low = arrays.rows[mem.LOW] = 1e-3, -2e-3  # what rounding cut off the state
    extrapolate_history(arrays.table, ratio * H)
    np.testing.assert_allclose(arrays.workspace[Y1], y(ratio * H) + low, atol=1e-13)
    np.testing.assert_allclose(arrays.rows[AHEAD], y(ratio * H) + low - y(0.0), atol=1e-13)
    psi = GAMMA[: order + 1] @ arrays.rows[NOW : NOW + order + 1] / ALPHA[order]
    np.testing.assert_allclose(arrays.rows[PSI], psi, rtol=1e-12)


@ORDERS
def test_a_step_becomes_the_newest_of_the_past(order):
    arrays, y = with_past(order)
    extrapolate_history(arrays.table, 0.37 * H)
    rest = arrays.rows[DIFFERENCE] = 1e-3, 2e-3  # a step that leaves the polynomial
    arrays.workspace[Y1] = arrays.rows[NOW] + (arrays.rows[AHEAD] + rest)
    extend_history(arrays.table, 0.37 * H)
    values = y(0.37 * H * (1.0 - np.arange(order + 2)))
    values[0] += rest
    expected = differences(values)
    np.testing.assert_allclose(arrays.rows[PAST : PAST + order + 2], expected, atol=1e-13)
    assert arrays.numbers[mem.H_BASE] == 0.37 * H
    assert np.abs(arrays.rows[mem.LOW]).max() <= 2.0**-53 * np.abs(arrays.workspace[Y1]).max()


def test_what_rounding_cuts_off_is_kept():
    arrays, _ = with_past(1)
    arrays.rows[PAST : PAST + 2] = (1e8, 1.0), (1.0, 1.0)
    extrapolate_history(arrays.table, H)
    rest = arrays.rows[DIFFERENCE] = 1.0 / 3.0, 1e-9
    arrays.workspace[Y1] = arrays.rows[NOW] + (arrays.rows[AHEAD] + rest)
    extend_history(arrays.table, H)
    position = Fraction(arrays.workspace[Y1, 0]) + Fraction(arrays.rows[mem.LOW, 0])
    assert float(position - 10**8) == pytest.approx(4.0 / 3.0, rel=1e-15)
    assert arrays.workspace[Y1, 0] - 1e8 != pytest.approx(4.0 / 3.0, rel=1e-12)


@ORDERS
def test_dense_output_is_the_polynomial_through_the_ends(order):
    arrays, y = with_past(order)
    extrapolate_history(arrays.table, H)
    arrays.rows[DIFFERENCE] = arrays.workspace[Y1] - arrays.rows[NOW] - arrays.rows[AHEAD]
    extend_history(arrays.table, H)
    rows = arrays.workspace[F : F + mem.DENSE_ROWS]
    for x in (0.0, 0.3, 0.8, 1.0):
        value = rows[-1]
        for i in range(mem.DENSE_ROWS - 2, -1, -1):
            value = rows[i] + (x if i % 2 == 0 else 1.0 - x) * value
        np.testing.assert_allclose(value, y(x * H), atol=1e-13)


def test_a_start_is_a_parabola_of_positions():
    arrays = Arrays(*smooth_relay(), method="bdf")
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, 2.0), (2.0, -6.0)
    arrays.rows[:] = 7.0
    restart(arrays.table, 0.0, H)
    extrapolate_history(arrays.table, 2.0 * H)
    np.testing.assert_allclose(arrays.workspace[Y1], [1.0 + 0.4 - 0.12, 2.0 - 1.2], rtol=1e-14)
    assert arrays.notes[mem.STEP_ORDER] == 2
    assert arrays.record["exponent"] == pytest.approx(1.0 / 3.0)


@pytest.mark.parametrize(("ratio", "rejected"), [(10.2, 0), (0.5, 3)])
def test_a_past_of_no_use_is_forgotten(ratio, rejected):
    arrays, _ = with_past(4)
    arrays.workspace[Y0], arrays.workspace[K] = (1.0, 2.0), (2.0, -6.0)
    arrays.record["rejected"] = rejected
    extrapolate_history(arrays.table, ratio * H)
    h = ratio * H
    np.testing.assert_allclose(arrays.workspace[Y1], [1.0 + 2.0 * h, 2.0 - 6.0 * h], rtol=1e-14)
    assert arrays.notes[mem.STEP_ORDER] == 1
