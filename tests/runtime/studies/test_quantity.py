"""Reductions of series to a number, where the series jump and bend."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Piecewise, Rational, pi, sin

from codegen import Model, t
from runtime import Result, load
from runtime.results.motion_at_instants import with_both_sides
from runtime.studies.quantity import REDUCTIONS, Series, parse_quantity


def test_reductions_of_a_wave_are_those_of_the_curve() -> None:
    t = np.linspace(0.0, 10.0, 801)
    wave = Series(t, 3.0 + 2.0 * np.sin(4.0 * t + 0.3))
    found = {word: how.reduce(wave) for word, how in REDUCTIONS.items()}
    assert_allclose(found["max"], 5.0, rtol=1e-6)
    assert_allclose(found["min"], 1.0, rtol=1e-5)
    assert_allclose(found["range"], 4.0, rtol=1e-5)
    assert_allclose(found["peak"], 5.0, rtol=1e-6)
    assert_allclose(found["mean"], 3.0 + (np.cos(0.3) - np.cos(40.3)) / 20.0, rtol=1e-5)
    assert_allclose(found["period"], np.pi / 2.0, rtol=1e-3)
    assert_allclose(found["rate"], (wave.x[-1] - wave.x[0]) / 10.0, rtol=1e-12)
    step = Series(np.array([0.0, 1.0, 1.001, 2.0]), np.array([0.0, 1.0, 4.0, 3.9]))
    assert REDUCTIONS["max"].reduce(step) == 4.0


def test_no_parabola_lies_across_a_jump_or_a_kink() -> None:
    t = np.linspace(0.0, 1.0, 101)
    jump, kink = np.where(t < 0.503, 9.0 + t, 0.0), -np.abs(t - 0.503)
    for x in (jump, kink):
        assert REDUCTIONS["max"].reduce(Series(t, x)) == x.max()
        assert REDUCTIONS["min"].reduce(Series(t, -x)) == -x.max()
        assert REDUCTIONS["max"].reduce(Series(1.0 - t[::-1], x[::-1])) == x.max()


def feeding() -> Model:
    """A slide of 3 kg that is driven to 1 m/s and back to rest against a viscous force."""
    model = Model("feeding")
    slide = model.body("slide", mass=3.0, inertia=0.1)
    model.translational("guide", model.ground, slide, axis=(1, 0))
    speeding, slowing = (t**2, t < 0.5), (1.5 - (2.0 - t) ** 2, t < 2.0)
    travel = Piecewise(speeding, (t - 0.25, t < 1.5), slowing, (1.5, True))
    model.driver("feed", slide.x, travel)
    model.force("air", slide, fx=-slide.vx)
    model.scene("s", ["air"], ["feed"])
    return model


def cutting() -> Model:
    """A slide at 1 m/s against a force that begins at x = 0.5 m with 10 N, and falls."""
    model = Model("cutting")
    slide = model.body("slide", mass=1.0, inertia=0.1)
    model.translational("guide", model.ground, slide, axis=(1, 0))
    model.driver("feed", slide.x, 1.0 * t)
    model.force("cut", slide, fx=-10.0 * (1.5 - t), when=slide.x > 0.5)
    model.scene("s", ["cut"], ["feed"])
    return model


EXACT = {
    "feeding": (feeding, 2.5, {"max": 7.0, "min": -6.0, "peak": 7.0, "range": 13.0}),
    "cutting": (cutting, 0.7, {"max": 10.0, "peak": 10.0, "range": 10.0, "mean": 1.8 / 0.7}),
}


@pytest.mark.parametrize("analysis", ["simulate", "inverse_dynamics"])
@pytest.mark.parametrize("machine", EXACT)
def test_forces_of_driven_machines_have_the_values_on_both_sides_of_jumps(
    machine: str, analysis: str
) -> None:
    model, end, exact = EXACT[machine]
    result: Result = getattr(load(model()), analysis)(end, 101)
    found = {word: parse_quantity(f"{word}:feed.fx").read(result).value for word in exact}
    assert_allclose([*found.values()], [*exact.values()], rtol=1e-9)


def test_a_force_that_is_held_between_clock_ticks_has_its_largest_value() -> None:
    model = Model("held")
    ball = model.particle("ball", 2.0)
    model.force("push", ball, fx=model.sampled("u", 0.13, unit="N"))
    model.scene("s", ["push"], start={ball.x: 0.0, ball.vx: 0.0})
    steps = [0.0, 5.0, 8.0, 10.0, 2.0, 1.0, 3.0, 4.0]
    controllers = {"u": lambda sample: steps[round(sample.t / 0.13)]}
    result = load(model).simulate(1.0, 501, controllers=controllers)
    assert_allclose(parse_quantity("max:a(ball.x)").read(result).value, 5.0, rtol=1e-9)


@pytest.mark.parametrize("end", [1.0, 1.1, 1.3, 1.7])
@pytest.mark.parametrize("count", [51, 101, 102])
def test_both_changes_of_a_force_are_found_in_a_driven_motion(end: float, count: int) -> None:
    model = Model("pressing")
    slide = model.body("slide", mass=1.0, inertia=0.1)
    model.translational("guide", model.ground, slide, axis=(1, 0))
    model.driver("feed", slide.x, sin(2 * pi * t))
    model.force("press", slide, fx=-100.0, when=slide.x > 0.5)
    model.scene("s", ["press"], ["feed"])
    result = load(model).inverse_dynamics(end, count, progress=False)
    found = [parse_quantity(f"{word}:feed.fx").read(result).value for word in ("max", "min")]
    half = 0.5 * (2.0 * np.pi) ** 2
    assert_allclose(found, [100.0 - half, -half], rtol=1e-7)


def test_modes_that_rounding_changes_are_looked_for_a_few_times() -> None:
    model = Model("parallelogram", gravity=(0, -9.81))
    left, right, beam = (model.body(n, mass=1.0, inertia=0.1) for n in ("left", "right", "beam"))
    model.revolute("A", model.ground.at(0, 0), left.at(-0.15, 0))
    model.revolute("B", left.at(0.15, 0), beam.at(-0.35, 0))
    model.revolute("C", beam.at(0.35, 0), right.at(0.15, 0))
    model.revolute("D", right.at(-0.15, 0), model.ground.at(0.7, 0))
    model.driver("motor", left.phi, 1.0 + 0.5 * sin(3 * t))
    model.torque("drag", on=beam, value=Piecewise((-5.0, beam.omega > 0), (5.0, True)))
    guess = {left.x: 0.1, left.y: 0.1, beam.x: 0.4, beam.y: 0.25, right.x: 0.8, right.phi: 1.0}
    model.scene("s", ["gravity", "drag"], ["motor"], guess=guess)
    result = load(model).inverse_dynamics(3.0, 31, progress=False)
    assert np.diff(result.samples.modes, axis=0).any(axis=1).sum() > 3
    assert len(with_both_sides(result).t) < 30 * len(result.t)


@pytest.mark.parametrize("analysis", ["inverse_dynamics", "simulate"])
def test_a_law_that_bends_at_the_end_has_its_value_before_it(analysis: str) -> None:
    model = Model("ending")
    arm = model.body("arm", mass=1.0, inertia=1.0)
    model.revolute("pin", model.ground, arm)
    model.driver("motor", arm.phi, Piecewise((t**3 / 6, t < 1), (t / 2 - Rational(1, 3), True)))
    model.scene("s", drivers=["motor"])
    result = getattr(load(model), analysis)(1.0, 11, progress=False)
    assert_allclose(parse_quantity("max:motor.torque").read(result).value, 1.0, rtol=1e-9)
    assert_allclose(parse_quantity("mean:motor.torque").read(result).value, 0.5, rtol=1e-9)
