"""Where explicit functions of time bend, jump, end and crowd, against what is known by hand."""

import math
from collections.abc import Callable
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.derive.equations import derive
from codegen.lower.module_tables import time_programs
from runtime.explicit_time.function_scan import FunctionArrays
from runtime.explicit_time.instants import TimeInstants, time_instants
from runtime.explicit_time.interval_arithmetic import enclose
from runtime.mechanism.table_rows import TimeFunction

a = sp.Symbol("a")


def functions(f: sp.Expr, law: bool, **values: float) -> tuple[TimeFunction, ...]:
    model = Model("m")
    body = model.body("p", mass=1.0, inertia=1.0)
    f = sp.sympify(f).subs({sp.Symbol(k): model.parameter(k, v) for k, v in values.items()})
    if law:
        model.driver("f", body.x, f)
        model.scene("s", drivers=["f"])
    else:
        model.force("f", body.at(0, 0), fx=f)
        model.scene("s", effects=["f"])
    equations = derive(model, model.scenes["s"])
    return tuple(TimeFunction(*row) for row in time_programs(equations))


def instants(
    f: sp.Expr, t1: float, t0: float = 0.0, law: bool = False, **values: float
) -> TimeInstants:
    described: Any = SimpleNamespace(time_functions=functions(f, law, **values))
    return next(time_instants(described, np.array([*values.values()]), t0, t1))


@pytest.mark.parametrize(
    ("f", "at", "width"),
    [
        (sp.exp(-(((t - 50) / 0.1) ** 2)), 50.0, 0.1),
        (sp.exp(-(((t - 33.3) / 1e-7) ** 2)), 33.3, 1e-7),
        (1e-3 * sp.exp(-(((t - 71.9) / 1e-3) ** 2)) + 1e3 * sp.exp(-((t - 20) ** 2)), 71.9, 1e-3),
        (sp.tanh(1e4 * (t - 61)) - sp.tanh(1e4 * (t - 61.001)), 61.0005, 1e-3),
        (1 / (1 + 1e6 * (t - 47.1) ** 2), 47.1, 1e-3),
        (sp.exp(-(((t - 50) / 0.01) ** 2)) * sp.sin(300 * t), 50.0, 0.01),
        (t**2 * sp.exp(-t / 0.01), 0.02, 0.02),
        (sp.atan(1e5 * (t - 12.34)), 12.34, 1e-5),
        (sp.cos(t / 32) ** 100000, 32 * math.pi, 0.5),
        (sp.exp(-1e4 * sp.sin(t / 20) ** 2), 20 * math.pi, 0.2),
    ],
)
def test_steps_are_short_where_a_function_lives(f: sp.Expr, at: float, width: float) -> None:
    found = instants(f, 105.0)
    assert ((found.bounds > at - 2 * width) & (found.bounds < at + 2 * width)).any()
    edges = np.concatenate([[0.0], found.bounds, [105.0]])
    inside = np.searchsorted(edges, at)
    assert edges[inside] - edges[inside - 1] < 4 * width
    assert len(found.bounds) < 150
    assert not found.kinks


def test_pulses_follow_the_parameters_of_the_run() -> None:
    where, width = sp.symbols("where width")
    pulse = sp.exp(-(((t - where) / width) ** 2))
    for at, wide in ((20.0, 1.0), (80.0, 1e-4)):
        found = instants(pulse, 100.0, where=at, width=wide).bounds
        assert np.abs(found - at).min() < wide
        assert np.median(np.abs(found - at)) < 3 * wide


@pytest.mark.parametrize("f", [3 * t**2 - 1, sp.sin(300 * t) * t, sp.cos(2 * t + 1) ** 3, a * t])
def test_smooth_functions_cost_nothing(f: sp.Expr) -> None:
    assert functions(f, law=True, a=2.0) == ()


@pytest.mark.parametrize(
    ("f", "expected"),
    [
        (sp.Piecewise((t**2, t < 1), (2 * t - 1, t <= 3), (t + 2, True)), [1.0, 3.0]),
        (sp.Max(0, t - a) ** 2, [1.25]),
        (sp.Abs(sp.sin(t)) * t, [math.pi]),
        (sp.Mod(t, 0.9), [0.9, 1.8, 2.7, 3.6]),
        (sp.floor(t) + sp.ceiling(t / 2), [1.0, 2.0, 3.0, 4.0]),
        (sp.sign(t - 2) * sp.Heaviside(t - 1), [1.0, 2.0]),
        (sp.Piecewise((sp.Piecewise((1, t < 1), (2, True)), t < 3), (0, True)), [1.0, 3.0]),
        (sp.atan2(sp.sin(3 * t), sp.cos(3 * t)), [math.pi / 3, math.pi]),
        (1 / (t - 2.5), [2.5]),
        (sp.tanh(1 / (t - 1)), [1.0]),
        (sp.Piecewise((1, (t > 2) & (t < 2 + 1e-9)), (0, True)), [2.0, 2 + 1e-9]),
    ],
)
def test_kinks_are_known_to_the_clock(f: sp.Expr, expected: list[float]) -> None:
    found = instants(f, 4.0, law=True, a=1.25)
    kinks = [k for k in found.kinks if k.before > 0.0]  # at the start the run goes on behind one
    assert [k.before for k in kinks] == pytest.approx(expected, abs=4e-14)
    assert all(
        k.before < x < k.after or x == k.after == 4.0 for k, x in zip(kinks, expected, strict=True)
    )
    assert found.crowd is None


@pytest.mark.parametrize(
    ("f", "kink"),
    [
        (sp.Piecewise((0, t <= 1), (0.1 * sp.exp(-1 / (t - 1)), True)), 1.0),
        (sp.Piecewise((sp.sin(1 / (t - 1)), t < 0.5), (sp.sin(sp.S(-2)), True)), 0.5),
        (sp.Piecewise((sp.sqrt(1 - t), t < 0.5), (sp.log(t - 0.25), True)), 0.5),
    ],
)
def test_branches_that_are_not_taken_do_nothing(f: sp.Expr, kink: float) -> None:
    found = instants(f, 2.0, law=True)
    assert len(found.kinks) == 1
    assert found.kinks[0].before < kink < found.kinks[0].after
    assert found.crowd is None


@pytest.mark.parametrize("f", [sp.sin(1 / (t - 1)), sp.sign(sp.sin(1 / (t - 1)))])
@pytest.mark.parametrize("law", [True, False])
def test_changes_without_end_have_a_place(f: sp.Expr, law: bool) -> None:
    begin, end, function = instants(f, 2.0, law=law).crowd or (0.0, 0.0, -1)
    assert 0.99 < begin < 1.0
    assert end == pytest.approx(1.0, abs=1e-4)
    assert function == 0
    assert (instants(f, 2.0, 1.0, law=law).crowd or (0.0,))[0] == pytest.approx(1.0, abs=1e-9)
    assert instants(f, 0.9, law=law).crowd is None


@pytest.mark.parametrize(
    "f", [sp.sign(sp.sin(1e4 * t**2)), sp.tanh(5 * sp.sin(1e5 * t)), sp.sign(sp.sin(sp.exp(9 * t)))]
)
def test_many_changes_are_not_changes_without_end(f: sp.Expr) -> None:
    assert instants(f, 1.0).crowd is None


SMOOTH: list[Callable[[sp.Expr], sp.Expr]] = [
    *(sp.sin, sp.cos, sp.atan, sp.tanh, sp.floor, sp.Abs),
    *(lambda x: sp.exp(-(x**2)), lambda x: sp.sqrt(1 + x**2), lambda x: 1 / (2 + sp.cos(x))),
    *(lambda x: x**3, lambda x: sp.log(1 + x**2), lambda x: sp.atan2(x, 1 + x**2)),
    *(lambda x: sp.acos(sp.tanh(x)), lambda x: sp.Piecewise((x, x < 0.5), (1 - x, True))),
    *(lambda x: sp.Max(x, sp.sin(t)), lambda x: sp.sinh(sp.sin(x)), lambda x: sp.cosh(x / 9)),
    *(lambda x: sp.tan(sp.atan(x) / 2), lambda x: (1 + x**2) ** sp.Rational(4, 3)),
]


@given(st.data())
def test_bounds_hold_every_value(data: st.DataObject) -> None:
    f: sp.Expr = t
    for _ in range(data.draw(st.integers(1, 3))):
        inner = data.draw(st.sampled_from(SMOOTH))(f)
        f = data.draw(st.sampled_from([inner, 1.5 * inner - t, inner * sp.cos(2 * t)]))
    t0 = data.draw(st.floats(-3, 3))
    t1 = t0 + data.draw(st.floats(0, 2))
    value = sp.lambdify(t, f, "math")
    for function in functions(f, law=True):
        code = FunctionArrays(function.rows)
        low, high, steps = np.zeros((3, len(code.code)))
        arrays = code.code, code.numbers, np.zeros(0), code.knots, code.pieces
        enclose(*arrays, t0, t1, low, high, steps)
        for x in np.linspace(t0, t1, 7):
            there = -value(float(x))  # Φ has -f, or f with the sign taken out
            size = 1e-9 * (1.0 + abs(there))
            within = [low[-1] - size <= s * there <= high[-1] + size for s in (1.0, -1.0)]
            assert any(within)


def parts(f: sp.Expr, t1: float, law: bool = True) -> list[TimeInstants]:
    described: Any = SimpleNamespace(time_functions=functions(f, law))
    return list(time_instants(described, np.zeros(0), 0.0, t1))


def test_all_kinks_of_a_long_run_are_known_part_by_part() -> None:
    found = parts(sp.Max(0, sp.sin(50 * t)) ** 3 + sp.exp(-(((t - 990.5) / 1e-3) ** 2)), 1000.0)
    assert len(found) > 3
    assert [part.end for part in found] == sorted({part.end for part in found})
    assert found[-1].end == 1000.0
    kinks = [kink for part in found for kink in part.kinks if kink.before > 0.0]
    assert_allclose([k.before for k in kinks], np.arange(1, 15916) * math.pi / 50, atol=1e-11)
    assert all(a.after <= b.before for a, b in pairwise(kinks))
    assert all(len(part.bounds) + len(part.kinks) < 8192 for part in found)
    assert np.abs(found[-1].bounds - 990.5).min() < 1e-3


def test_a_burst_of_changes_is_not_without_end() -> None:
    few, burst = sp.sign(sp.sin(40 * t)), sp.sign(sp.sin(4e4 * t))
    found = parts(sp.Piecewise((few, t < 100), (burst, t < 101), (few, True)), 200.0)
    assert all(part.crowd is None for part in found)
    assert found[-1].end == 200.0


def test_changes_without_end_behind_many_others() -> None:
    endless = sp.sin(1 / (t - 60))
    f = sp.Piecewise((sp.Max(0, sp.sin(500 * t)), t < 50), (sp.Max(0, endless), True))
    described: Any = SimpleNamespace(time_functions=functions(f, law=True))
    for part in time_instants(described, np.zeros(0), 0.0, 100.0):
        if part.crowd is not None:
            break
    begin, end, _ = part.crowd or (0.0, 0.0, 0)
    assert 59.0 < begin < 60.0
    assert end == pytest.approx(60.0, abs=1e-3)


def test_values_that_overflow_hide_nothing() -> None:
    found = instants(1 / sp.cosh(1e4 * (t - 6.6)), 10.0)
    assert found.crowd is None
    assert np.abs(found.bounds - 6.6).min() < 1e-4
    assert len(found.bounds) < 400
