"""Laws such as δ^(3/2) of a Hertzian contact, which have no number past their own switch."""

from pathlib import Path

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model
from codegen.declare.symbols import SPEED, kinds
from codegen.derive.piecewise_conditions import as_pieces, conditions
from codegen.derive.power_continuation import continue_powers
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

TEXT = """
import sympy
from codegen import Model

model = Model("hertz", gravity=(0, -9.81))
ball = model.particle("ball", mass=2.0)
depth = -ball.y
energy = 4e4 * depth ** sympy.Rational(5, 2)
model.potential("floor", sympy.Piecewise((energy, depth > 0), (0, True)))
model.force("wall", on=ball, fx=-1e5 * sympy.Max(ball.x - 1, 0) ** 1.5)
model.potential("mat", 4e4 * sympy.Max(depth, 0) ** 2.5)
model.potential("rail", 4e4 * sympy.Max(ball.x - 1, 0) ** model.parameter("n", 2.5))
start = {ball.x: 0.0, ball.y: 0.1, ball.vy: 0.0}
model.scene("drop", ["gravity", "floor"], start={**start, ball.vx: 0.0})
model.scene("throw", ["wall"], start={**start, ball.vx: 5.0})
model.scene("land", ["gravity", "mat", "rail"], start={**start, ball.vx: 5.0})
"""
_DEPTH = sympy.Symbol("d", positive=True)
STIFFNESS, MASS, G, HEIGHT = 1e5, 2.0, 9.81, 0.1


@pytest.fixture(scope="module")
def drop(workshop: Path) -> Machine:
    path = workshop / "models" / "hertz.py"
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text(encoding="utf-8") != TEXT:
        path.write_text(TEXT, encoding="utf-8")
    return load(path, "drop", folder=workshop)


@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_energy_is_kept_during_and_after_a_hertzian_contact(drop: Machine, method: str) -> None:
    t = np.linspace(0.0, 1.0, 4001)
    run = drop.simulate(1.0, t, rtol=1e-10, method=method, progress=False)  # type: ignore[arg-type]
    assert run.outcome is Outcome.OK
    assert len(run.events) == 6
    energy, y = run.energy(), run.q("ball.y")
    whole = MASS * G * HEIGHT
    assert_allclose(energy, whole, rtol=0.0, atol=1e-7 * whole)
    assert (y < 0.0).sum() > 100
    # m g (h + d) = 2/5 k d^(5/2) at the deepest, where the samples are within half a step of it.
    balance = MASS * G * (HEIGHT + _DEPTH) - 0.4 * STIFFNESS * _DEPTH**2.5
    deepest = float(sympy.nsolve(balance, _DEPTH, 0.02))
    assert_allclose(-y.min(), deepest, rtol=1e-4)
    assert_allclose(run.events[0].time, np.sqrt(2.0 * HEIGHT / G), rtol=1e-9)


def test_a_force_that_is_cut_off_by_max_goes_on_past_its_switch(
    drop: Machine, workshop: Path
) -> None:
    machine = load(workshop / "models" / "hertz.py", "throw", folder=workshop)
    run = machine.simulate(0.5, rtol=1e-10, progress=False)
    assert run.outcome is Outcome.OK
    assert_allclose(run.v("ball.vx")[-1], -5.0, rtol=1e-8)


def test_potentials_with_max_have_second_derivatives_where_they_end(
    drop: Machine, workshop: Path
) -> None:
    machine = load(workshop / "models" / "hertz.py", "land", folder=workshop)
    t = np.linspace(0.0, 1.0, 101)
    run = machine.simulate(1.0, t, rtol=1e-10, method="radau5", progress=False)
    assert run.outcome is Outcome.OK
    whole = MASS * G * HEIGHT + 0.5 * MASS * 25.0
    assert_allclose(run.energy(), whole, rtol=1e-8)
    assert_allclose(run.v("ball.vx")[-1], -5.0, rtol=1e-8)
    # At rest on the switches themselves, where the depth and its square are zero.
    still = {"ball.x": 1.0, "ball.y": 0.0, "ball.vx": 0.0, "ball.vy": 0.0}
    level = machine.simulate(0.1, start=still, rtol=1e-10, method="radau5", progress=False)
    assert level.outcome is Outcome.OK
    assert level.q("ball.y").min() < -1e-3
    assert_allclose(level.energy(), 0.0, atol=1e-8 * whole)


def test_only_what_ends_at_a_switch_is_continued() -> None:
    model = Model("m")
    ball = model.particle("ball", mass=1.0)
    x, radius = ball.x, model.parameter("R", 2.0)
    half = sympy.Rational(1, 2)

    def kept(expression: sympy.Expr) -> bool:
        return continue_powers(as_pieces(expression)) == as_pieces(expression)

    assert kept(sympy.sqrt(x - 1))
    assert kept(sympy.Piecewise((sympy.sqrt(x + 3), x > 1), (0, True)))
    assert kept(sympy.Piecewise(((x - 1) ** 2, x > 1), (0, True)))
    assert kept(sympy.Piecewise(((x - 1) ** -half, x > 1), (0, True)))
    for law in (
        sympy.Piecewise((((x - 1) / radius) ** (3 * half), x > 1), (0, True)),
        sympy.Piecewise((0, x < 1), ((3 * x - 3) ** 1.4, True)),
        sympy.Max(x - 1, 0) ** (5 * half),
        sympy.Piecewise(((x - 1) ** (radius - half), x > 1), (0, True)),
        sympy.Piecewise(((x - 1) ** (radius / 3), x > 1), (0, True)),
        sympy.Abs(x - 1) ** (half / 2),
    ):
        changed = continue_powers(as_pieces(law))
        assert changed != as_pieces(law)
        values = {radius: 2.0, **dict.fromkeys(kinds(law, type(radius)), 2.0)}
        for place in (1.0 + 1e-9, 1.5, 7.0):
            at = {**values, x: place}
            assert_allclose(float(changed.subs(at)), float(as_pieces(law).subs(at)), rtol=1e-12)
            slopes = [float(sympy.diff(f, x).subs(at)) for f in (changed, as_pieces(law))]
            assert_allclose(slopes[0], slopes[1], rtol=1e-12)


def test_no_value_changes_where_the_law_has_one() -> None:
    model = Model("m")
    ball = model.particle("ball", mass=1.0)
    x, y, v = ball.x, ball.y, ball.vx
    n, stiffness, mass = (model.parameter(name, 2.0) for name in ("n", "k", "m"))
    part = sympy.Piecewise((x, x > 0), (0, True))
    laws = (
        sympy.Piecewise((x**n, x > 0), (3 * x**n, True)),
        x**n / n + part,
        (sympy.Max(x, 0) - 1) ** n,
        sympy.Piecewise((2 * x, x > 0), (x, True)) ** n,
        sympy.Piecewise(((x / stiffness) ** n, x > 0), ((-x / stiffness) ** n, True)),
        sympy.Piecewise(((stiffness * x) ** n, x < 1), (0, True)),
        sympy.Piecewise((x**n, sympy.Or(x > 0, y > 0)), (x**n / 2, True)),
        sympy.Heaviside(x) * x**n + x**n,
        (stiffness * part) ** n,
        sympy.Abs(x) ** sympy.Rational(1, 2) * sympy.sign(x),
        sympy.Max(x, y, 0) ** n,
        sympy.Piecewise((sympy.sqrt(stiffness**2 * mass**2 + 1) * v, v > 0), (0, True)),
    )
    for law in map(as_pieces, laws):
        changed = continue_powers(law)
        for place in (-2.0, -0.5, 0.5, 2.0):
            for slope in (-3.0, 3.0):
                for side in (2.0, -1.5):
                    at = {x: place, y: side, n: 2.0, stiffness: slope, mass: 3.0, v: -place}
                    assert_allclose(float(changed.subs(at)), float(law.subs(at)), rtol=1e-14)


def test_what_has_no_value_in_its_piece_gets_none() -> None:
    model = Model("m")
    ball = model.particle("ball", mass=1.0)
    x, n, k = ball.x, model.parameter("n", 2.0), model.parameter("k", 1.0)
    root = sympy.sqrt(x - 1)

    def value(law: sympy.Expr) -> sympy.Expr:
        return continue_powers(as_pieces(law)).subs({x: 0.5, n: 1.5, k: -1.0})

    for law in (
        sympy.Piecewise((x, x > 0), (0, True)) + root,
        sympy.Piecewise((root, x > 1), (0, True)) + root,
        sympy.Piecewise((root, x < 1), (0, True)),
        sympy.Piecewise((2 * root, x > 1), (root, True)),
        sympy.Piecewise(((x - 1) ** n, x < 1), (0, True)),
        sympy.Piecewise(((k * x) ** n, x > 0), (0, True)),
        sympy.sqrt(sympy.Max(x, 0) - 1),
    ):
        assert abs(sympy.im(value(law))) > 0.1, law
    for law in (x**-n, x ** (-n - 1)):
        piece = sympy.Piecewise((law, x > 0), (0, True))
        assert continue_powers(piece) == piece


def test_what_ends_is_real_past_its_switch() -> None:
    model = Model("m")
    ball = model.particle("ball", mass=1.0)
    x, y, n, k = ball.x, ball.y, model.parameter("n", 1.5), model.parameter("k", 1.0)
    step = sympy.Piecewise((1, x > 0), (0, True))
    for law in (
        sympy.Piecewise(((x / k) ** n, sympy.And(x > 0, y > 0)), (0, True)),
        sympy.Piecewise((0, sympy.Or(x < 0, y < 0)), (x**1.5, True)),
        sympy.Piecewise((0, sympy.Not(x > 0)), (x**1.5, True)),
        (k * sympy.Piecewise((x, x > 0), (0, True))) ** n,
        k * step * x**1.5,
        sympy.Max(x, y - 3, 0) ** 1.5,
        sympy.Max(x, y - 3, y - 5, 0) ** n,
        sympy.Piecewise((SPEED**1.5 * sympy.sqrt(k), SPEED > 0), (0, True)),
    ):
        at = {y: 1.0, n: 1.5, k: 2.0}
        before, past = ({**at, x: place, SPEED: place} for place in (1e-9, -1e-9))
        pieces = as_pieces(law)
        values = [
            one.xreplace({c: c.subs(before) for c in conditions((one,))}).subs(past)
            for one in (pieces, continue_powers(pieces))
        ]
        assert not values[0].is_real, law
        assert values[1].is_real, law
        assert abs(values[1]) < 1e-12
