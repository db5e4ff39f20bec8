"""Fields for the numbers of an element: how each is read, and the conditions on its value.

A field says its unit, and what is asked of it, once. `Model` reads the argument of the same name by
it. The conditions that follow from it, and others that an element states, are judged by the build
for numbers and for the parameters' defaults; what depends on parameters goes on into the generated
module, and is judged before each run. So are profiles: whether they are closed, smooth, and convex
where a follower needs it.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import lru_cache
from typing import Any, Literal, TypeVar, dataclass_transform

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.body import Curve
from codegen.declare.element import Hold, OneWay, Rigid, Sticking
from codegen.declare.symbols import Parameter, ParameterDeclaration, SignRule, alpha, kinds
from codegen.parameter_conditions import (
    ALPHAS,
    ConditionRow,
    sample_profile,
    shape_problems,
    violated_conditions,
)
from codegen.readers.expressions import constant_value
from codegen.tables.table_function import plain_function

Numbers = Mapping[sympy.Symbol, float]
# accuracy: difference of two ratios of friction coefficients that rounding explains
ROUNDING = 1e-12


@dataclass(frozen=True)
class Condition:
    """low ≤ the first of `numbers` ≤ high, or low < it where that end is open.

    The sentence takes the numbers as arguments of `str.format`. With `bulges` the numbers are
    vertices of an outline, which has to bound an area.
    """

    sentence: str
    numbers: tuple[sympy.Expr, ...]
    low: float | None = 0.0
    open: bool = False
    high: float | None = None
    bulges: tuple[tuple[float, ...], ...] = ()

    @property
    def known(self) -> bool:
        """Whether no parameter changes what is bounded."""
        bounded = self.numbers if self.bulges else self.numbers[:1]
        return all(number.is_number for number in bounded)

    @property
    def varies(self) -> bool:
        """Whether a number changes during a run, or is no real number at all."""
        symbols = {symbol for number in self.numbers for symbol in number.free_symbols}
        real = self.numbers[0].is_extended_real is not False
        return not real or any(not isinstance(symbol, Parameter) for symbol in symbols)

    def row(self, where: str) -> ConditionRow:
        """The condition without its expressions."""
        one, count = self, len(self.numbers)
        return ConditionRow(where, one.sentence, one.low, one.open, one.high, count, one.bulges)

    def problems(self, where: str, values: Numbers) -> Iterator[str]:
        """The sentence, where the condition is broken for these values of parameters."""
        numbers = [_number(number.subs(values)) for number in self.numbers]
        yield from violated_conditions([self.row(where)], numbers)

    def follows_from(self, parameters: Mapping[str, ParameterDeclaration]) -> bool:
        """Whether the rules of the parameters' own signs imply it."""
        signed = {
            symbol: sympy.Dummy(positive=True)
            if parameters[symbol.name].sign == "positive"
            else sympy.Dummy(nonnegative=True)
            for symbol in kinds(self.numbers[0], Parameter)
            if symbol.name in parameters and parameters[symbol.name].sign
        }
        value = self.numbers[0].subs(signed)
        implied = value.is_positive if self.open else value.is_nonnegative
        return self.low == 0.0 and self.high is None and bool(implied)


Conditions = tuple[Condition, ...]


def sign_conditions(
    *values: tuple[str, sympy.Expr | None, str], positive: bool = False, advice: str = ""
) -> Conditions:
    """Values, each with its word and unit, that are not negative, or positive."""
    needed = f"a {'positive number' if positive else 'number that is not negative'}{advice}"
    return tuple(
        Condition(
            f"the {word}{_shown(value)} is {{:g}}{unit and f' {unit}'}; give {needed}.",
            (value,),
            open=positive,
        )
        for word, value, unit in values
        if value is not None
    )


def static_condition(kinetic: sympy.Expr, static: sympy.Expr | None) -> Conditions:
    """A static coefficient is not below the kinetic one."""
    if static is None:
        return ()
    numbers = (static - kinetic * (1 - ROUNDING), static, kinetic)
    if all(number.is_number for number in numbers):
        text = "the static coefficient {1:g} is below the kinetic one, {2:g}; give one that is not,"
        return (Condition(f"{text} or leave static= out.", numbers),)
    text = (
        f"the static coefficient{_shown(static)} is {{1:g}}, below the kinetic one,"
        f"{_shown(kinetic) and f'{_shown(kinetic)} ='} {{2:g}}; give parameters with which it is "
        "not."
    )
    return (Condition(text, numbers),)


def hold_conditions(hold: Hold | None) -> Conditions:
    """Of friction that sticks its static coefficient, of a rigid contact restitution and scale."""
    if isinstance(hold, OneWay):
        return sign_conditions(("typical torque", sympy.sympify(hold.scale), ""), positive=True)
    if isinstance(hold, Sticking):
        return static_condition(hold.kinetic, hold.static)
    if not isinstance(hold, Rigid):
        return ()
    restitution, given = sympy.sympify(hold.restitution), _shown(sympy.sympify(hold.restitution))
    wanted = "parameters with which it is" if given else "a number"
    text = f"the restitution{given} is {{:.9g}}; give {wanted} from 0 (no rebound) to 1 (no loss)."
    scale = sign_conditions(
        ("typical force", sympy.sympify(hold.scale), "N"), positive=True,
        advice=", or leave it out for the weight of the bodies",
    )  # fmt: skip
    return (Condition(text, (restitution,), high=1.0), *scale)


def _number(value: sympy.Expr) -> float:
    """The value of an expression; NaN where it has none."""
    try:
        return constant_value(value)
    except (TypeError, ValueError, ArithmeticError):
        return float("nan")


def _shown(value: sympy.Expr) -> str:
    """An expression of parameters, after a blank; nothing for a number."""
    return "" if value.is_number else f" {value}".replace("{", "{{").replace("}", "}}")


Samples = npt.NDArray[np.float64]


def profile_problems(profile: sympy.Matrix, closed: bool, convex: bool) -> Iterator[str]:
    """Problems of x'(α), y'(α), m, with parameters at their default values.

    Only a closed curve has a range of α that is known, and is looked at along all of it.
    """
    strangers = profile.free_symbols - {alpha}
    if strangers:
        names = ", ".join(sorted(repr(s.name) for s in strangers))
        yield f"unknown symbol {names}; a profile is written in alpha and parameters."
        return
    if profile.diff(alpha).is_zero_matrix:
        yield f"{tuple(profile)} is a point, not a curve; write it in alpha."
        return
    if not closed:
        tangent = profile.diff(alpha)
        if any(a.has(alpha) for a in sympy.sqrt(tangent.dot(tangent)).atoms(sympy.Abs)):
            yield (
                f"the tangent {tuple(tangent)} of the profile {tuple(profile)} vanishes and turns "
                "round; write the line so that it goes one way, such as (1, alpha)."
            )
        return
    yield from shape_problems(sampled_profile(profile.as_immutable()), convex)


@lru_cache(16)  # of the curves of a machine, which are looked at again in each of its scenes
def sampled_profile(profile: sympy.ImmutableMatrix) -> Samples:
    """Samples of a closed curve that is written in alpha and numbers."""
    return sample_profile(lambda alphas: _sampled(derivatives(profile), tuple(alphas)))


def derivatives(profile: sympy.Matrix) -> tuple[sympy.Expr, ...]:
    """x, y and their first and second derivatives by α."""
    return (*profile, *profile.diff(alpha), *profile.diff(alpha, 2))


def pace(profile: sympy.Matrix) -> float:
    """|c'(0)|, m per rad, to three digits, for a curve written in alpha and numbers; else 1."""
    size = math.hypot(*_sampled(tuple(profile.diff(alpha)), at=(0.0,))[0])
    return float(f"{size:.3g}") if 0.0 < size < math.inf else 1.0


def places(profile: sympy.Matrix) -> Samples:
    """Points of a curve that is written in alpha and numbers, at `ALPHAS`, samples × 2."""
    return _sampled(tuple(profile))


def in_ground(curve: Curve, numbers: Mapping[sympy.Symbol, float]) -> Samples:
    """Points of a curve in the global frame for coordinates and parameters, samples × 2."""
    x, y = (float(a.subs(numbers)) for a in curve.body.position)
    c, s = (float(a.subs(numbers)) for a in curve.body.rotation)
    rotated = places(curve.at(alpha).subs(numbers)) @ np.array([[c, s], [-s, c]])
    points: Samples = rotated + np.array([x, y])
    return points


def compared(lengths: Samples) -> Samples:
    """Lengths without the digits, m, that rounding leaves to chance."""
    with np.errstate(over="ignore"):  # from 1e299 m on
        rounded: Samples = np.round(lengths, 9)
    return rounded


def outward(points: Samples) -> Samples:
    """Unit normals of a closed curve at its points, pointing out of it, samples × 2."""
    points = np.ldexp(points, -np.frexp(np.abs(points).max())[1])  # no square leaves the floats
    tangent = np.gradient(points, axis=0)
    tangent[0] = tangent[-1] = points[1] - points[-2]
    x, y = points.T
    turn = np.sign(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    normal = turn * np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    with np.errstate(invalid="ignore"):  # of a point, which other checks refuse
        normals: Samples = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return normals


def _sampled(expressions: tuple[sympy.Expr, ...], at: tuple[float, ...] = ALPHAS) -> Samples:
    """Values at parameters of the curve, samples × expressions."""
    function = plain_function([alpha], expressions)
    return np.array([function([value]) for value in at])


Axis = tuple[sympy.Expr, sympy.Expr]
"""A direction in the frame of a body, of any length but 0."""
Units = str | tuple[str, ...]
Class = TypeVar("Class", bound=type[Any])


@dataclass(frozen=True)
class Quantity:
    """How the value of a field is read, and what is asked of it; see `quantity`."""

    unit: Units | Callable[[Any], Units]
    needs: SignRule | Literal["direction"]
    binds: SignRule
    word: str
    advice: str
    function_of: Callable[[Any], tuple[sympy.Expr, ...]] | None
    is_law: bool

    def unit_of(self, element: Any) -> Units:
        """Its unit, or one a component, where it follows from the fields before it."""
        return self.unit(element) if callable(self.unit) else self.unit


def quantity(
    unit: Units | Callable[[Any], Units] = "", needs: SignRule | Literal["direction"] = "",
    binds: SignRule = "", *, default: Any = MISSING, word: str = "", advice: str = "",
    gated: bool = False, function_of: Callable[[Any], tuple[sympy.Expr, ...]] | None = None,
    is_law: bool = False,
) -> Any:  # fmt: skip
    """A field for a number, quantity or expression, or for several.

    Parameters
    ----------
    unit
        In SI, one a component; or a function that returns it for the fields before this one.
    needs
        What the build asks of the value, and each run of the parameters in it.
    binds
        The rule that a parameter which stands alone obeys from then on.
    word, advice
        What messages call it, by default its name; and what they say besides where it is wrong.
    gated
        Whether it acts only while the condition ``when`` of the declaration holds.
    function_of
        Expressions, from the fields before this one, of which a function may return the value.
    is_law
        Whether nothing but such a function will do.
    """
    read = Quantity(unit, needs, binds, word, advice, function_of, is_law)
    return field(default=default, metadata={"quantity": read, "gated": gated})


def direction() -> Any:
    """A field for an `Axis`."""
    return quantity(("m", "m"), "direction")


def ground_unless_given() -> Any:
    """A field for a body, which is the ground where the declaration gives none."""
    return field(metadata={"ground": True})


@dataclass_transform(
    eq_default=False, frozen_default=True,
    field_specifiers=(quantity, direction, ground_unless_given),
)  # fmt: skip
def shared_fields(cls: Class) -> Class:
    """A class whose fields elements inherit; a class decorator."""
    return dataclass(frozen=True, eq=False, init=False)(cls)  # type: ignore[return-value]


def field_conditions(element: Any) -> Iterator[Condition]:
    """What the fields of an element ask of their values, in their order."""
    for one in fields(element) if is_dataclass(element) else ():
        read, value = one.metadata.get("quantity"), getattr(element, one.name)
        if read is None or not read.needs or value is None:
            continue
        if read.needs == "direction":
            ux, uy = value
            text = "the axis ({1:g}, {2:g}) has no direction; give one."
            yield Condition(text, (ux**2 + uy**2, ux, uy), open=True)
            continue
        row = (read.word or one.name.replace("_", " "), value, str(read.unit_of(element)))
        yield from sign_conditions(row, positive=read.needs == "positive", advice=read.advice)
