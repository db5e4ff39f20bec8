"""Tolerances that nobody gave follow the size of the machine; what cannot be is refused."""

import numpy as np
import pytest

from codegen import Model
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.integrate.problem import Options, Problem
from runtime.mechanism.dense_equations import Equations, magnitudes
from tests.runtime.integrate.systems import (
    ACCURATE,
    PENDULUM,
    integrate,
    pendulum_problem,
    pendulum_residuals,
    relay,
    run_relay,
)


@pytest.fixture(scope="module")
def spring(workshop):
    """A mass on a spring, with no length but where it starts, and an arm that may carry it."""
    model = Model("small_spring")
    body = model.body("b", mass=1.0, inertia=1.0)
    gap = model.parameter("gap", 0.0, "m")
    model.force("spring", on=body, fx=-1e4 * (body.x - gap))
    model.scene("free", ["spring"])
    return load(model, "free", folder=workshop)


@pytest.mark.parametrize("method", ACCURATE)
def test_a_small_oscillator_is_as_right_as_a_large_one(spring, method):
    worst = []
    for size in (1.0, 1e-3, 1e-6):
        r = spring.simulate(0.5, method=method, rtol=1e-3, start={"b.x": size}, progress=False)
        worst.append(np.abs(r.q("b.x") / size - np.cos(100.0 * r.t)).max())
    assert max(worst) < 0.04
    np.testing.assert_allclose(worst, worst[0], rtol=0.2)


def sizes(machine, **values):
    equations = Equations(
        machine.mechanism, machine.parameter_values(values.pop("parameters", None))
    )
    q = np.zeros(equations.n)
    for place, value in values.items():
        q[machine.coordinates.names.index(place.replace("_", "."))] = value
    return dict(zip(machine.coordinates.names, magnitudes(equations, 0.0, q), strict=True))


def test_sizes_of_a_machine_without_arms(spring):
    assert sizes(spring) == {"b.x": 1.0, "b.y": 1.0, "b.phi": 1.0}
    assert sizes(spring, b_x=-2e-3) == {"b.x": 2e-3, "b.y": 2e-3, "b.phi": 1.0}
    assert sizes(spring, b_x=1e-17)["b.x"] == 1.0
    assert sizes(spring, parameters={"gap": 0.02})["b.x"] == 0.02


def test_sizes_of_a_machine_with_arms(pendulum):
    q = pendulum.assemble().q
    found = magnitudes(Equations(pendulum.mechanism, pendulum.parameter_values()), 0.0, q)
    arm = np.hypot(q[0], q[1])
    assert found[2] == 1.0
    np.testing.assert_allclose(found[:2], arm, rtol=0.3)


def test_default_tolerance_is_no_coarser_than_a_metre_would_make_it():
    system, p = relay(stiffness=1.0)
    runs = []
    for size in (1.0, 1e3):
        problem = Problem(0.0, 20.0, np.ones(1), np.zeros(1), p, np.ones(1), size)
        runs.append(integrate(system, problem, Options(rtol=1e-6)))
    given = run_relay((system, p), 1.0, 0.0, 20.0, rtol=1e-6, tolerance=1e-6)
    assert runs[0].statistics.steps == runs[1].statistics.steps == given.statistics.steps


@pytest.mark.parametrize("atol", [1e-30, 1e-20])
@pytest.mark.parametrize("correction", ["step", "stage"])
@pytest.mark.parametrize("start", [(0.3, 7.0), (0.0, 0.0), (0.0, 1.0), (-np.pi / 2, 1.0)])
def test_a_tiny_tolerance_asks_for_nothing_below_rounding(atol, correction, start):
    r = integrate(
        PENDULUM,
        pendulum_problem(*start, 5.0),
        Options(rtol=1e-2, atol_q=atol, atol_v=atol, correction=correction),
    )
    assert r.outcome == Outcome.OK
    assert max(pendulum_residuals(r)) < 1e-11
    assert r.statistics.corrections < 6 * r.statistics.returns or correction == "stage"
