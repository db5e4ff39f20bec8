"""Samples of a thrown body, whose motion every method integrates without error."""

from itertools import pairwise

import numpy as np
import pytest

from runtime.integrate.sampling import INTERVAL, NODES, WEIGHTS
from tests.runtime.integrate.drivers import emit, started, tried
from tests.runtime.integrate.systems import relay, relay_problem

THROWN = relay(constant=-2.0)


def sampled(t_eval, h=1.0, **options):
    system, p = THROWN
    run = started(system, relay_problem(p, 0.0, 3.0), t_eval=t_eval, **options)
    tried(run, h)
    assert emit(run.state.table, 0.0, h, h, 0) == 0
    run.recording.flush()
    return run


@pytest.mark.parametrize("instants", [[], [0.4]])
def test_a_quadrature_integrates_every_interval(instants):
    run = sampled(np.array(instants), quadrature=True)
    t, y, _ = run.recording.samples()
    edges = [0.0, *instants, 1.0]
    assert t.size == 1 + INTERVAL * (len(edges) - 1)
    total = 0.0
    for k, (low, high) in enumerate(pairwise(edges)):
        part = slice(1 + k * INTERVAL, (k + 1) * INTERVAL)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        np.testing.assert_allclose(t[part], middle + half * np.array(NODES), atol=1e-15)
        assert t[(k + 1) * INTERVAL] == high
        total += half * WEIGHTS @ y[part, 0] ** 3
    exact = np.polynomial.Polynomial([0.0, 3.0, -1.0]) ** 3
    assert total == pytest.approx(exact.integ()(1.0), rel=1e-13)
