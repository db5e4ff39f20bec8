"""Reductions of series to a number, where the series jump and bend."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Piecewise

from codegen import Model, t
from runtime import Result, load
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
