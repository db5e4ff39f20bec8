"""Explicit functions of time with many kinks, poles that act or do not, and reduced coordinates."""

from collections.abc import Callable
from math import floor as whole
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Abs, Expr, Heaviside, Max, Piecewise, atan, exp, floor, log, sin

from codegen import Body, Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.explicit_time.function_scan import FunctionScan
from runtime.explicit_time.passage import Passages
from runtime.machine_facade import Machine
from runtime.mechanism.dense_equations import Equations
from runtime.validation.arguments import parameter_values

FORMULATIONS = ("cartesian", "reduced")


@pytest.fixture(scope="module")
def pendulum(workshop: Path) -> Callable[..., Machine]:
    """One pendulum or two, the first under a torque, with its angle driven by a law, or both."""

    def loaded(
        name: str, law: Expr | None = None, torque: Callable[[Body], Expr] | None = None,
        when: Expr | None = None, second: bool = True,
    ) -> Machine:  # fmt: skip
        model = Model(f"pendulum_{name}")
        b = model.body("b", 1.0, 0.1)
        model.revolute("O", model.ground.at(0, 0), b.at(-0.5, 0))
        start = {} if law is not None else {b.phi: 0.5}
        if second:
            c = model.body("c", 1.0, 0.1)
            model.revolute("A", b.at(0.5, 0), c.at(-0.5, 0))
            start[c.phi] = 0.2
        model.gravity("g", (0, -9.81))
        effects, drivers = ["g"], []
        if law is not None:
            model.driver("d", b.phi, law)
            drivers = ["d"]
        if torque is not None:
            model.torque("T", on=b, value=torque(b), **({} if when is None else {"when": when}))
            effects = ["g", "T"]
        model.scene("s", effects=effects, drivers=drivers, start=start)
        return load(model, "s", folder=workshop)

    return loaded


def test_a_jump_behind_thousands_of_kinks_ends_the_motion(pendulum: Callable[..., Machine]) -> None:
    """The law bends 12 400 times until it jumps; at every other of these the force bends too."""
    law = 0.01 * Max(0, sin(50 * t)) ** 3 + 0.5 * Heaviside(t - 390)
    machine, at = pendulum("far_jump", law, second=False), np.linspace(0, 400, 4001)
    for run in (machine.kinematics, machine.inverse_dynamics):
        result = run(at, progress=False)
        assert result.outcome is Outcome.DISCONTINUOUS
        assert "'d' jumps by 0.5 at t = 390 s" in result.message
        assert 389.9 <= result.t[-1] <= 390.0
        assert np.abs(result.series("b.phi")[0]).max() < 0.011
    machine = pendulum("far_jump_of_two", law)
    for formulation in FORMULATIONS:
        result = machine.simulate(
            400.0, at, rtol=1e-3, formulation=formulation, max_step=0.05, progress=False
        )
        assert result.outcome is Outcome.DISCONTINUOUS
        assert "'d' jumps by 0.5 at t = 390 s" in result.message
        assert np.abs(result.series("b.phi")[0]).max() < 0.011


def test_a_long_train_of_pulses_is_seen_to_its_end(workshop: Path) -> None:
    model = Model("long_train")
    p = model.particle("p", mass=1.0)
    model.force("f", p, fx=10 * exp(-((sin(5 * t) / 0.001) ** 2)))
    model.scene("s", effects=["f"])
    machine = load(model, "s", folder=workshop)
    each = 10 * sqrt(pi) * 0.001 / 5
    expected = (whole(5000.0 / pi) + 0.5) * each
    for options in ({"method": "dopri5"}, {"rtol": 1e-10}, {"accuracy": 1e-6}):
        result = machine.simulate(1000.0, [1000.0], progress=False, **options)
        assert result.v("p.vx")[-1] == pytest.approx(expected, abs=0.1 * each)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_bend_late_in_time_is_no_impact(
    pendulum: Callable[..., Machine], formulation: str
) -> None:
    """The law's rate is continuous, and at 1e4 s changes by 7e-9 within units of the clock."""
    law = Piecewise((50 * (t - 10000) ** 2, t < 10000), (100 * (t - 10000) ** 2, True))
    machine = pendulum("late_bend", law)
    result = machine.simulate(10000.05, t_start=9999.95, formulation=formulation, progress=False)
    assert result.outcome is Outcome.OK
    assert [event.what for event in result.events] == ["began"]


def test_impacts_and_events_in_reduced_coordinates(pendulum: Callable[..., Machine]) -> None:
    """A rate that jumps, and a torque that jumps only where the pendulum moves, as it did not."""
    law = 2 * t + Piecewise((0, t < 1), (0.5 * (t - 1), True))
    for machine, kinds in (
        (pendulum("snatched", law), ["impact"]),
        (pendulum("stepped", torque=lambda b: -0.2 * b.omega * floor(t)), ["began"] * 2),
    ):
        full, reduced = (
            machine.simulate(
                2.9, np.linspace(0, 2.9, 30), rtol=1e-11, formulation=f, progress=False
            )
            for f in FORMULATIONS
        )
        for result in (full, reduced):
            assert result.outcome is Outcome.OK
            assert [event.what for event in result.events] == kinds
        assert_allclose(reduced.samples.q, full.samples.q, atol=1e-8)
        assert_allclose(reduced.samples.v, full.samples.v, atol=1e-8)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_run_ends_before_a_pole_without_delay(
    pendulum: Callable[..., Machine], order: int
) -> None:
    machine = pendulum(f"pole_{order}", torque=lambda b: -0.1 * b.omega / (t - 1) ** order)
    for formulation in FORMULATIONS:
        result = machine.simulate(2.0, formulation=formulation, progress=False)
        assert result.outcome is Outcome.DISCONTINUOUS
        assert "'T' has no finite value at t = 1 s" in result.message
        assert 0.9 < result.t[-1] < 1.0
        assert result.stats["steps"] < 20_000
    driven = pendulum(
        f"driven_pole_{order}",
        0.3 * t**2,
        lambda b: -0.1 * b.omega / (t - 1) ** order,
        second=False,
    )
    result = driven.inverse_dynamics(np.linspace(0, 2, 33), progress=False)
    assert result.outcome is Outcome.DISCONTINUOUS
    assert result.t[-1] == pytest.approx(0.9375)
    positions = driven.kinematics(np.linspace(0, 2, 33), progress=False)  # which need no torque
    assert positions.outcome is Outcome.OK


def test_poles_that_do_nothing_are_passed(pendulum: Callable[..., Machine]) -> None:
    bounded = pendulum("bounded_pole", torque=lambda b: atan(b.phi + 1 / (t - 1)))
    ceased = pendulum("ceased_pole", torque=lambda b: b.omega / (t - 1) ** 2, when=t < 0.5)
    for machine in (bounded, ceased):
        result = machine.simulate(2.0, progress=False)
        assert result.outcome is Outcome.OK
        assert result.t[-1] == 2.0


def test_a_run_that_is_stuck_beside_a_law_names_it(pendulum: Callable[..., Machine]) -> None:
    """The rate of (t - 1) ln|t - 1| grows without bound, and slower than any power."""
    result = pendulum("slow_pole", (t - 1) * log(Abs(t - 1))).simulate(2.0, progress=False)
    assert result.outcome is Outcome.STEP_TOO_SMALL
    assert result.t[-1] == pytest.approx(1.0, abs=1e-6)
    assert "a function of time in 'd' bends or ends" in result.message


def test_the_first_part_of_a_law_is_looked_at_once(
    pendulum: Callable[..., Machine], monkeypatch: pytest.MonkeyPatch
) -> None:
    machine, begun = pendulum("many_kinks", 0.01 * Max(0, sin(50 * t)) ** 3, second=False), []
    look = FunctionScan.scan_next_part

    def counted(scan: FunctionScan, finest: float) -> None:
        begun.append(scan.reach)
        look(scan, finest)

    monkeypatch.setattr(FunctionScan, "scan_next_part", counted)
    equations = Equations(machine.mechanism, parameter_values(machine.mechanism, None))
    passages = Passages(equations, 0.0, 400.0, np.ones(equations.n))
    first = [part.end for part in passages.parts()]
    assert len(begun) == len(set(begun)) == len(first) > 1
    assert [part.end for part in passages.parts()] == first
    assert begun.count(0.0) == 2


def test_a_steep_end_is_where_a_run_ends(pendulum: Callable[..., Machine]) -> None:
    """Instants between the first steep one and the pole are not reached, as in a simulation."""
    machine = pendulum("steep", 0.1 / (2 - t), second=False)
    result = machine.kinematics(np.linspace(0.0, 3.0, 3001), progress=False)
    assert result.outcome is Outcome.DISCONTINUOUS
    passages = Passages(
        Equations(machine.mechanism, parameter_values(machine.mechanism, None)),
        0.0,
        3.0,
        np.ones(3),
    )
    (kink,) = next(passages.parts()).kinks
    assert kink.steep is not None
    assert result.t[-1] <= kink.steep < kink.before
