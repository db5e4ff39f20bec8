"""Machines in space pass positions in which their motions cross, on the smooth branch."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from codegen import Model
from runtime import load
from runtime.core.outcomes import Outcome
from tests.space.machines import DOWN, X, Y

PIVOT, ARM, INERTIA, MASS = float(np.hypot(0.1, 0.12)), 0.08, 1e-3, 0.5
BEGIN = float(np.pi / 2 - np.arctan2(0.12, 0.1))  # the crank's angle from the change point, rad


def place(angle: float) -> float:
    """The slider's x by the crank's angle, on the branch that is smooth."""
    return float(2 * np.sqrt(ARM * PIVOT) * np.sin(angle / 2))


def change_point_crank() -> Model:
    """The rod is as long as the pivot's distance and the arm: it comes to lie across the guide."""
    model = Model("change_point_crank", space=True, gravity=DOWN)
    axes = (np.pi / 2, 0, 0)
    crank = model.body("crank", 0.12, (INERTIA, 1e-4, 1e-3), at=(0, 0.1, 0.12), axes=axes)
    drawn = (place(BEGIN), 0, 0)
    slider = model.body("slider", MASS, (1e-4,) * 3, at=drawn)
    model.revolute("A", model.ground, crank, at=(0, 0.1, 0.12), axis=X)
    model.distance("rod", crank.at(0, ARM, 0), slider, model.parameter("l", PIVOT + ARM, "m"))
    model.translational("guide", model.ground, slider, at=drawn, axis=X)
    model.scene("run", ["gravity"], start={"crank.omega_x": 6.0})
    return model


def time_until(end: float) -> float:
    """When the crank has an angle, as nothing does work."""

    def inertia(angle: float) -> float:
        return INERTIA + MASS * ARM * PIVOT * float(np.cos(angle / 2)) ** 2

    energy = inertia(BEGIN) * 6.0**2
    return quad(lambda angle: np.sqrt(inertia(angle) / energy), BEGIN, end, epsabs=1e-13)[0]


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_slider_passes_the_change_point(method: str, workshop: Path) -> None:
    machine = load(change_point_crank(), folder=workshop)
    result = machine.simulate(0.9, [0.3, 0.6, 0.75, 0.9], method=method, rtol=1e-8, progress=False)
    assert result.outcome is Outcome.OK
    (passed,) = result.singular
    exact = [
        brentq(lambda end, t=t: time_until(end) - t, BEGIN, BEGIN + 9.0, xtol=1e-13)
        for t in result.t
    ]
    assert passed.time == pytest.approx(time_until(2 * np.pi), abs=1e-7)
    turned = result.rotation("crank") @ [0, 1, 0]
    angle = np.array(exact) + np.arctan2(0.12, 0.1)
    told = 1e-8 * result.stats["crossing_error"]  # of the step across, which the message has
    assert told < 1e-4
    errors = turned[:, 1:] - np.array([np.cos(angle), np.sin(angle)]).T
    assert np.abs(errors[:2]).max() < 1e-8
    assert np.abs(errors).max() < min(told, 1e-5)
    x = np.array([place(one) for one in exact])
    assert_allclose(result.q("slider.x"), x, rtol=0.0, atol=1e-6)
    assert x[0] > 0.0 > x[-1]
    assert_allclose(result.energy(), result.energy()[0], rtol=1e-5)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
@pytest.mark.parametrize("excess", [3e-13, 1e-12, 1e-11, 1e-9])
def test_a_change_point_that_is_missed_by_little_is_named(
    method: str, excess: float, workshop: Path
) -> None:
    """Also where rounding alone lets Newton's method fail before the miss is seen."""
    machine = load(change_point_crank(), folder=workshop)
    missed = machine.simulate(
        0.9, parameters={"l": (PIVOT + ARM) * (1 + excess)}, method=method, rtol=1e-9,
        progress=False,
    )  # fmt: skip
    assert missed.outcome is Outcome.SINGULAR
    assert "misses a position in which its motions cross" in missed.message


def sarrus_linkage() -> Model:
    """A table on two chains of three parallel hinges; one has unequal links."""
    model = Model("sarrus", space=True, gravity=DOWN)
    up = np.array([0.0, 0.0, 1.0])
    table = model.body("table", 2.0, (0.02, 0.02, 0.03), at=0.8 * up)
    for k, (axis, foot, lower, upper) in enumerate(((Y, 0.1, 0.6, 0.4), (X, 0.2, 0.5, 0.5))):
        along = 1.0 - up - np.abs(axis)
        low, high = foot * along, (foot + lower - upper) * along + 0.8 * up
        span = float(np.linalg.norm(high - low))
        line = (high - low) / span
        reach = (span + (lower**2 - upper**2) / span) / 2
        out = (line @ up) * along - (line @ along) * up
        knee = low + reach * line + np.sqrt(lower**2 - reach**2) * out
        links = [
            model.body(
                f"{name}{k}", 0.5, (1e-3, 0.011, 0.012), at=tuple((start + end) / 2),
                axes=(tuple(end - start), axis),
            )
            for name, start, end in (("lower", low, knee), ("upper", knee, high))
        ]  # fmt: skip
        model.revolute(f"A{k}", model.ground, links[0], at=tuple(low), axis=axis)
        model.revolute(f"B{k}", *links, at=tuple(knee), axis=axis)
        model.revolute(f"C{k}", links[1], table, at=tuple(high), axis=axis)
    model.scene("run", ["gravity"])
    return model


@pytest.mark.parametrize(("accuracy", "ends"), [(1e-4, "SINGULAR"), (1e-8, "OK")])
def test_an_accuracy_lost_at_a_singular_position_is_no_chaos(
    accuracy: float, ends: str, workshop: Path
) -> None:
    """The linkage falls flat. There the runs end, or pass, with errors that jump."""
    machine = load(sarrus_linkage(), folder=workshop)
    result = machine.simulate(1.0, accuracy=accuracy, progress=False)
    assert result.outcome is Outcome.INACCURATE
    assert [run.outcome for run in result.accuracy.runs[-2:]] == [ends] * 2
    assert not result.accuracy.chaotic
    assert "chaotic" not in result.message
    told = r"to a singular position at t = (\S+) s, where constraints of B0 become dependent: runs"
    (instant,) = re.findall(told, result.message)
    assert float(instant) == pytest.approx(0.389, abs=0.002)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
def test_parallel_cranks_stay_parallel(formulation: str, workshop: Path) -> None:
    """Two equal cranks in planes 0.2 m apart; along the base they might fold."""
    model = Model("parallel_cranks", space=True, gravity=DOWN)
    angle = 0.6
    c, s = float(np.cos(angle)), float(np.sin(angle))
    axes = ((c, 0, s), (0, 1, 0))
    a = model.body("a", 1.0, (0.02, 0.02, 0.02), at=(0.3 * c, 0, 0.3 * s), axes=axes)
    b = model.body("b", 1.5, (0.03, 0.02, 0.03), at=(0.5 + 0.3 * c, 0.2, 0.3 * s), axes=axes)
    model.revolute("A", model.ground, a, at=(0, 0, 0), axis=(0, 1, 0))
    model.revolute("B", model.ground, b, at=(0.5, 0.2, 0), axis=(0, 1, 0))
    model.distance("C", a.at(0.1, 0, 0), b.at(0.1, 0, 0))
    model.scene("run", ["gravity"], start={"a.omega_y": -9.0})
    machine = load(model, folder=workshop)
    t = np.linspace(0.0, 1.0, 11)
    result = machine.simulate(1.0, t, rtol=1e-10, formulation=formulation, progress=False)
    assert result.outcome is Outcome.OK
    assert len(result.singular) >= 2
    inertia, moment = 0.04 + 2.5 * 0.3**2, 2.5 * 0.3 * 9.81
    exact = solve_ivp(
        lambda _, y: [y[1], -moment * np.cos(y[0]) / inertia], (0.0, 1.0), [angle, 9.0],
        method="DOP853", rtol=1e-12, atol=1e-12, t_eval=t,
    ).y[0]  # fmt: skip
    for body in "ab":
        turned = result.rotation(body) @ [1, 0, 0]
        found = np.unwrap(np.arctan2(turned[:, 2], turned[:, 0]))
        assert_allclose(found, exact, rtol=0.0, atol=2e-8)
