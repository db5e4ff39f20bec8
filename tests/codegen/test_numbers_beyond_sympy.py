"""Numbers that SymPy evaluates for hours or not at all: refused by name, or read as values."""

import operator
import warnings
from collections.abc import Callable
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from pint import get_application_registry
from sympy import Pow, Rational, cos, exp, sin, sqrt

from codegen import Constraint, LinkwrightError, Model, ModelError, Statement
from codegen.declare.body import Body, Curve, Point
from codegen.declare.element import I
from codegen.declare.symbols import ModelSymbol, alpha, coordinate, t
from codegen.real_range import constant_value
from codegen.values_of_long_numbers import with_short_numbers
from tests.fuzz.campaign import OverTimeError, limited
from tests.fuzz.declarations import _build as texts

UNITS = get_application_registry()
SECONDS = 20.0  # a hang is more


def _of(function: Any, *arguments: Any) -> Any:
    return function(*arguments, evaluate=False)


REFUSED: dict[str, Callable[[], Any]] = {
    "tower": lambda: _of(Pow, 9, _of(Pow, 9, _of(Pow, 9, 9))),
    "power near one": lambda: _of(Pow, Rational(10**9 + 1, 10**9), sympy.Integer(10**9)),
    "small power": lambda: _of(Pow, Rational(2, 3), sympy.Integer(10**9)),
    "root's power": lambda: _of(Pow, 1 / sqrt(2), sympy.Integer(10**9)),
    "exponentials": lambda: _of(exp, _of(exp, _of(exp, sympy.Integer(9)))),
    "digits": lambda: Rational(10**50_000 + 1, 10**50_000),
    "digits of a fraction": lambda: Fraction(10**50_000 + 1, 10**50_000),
    "factorial": lambda: _of(sympy.factorial, sympy.Integer(10**7)),
    "binomial": lambda: _of(sympy.binomial, sympy.Integer(10**9), sympy.Integer(5 * 10**8)),
    "Catalan number": lambda: _of(sympy.catalan, sympy.Integer(10**8)),
    "Bessel function": lambda: _of(sympy.besselj, sympy.Integer(10**6), sympy.Integer(10**6)),
    "whole part": lambda: _of(sympy.floor, _of(exp, sympy.Integer(700))),
    "remainder": lambda: _of(sympy.Mod, _of(exp, sympy.Integer(700)), sympy.pi),
    "totient": lambda: _of(sympy.totient, sympy.Integer(10**40 + 7)),
    "power of a power": lambda: _of(
        Pow, _of(Pow, Rational(2, 3), sympy.Integer(5000)), sympy.Integer(5000)
    ),
    "power's exponent": lambda: _of(Pow, Rational(2, 3), _of(Pow, 10, 9)),
    "fraction's power": lambda: _of(Pow, Rational(0.1), Rational(1e6 + 0.3)),
    "hidden fraction's power": lambda: _of(
        Pow, _of(sympy.Add, sqrt(2), _of(sympy.Add, Rational(1, 2), -sqrt(2))), sympy.Integer(10**9)
    ),
    "power of a whole part": lambda: _of(Pow, 2, _of(sympy.floor, exp(50))),
}
"""No numbers that a machine can have."""
READ: dict[str, tuple[Callable[[], Any], float]] = {
    "nested roots": (lambda: _nested(100), 1.618033988749895),
    "long sum": (lambda: sympy.Add(*(sqrt(k) for k in range(2, 800))), 15070.0),
    "larger one": (lambda: _of(sympy.Max, sin(1) ** 2 + cos(1) ** 2, sympy.Integer(2)), 2.0),
    "sum's power": (lambda: (1 + sympy.pi / 10**6) ** 700, 1.00220153),
    "compound interest": (lambda: (1 + sympy.pi * Rational(0.05) / 12) ** 240, 22.6895),
    "root's sum's power": (lambda: (1 + sqrt(Rational(0.7))) ** 201, 1.174312e53),
    "sum's power's power": (lambda: ((1 + sympy.pi / 10**6) ** 700 + 1) ** 200, 2.0019e60),
    "limit of e": (lambda: (1 + sympy.pi / 10**9) ** (10**9), 23.14),
    "Bessel function far out": (lambda: sympy.besselj(0, 2000.0), 0.00709834),
    "Γ": (lambda: sympy.gamma(Rational(1, 3)), 2.678938534707747),
}
"""Numbers in a form that SymPy would expand and simplify for long."""
USES: dict[str, Callable[[Model, Body, Any], Any]] = {
    "mass": lambda m, a, e: m.body("mine", e, 1),
    "torque": lambda m, a, e: m.torque("mine", on=a, value=e),
    "driver": lambda m, a, e: m.driver("mine", a.x, e),
    "point": lambda m, a, e: m.revolute("mine", m.ground.at(0, 0), a.at(e, 0)),
    "cam": lambda m, a, e: m.cam_follower("mine", a.circle(e), m.body("b", 1, 1).circle(1)),
    "quantity": lambda m, a, e: m.torque("mine", on=a, value=UNITS.Quantity(e, "N mm")),
    "condition": lambda m, a, e: m.torque("mine", on=a, value=1, when=a.x > e),
}


def _nested(depth: int) -> Any:
    root = sqrt(2)
    for _ in range(depth):
        root = sqrt(1 + root)
    return root


def _declared(use: str, make: Callable[[], Any]) -> str:
    model = Model("m")
    a = model.body("a", 1, 1)
    try:
        with limited(SECONDS):
            USES[use](model, a, make())
            return texts(model)
    except OverTimeError:
        pytest.fail(f"takes more than {SECONDS} s")


@pytest.mark.parametrize("number", REFUSED)
@pytest.mark.parametrize("use", ["mass", "torque", "point", "condition", "cam", "quantity"])
def test_numbers_that_are_not_to_be_evaluated_are_refused_by_name(use: str, number: str) -> None:
    if use == "quantity" and "fraction" in number:
        pytest.skip("its conversion makes it a float")
    with pytest.raises(LinkwrightError) as caught:
        _declared(use, REFUSED[number])
    text = str(caught.value)
    assert "mine" in text
    assert "fails with" not in text
    assert len(text) < 2000


@pytest.mark.parametrize("number", REFUSED)
def test_an_angle_of_a_body_of_ones_own_is_read_before_its_sine_is_taken(number: str) -> None:
    model, one = Model("m"), sympy.S.One
    made = type("Turned", (Body,), {"angle": property(lambda _: REFUSED[number]())})

    def declared() -> None:
        with limited(SECONDS):
            model.add(made("mine", one, one, model.token))
            texts(model)

    try:
        with pytest.raises(LinkwrightError, match="'mine'"):
            declared()
    except OverTimeError:
        pytest.fail(f"takes more than {SECONDS} s")


@pytest.mark.parametrize("number", READ)
@pytest.mark.parametrize("use", ["mass", "torque", "driver", "condition"])
def test_long_numbers_count_as_their_values(use: str, number: str) -> None:
    make, value = READ[number]
    assert constant_value(with_short_numbers(make())) == pytest.approx(value, rel=1e-2)
    _declared(use, make)


def test_a_root_of_a_polynomial_is_a_value() -> None:
    x = sympy.Symbol("x")
    root = sympy.CRootOf(x**5 - x - 1, 0)
    assert float(with_short_numbers(root * x).subs(x, 1)) == 1.1673039782614187
    model = Model("roots")
    cam, other = model.body("cam", 1, 1), model.body("other", 1, 1)
    model.point_follower("pin", cam.polar(root), other)
    model.potential("well", sympy.Piecewise((root * cam.x**2, cam.x > 0), (0, True)))
    model.scene("run", ["well"])
    assert "CRootOf" not in texts(model)


def test_short_numbers_stay_as_they_are_written() -> None:
    for number in (sympy.pi / 3, sqrt(2) / 2, 2 * sin(1), Rational(1, 3), sympy.Float(0.1)):
        assert with_short_numbers(number * sympy.Symbol("x")) == number * sympy.Symbol("x")


@pytest.mark.parametrize("use", ["mass", "torque", "condition"])
@pytest.mark.parametrize("base", [sympy.Integer(3), sympy.pi, 1 + sqrt(2), Rational(0.3)])
@pytest.mark.parametrize(
    "exponent", [Rational(1.4), Rational(-0.7), Rational(1414214, 10**6), Rational(100.7)]
)
def test_powers_with_exponents_of_many_digits_are_read(use: str, base: Any, exponent: Any) -> None:
    power = base**exponent
    assert with_short_numbers(power * sympy.Symbol("x")) == power * sympy.Symbol("x")
    _declared(use, lambda: power)


@pytest.mark.parametrize("number", ["power near one", "small power", "power of a power"])
def test_the_message_about_an_exact_power_says_its_length(number: str) -> None:
    with pytest.raises(ModelError, match=r"is an exact power of \d\.\de\+\d\d digits"):
        _declared("torque", REFUSED[number])


class _Own(Constraint):
    kind = "own joint"

    def __init__(self, body: Body, near: Any, bindings: dict[Any, Any]) -> None:
        self.name, self.body, self._near, self.bindings = "mine", body, near, bindings

    @property
    def bodies(self) -> tuple[Body, ...]:
        return (self.body,)

    def problems(self) -> list[str]:
        return []

    def near(self, known: Any) -> Any:
        return {coordinate("mine", "alpha"): self._near}

    def statement(self) -> Statement:
        alpha = coordinate("mine", "alpha")
        phi = (self.body.x - sympy.cos(alpha), self.body.y - alpha)
        own = (("along", alpha),)
        return Statement(phi, ("x", "along"), None, bindings=self.bindings, own=own)


@pytest.mark.parametrize("near", [Decimal("sNaN"), 10**400, sympy.I, "5", Decimal("Infinity")])
def test_places_that_are_no_numbers_are_refused_with_the_joints_name(near: Any) -> None:
    model = Model("m")
    model.add(_Own(model.body("a", 1, 1), near, {}))
    with pytest.raises(ModelError, match=r"own joint 'mine': its near\(\) returns"):
        texts(model)


@pytest.mark.parametrize("value", [1 + sympy.I, sympy.asin(2), sympy.gamma(sympy.Symbol("z"))])
def test_meanings_of_placeholders_are_looked_at(value: Any) -> None:
    model = Model("m")
    model.add(_Own(model.body("a", 1, 1), 0.5, {I.x: value}))
    with pytest.raises(ModelError, match="own joint 'mine'"):
        texts(model)


class _Unknown(sympy.Expr):  # type: ignore[misc]
    """A number that SymPy does not know, and whose text fails."""

    def _sympystr(self, _: Any) -> str:
        raise RuntimeError("of the user's own")


def test_a_number_of_an_own_class_is_refused_by_name() -> None:
    model = Model("m")
    a = model.body("a", 1, 1)
    model.torque("mine", on=a, value=_Unknown())
    with pytest.raises(ModelError, match="torque 'mine'"):
        texts(model)
    model = Model("m")
    a = model.body("a", 1, 1)
    model.cam_follower("mine", a.circle(1, (_Unknown(), 0)), model.body("b", 1, 1).circle(1))
    with pytest.raises(ModelError, match="curve of 'mine'"):
        texts(model)
    model = Model("m")
    a = model.body("a", 1, 1)
    model.torque("mine", on=a, value=2)
    effect = model.effects["mine"]
    object.__setattr__(effect, "forces", lambda bodies: {a.phi: _Unknown()})
    with pytest.raises(ModelError, match="mine"):
        texts(model)


def test_a_sum_of_numbers_beyond_a_float_names_an_element() -> None:
    model = Model("m")
    a = model.body("a", 1e200, 1)
    model.constraint("mine", 1e300 * a.x - 1e300 * a.y)
    with pytest.raises(ModelError, match="of 'mine'"):
        texts(model)


def _identity() -> Any:
    return sympy.Lambda(sympy.Symbol("z"), sympy.Symbol("z"))


@pytest.mark.parametrize("part", [_identity(), sympy.I, sympy.oo, sympy.nan, sympy.asin(2)])
def test_conditions_on_no_real_numbers_are_refused_by_name(part: Any) -> None:
    for compare in (operator.gt, operator.ge, operator.lt, operator.le):
        model = Model("m")
        a = model.body("a", 1, 1)
        model.generalized_force("mine", {a.phi: 1 + a.x}, when=compare(a.x, part))
        with pytest.raises(ModelError, match="force 'mine'") as caught:
            texts(model)
        assert "fails with" not in str(caught.value)


def test_comparisons_of_sound_expressions_are_those_of_any_symbol() -> None:
    model = Model("m")
    p, length = model.particle("p", 1), model.parameter("length", 2.0)
    others = (0, 1.5, length, 2 * length, sqrt(2), sympy.pi / 3, p.y, sin(p.y), exp(990 - 150 * t))
    for left in (p.x, p.vx, length, t):
        for other in others:
            for word in ("__gt__", "__ge__", "__lt__", "__le__"):
                one, plain = (getattr(of, word)(other) for of in (left, super(ModelSymbol, left)))
                assert (type(one), one) == (type(plain), plain)


@pytest.mark.parametrize("number", ["small power", "power near one", "digits", "binomial"])
@pytest.mark.parametrize("make", [Point, Body.at, Curve, Body.curve])
def test_places_of_points_and_curves_are_not_multiplied_out(make: Any, number: str) -> None:
    words = ("x", "y", "vx", "vy", "own_velocity") if make in (Point, Body.at) else ("",)
    model = Model("m")
    for body in (model.ground, model.body("mine", 1, 1)):
        for pair in ((REFUSED[number](), 1.0), (sympy.Integer(2), REFUSED[number]())):
            for word in words:
                place = make(body, *pair)
                with limited(SECONDS), pytest.raises(ModelError, match=f"body '{body.name}'"):
                    _ = getattr(place, word) if word else place.at(0.5)


@pytest.mark.parametrize("number", ["small power", "power near one", "digits", "binomial"])
@pytest.mark.parametrize("scale", [1, sympy.Symbol("x")])
def test_a_parameter_of_a_curve_is_not_multiplied_out(number: str, scale: Any) -> None:
    curve = Model("m").body("mine", 1, 1).curve(alpha**2, sympy.sin(alpha))
    huge = _of(sympy.Mul, scale, REFUSED[number]())
    with (
        limited(SECONDS),
        pytest.raises(ModelError, match=r"curve\.at: the parameter .* finite real"),
    ):
        curve.at(huge)


TINY: dict[str, Any] = {
    "Fraction": Fraction(1, 10**400),
    "Decimal": Decimal("-1e-400"),
    "Rational": Rational(1, 10**400),
    "Float": sympy.Float("1e-400"),
    "exponential": exp(-1000),
    "power": _of(Pow, Rational(1, 2), sympy.Integer(2000)),
    "sum's power": _of(Pow, sqrt(2) - 1, sympy.Integer(10**6)),
    "mpmath": mpmath.mpf("1e-400"),
    "long double": np.longdouble("1e-400"),
}


@pytest.mark.parametrize("number", TINY)
@pytest.mark.parametrize("use", ["mass", "torque", "driver", "point", "cam", "parameter", "start"])
def test_numbers_nearer_to_zero_than_any_float_are_refused_alike(use: str, number: str) -> None:
    if TINY[number] == 0:
        pytest.skip("a float of this machine, in which it is 0")
    own = {
        "parameter": lambda m, _, e: m.parameter("mine", e),
        "start": lambda m, a, e: m.scene("mine", start={a.x: e}),
    }
    model = Model("m")
    a = model.body("a", 1, 1)
    with suppress(ModelError):  # of what can be no point or curve
        (own | USES)[use](model, a, TINY[number])
    with pytest.raises(ModelError, match=r"mine.*nearer to 0 than any float"):
        texts(model)


def test_a_product_with_a_number_nearer_to_zero_than_any_float_is_refused() -> None:
    model = Model("m")
    model.torque("mine", on=model.body("a", 1, 1), value=exp(-1000) * t)
    with pytest.raises(ModelError, match=r"mine.*nearer to 0 than any float"):
        texts(model)


@pytest.mark.parametrize("radius", [1e-320, 1e-170, 0.1, 1e100])
def test_cams_of_any_size_are_measured_without_a_warning(radius: float) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _declared("cam", lambda: radius)


def test_a_condition_on_a_symbol_that_does_not_commute_is_refused_by_name() -> None:
    model = Model("m")
    body = model.body("mine", 1, 1)
    model.torque("twist", body, 1.0, when=body.x > sympy.Symbol("A", commutative=False))
    with pytest.raises(ModelError, match=r"'twist'.*when="):
        raise ModelError(model.problems)


ZEROS = [sin(1) ** 2 + cos(1) ** 2 - 1, sympy.log(6) - sympy.log(2) - sympy.log(3)]


@pytest.mark.parametrize("zero", [sign * zero for zero in ZEROS for sign in (1, -1)], ids=str)
def test_a_sum_that_is_zero_is_read_as_zero_wherever_it_stands(zero: sympy.Expr) -> None:
    """SymPy finds no digit of it, and answers -3e-124 or the like."""
    model = Model("m")
    a = model.body("a", 1, 1)
    model.spring("s", a.at(0, 1), model.ground.at(0, 0), stiffness=zero, free_length=1)
    model.torque("t", on=a, value=zero * a.phi + 1)
    assert texts(model)
    model.body("b", zero, 1)
    with pytest.raises(ModelError, match="mass of body 'b' is 0 kg; it must be positive"):
        texts(model)
