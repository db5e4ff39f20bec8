"""The floor solves the problem that it is the floor of."""

import math

import numba
import numpy as np
import pytest

from benchmarks.floor import slider_crank
from benchmarks.floor.dop853 import OPTIONS, integrator


@numba.njit(**OPTIONS)
def swing(x, v, k):
    return v, -k * x


def test_the_integrator_has_its_order() -> None:
    run = integrator(swing, ("x", "v"), ("k",))
    errors, steps = [], []
    for tolerance in (1e-6, 1e-9, 1e-12):
        x, v, taken, _ = run(1.0, 0.0, 0.0, 20.0, 1e-2, tolerance, 4.0)
        errors.append(math.hypot(x - math.cos(40.0), v / 2.0 + math.sin(40.0)))
        steps.append(taken)
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert -9.5 < slope < -7.0
    assert errors[-1] < 1e-10


@pytest.mark.parametrize(("tolerance", "bar"), [(1e-9, 1e-5), (1e-12, 2e-8)])
def test_the_crank_comes_where_it_must(tolerance: float, bar: float) -> None:
    phi, steps, rejected = slider_crank.answer(tolerance)
    assert abs(phi - slider_crank.REFERENCE) < bar
    assert rejected < 0.2 * steps
