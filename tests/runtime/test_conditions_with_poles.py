"""Conditions whose quantity has a pole, where it changes its sign without a zero."""

from collections.abc import Callable
from math import acosh, asinh, log, pi
from pathlib import Path
from typing import Any

import pytest
import sympy
from sympy import Abs, Expr, Heaviside, Max, Piecewise, cosh, exp, sign, sinh, sqrt, tan
from sympy.logic.boolalg import Boolean

from codegen import Model, t
from codegen.derive.poles_of_conditions import without_poles
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.results.result import Result

PUSH = 0.7  # N, on 1 kg that begins at x = 0 with 1 m/s


def _run(workshop: Path, name: str, act: Callable[[Model, Any], None], method: str) -> Result:
    model = Model(f"past_a_pole_{name}")
    block = model.particle("block", mass=1.0)
    model.absolute("guide", block, "y", 0.0)
    act(model, block)
    model.scene("s", ["push"], start={block.x: 0.0, block.vx: 1.0})
    return load(model, "s", folder=workshop).simulate(4.0, method=method, progress=False)


def _reached(places: tuple[float, ...], begins: bool = False) -> float:
    """Where the block is after 4 s if the push begins and ceases at these places in turn."""
    x, v, left, acts = 0.0, 1.0, 4.0, begins
    for place in (*places, float("inf")):
        a = PUSH if acts else 0.0
        ends = x + v * left + a * left**2 / 2
        if ends < place:
            return ends
        after = sqrt(v**2 + 2 * a * (place - x))
        left -= float(2 * (place - x) / (v + after))
        x, v, acts = place, float(after), not acts
    raise AssertionError


CONDITIONS: dict[str, tuple[Callable[[Any], Boolean], tuple[float, ...], bool]] = {
    "pole": (lambda x: 1 / (x - 1.234) > 0, (1.234,), False),
    "opposite": (lambda x: 1 / (x - 1.234) < 0, (1.234,), True),
    "tangent": (lambda x: tan(x + 0.2) > 0, tuple(k * pi / 2 - 0.2 for k in range(1, 6)), True),
    "cotangent": (lambda x: 1 / tan(x) < -1, (0.75 * pi, pi, 1.75 * pi, 2 * pi), False),
    "two_poles": (lambda x: 1 / (x - 1) + 1 / (x - 3) > 0, (1.0, 2.0, 3.0), False),
    "even_pole": (lambda x: 1 / (x - 2) ** 2 > 1, (1.0, 3.0), False),
    "size_below": (lambda x: x / Abs(x - 2) > 0.5, (2 / 3,), False),
    "root_below": (lambda x: 1 / sqrt(Abs(x - 2)) > 1, (1.0, 3.0), False),
    "broken_power": (lambda x: 2 / Abs(x - 2) ** 1.5 > 2, (1.0, 3.0), False),
    "kink_of_a_pole": (lambda x: Max(1 / (x - 1), 0) > 0.5, (1.0, 3.0), False),
    "size_of_a_pole": (lambda x: Abs(tan(x)) < 1, (pi / 4, 0.75 * pi, 1.25 * pi, 1.75 * pi), True),
    "exponential": (lambda x: exp(1 / (x - 2)) > 1, (2.0,), False),
    "exponential_of_tangent": (
        lambda x: exp(tan(x)) > 1,
        tuple(k * pi / 2 for k in range(1, 6)),
        True,
    ),
    "two_sizes_below": (
        lambda x: 1 / Abs(x - 1) + 1 / Abs(x - 3) > 2.5,
        (2 - (2 + 29**0.5) / 5, 2 - 0.2**0.5, 2 + 0.2**0.5, 2 + (2 + 29**0.5) / 5),
        False,
    ),
    "hyperbolic_sine": (lambda x: sinh(1 / (x - 2)) > 0.2, (2.0, 2 + 1 / asinh(0.2)), False),
    "exponential_in_a_product": (lambda x: x * exp(1 / (x - 2)) > 1, (2.0,), False),
    "exponential_of_tangent_in_a_product": (
        lambda x: (x / 1000 + 1) * exp(tan(x)) > x / 1000 + 1,
        tuple(k * pi / 2 for k in range(1, 6)),
        True,
    ),
    "hyperbolic_sine_in_a_product": (
        lambda x: (x / 1000 + 1) * sinh(1 / (x - 2)) > 0.2 * (x / 1000 + 1),
        (2.0, 2 + 1 / asinh(0.2)),
        False,
    ),
    "hyperbolic_cosine": (  # its pole is no event
        lambda x: (x + 1) * cosh(1 / (x - 2)) > 2 * (x + 1),
        (2 - 1 / acosh(2), 2 + 1 / acosh(2)),
        False,
    ),
    "powers_of_an_exponential": (
        lambda x: exp(2 / (x - 1)) + exp(1 / (x - 1)) > 6,
        (1.0, 1 + 1 / log(2)),
        False,
    ),
}


@pytest.mark.parametrize("method", ["dop853", "bdf", "dopri5"])
@pytest.mark.parametrize("name", CONDITIONS)
def test_a_condition_changes_at_its_poles(workshop: Path, name: str, method: str) -> None:
    condition, places, begins = CONDITIONS[name]

    def push(model: Model, block: Any) -> None:
        model.force("push", block, fx=PUSH, when=condition(block.x))

    run = _run(workshop, name, push, method)
    assert run.outcome is Outcome.OK
    assert run.q("block.x")[-1] == pytest.approx(_reached(places, begins), abs=1e-7)


@pytest.mark.parametrize("method", ["dop853", "bdf"])
@pytest.mark.parametrize("numerator", ["one", "position"])
def test_a_pole_in_time_is_an_event(workshop: Path, numerator: str, method: str) -> None:
    def push(model: Model, block: Any) -> None:
        top = 1.0 if numerator == "one" else block.x + 5
        model.force("push", block, fx=PUSH, when=top / (t - 1.234) > 0)

    run = _run(workshop, f"in_time_{numerator}", push, method)
    assert run.outcome is Outcome.OK
    assert run.q("block.x")[-1] == pytest.approx(4 + PUSH * 2.766**2 / 2, abs=1e-9)


FORCES: dict[str, Callable[[Any], Expr]] = {
    "sign": lambda x: PUSH * (1 + sign(1 / (x - 2))) / 2,
    "step": lambda x: PUSH * Heaviside(1 / (x - 2)),
    "piece": lambda x: Piecewise((PUSH, 1 / (x - 2) > 0), (0, True)),
    "other_quantity": lambda x: Piecewise((PUSH, (x - 1) / (x - 2) >= 1), (0, True)),
}


@pytest.mark.parametrize("name", FORCES)
def test_a_force_steps_at_the_pole_of_its_condition(workshop: Path, name: str) -> None:
    def push(model: Model, block: Any) -> None:
        model.force("push", block, fx=FORCES[name](block.x))

    run = _run(workshop, f"in_a_force_{name}", push, "dop853")
    assert run.outcome is Outcome.OK
    assert [event.time for event in run.events] == [pytest.approx(2.0, abs=1e-12)]
    assert run.q("block.x")[-1] == pytest.approx(_reached((2.0,)), abs=1e-9)


def test_names_of_events_keep_the_condition_as_it_is_written(workshop: Path) -> None:
    def push(model: Model, block: Any) -> None:
        model.force("push", block, fx=PUSH, when=1 / (block.x - 2) > 0)

    run = _run(workshop, "by_name", push, "dop853")
    assert "1/(block_x - 2) > 0" in run.events[0].name


def test_what_has_no_pole_stays_as_it_is() -> None:
    """With its scale and its text in the file; lengths and their rates are no poles."""
    model = Model("no_pole")
    length = model.parameter("length", 2.0)
    block = model.particle("block", mass=1.0)
    x, y = block.x, block.y
    reach = sqrt(x**2 + y**2)
    rate = (x * block.vx + y * block.vy) / reach
    for g in (x / length - 1, 1 / (x**2 + 1) - 0.5, 1 / reach - 0.5, rate, tan(length) - x):
        assert without_poles(g) == g


def test_exponentials_of_poles_become_bounded_and_keep_their_signs() -> None:
    """Beyond all floats; what is no polynomial of powers of one of them stays."""
    model = Model("exponentials")
    x = model.particle("block", mass=1.0).x
    u = 1 / (x - 1)
    places = ("-1.3", "0.2", "0.998", "1.002", "1.021", "1.022", "1.4", "1.9", "2.2", "7")
    for g in (
        x * exp(u) - 1,
        x * exp(-u) * u - 1,
        1 / (x * exp(u) - 2) - 1,
        x * sinh(u) - x + cosh(2 * u),
        x * exp(u / 2) - 3 + exp(u / 3),
        1e-20 * x * exp(u) - 1,
    ):
        smooth = without_poles(g)
        assert not smooth.has(exp, sinh, cosh)
        for place in map(sympy.Rational, places):
            value = float(smooth.subs(x, float(place)))
            assert abs(value) < 1e3
            assert value * g.subs(x, place).evalf(30) > 0
    for g in (x * sqrt(exp(u) + 1) - exp(u), exp(u) + x * exp(1 / x) - 3):
        assert without_poles(g).has(exp)
