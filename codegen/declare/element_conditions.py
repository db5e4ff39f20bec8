"""Conditions of elements on the numbers that they are given: signs, ranges, sizes that fit.

One list serves twice. The build judges it for numbers and for the parameters' defaults; what
depends on parameters goes on into the generated module, and is judged before each run.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy

from codegen.declare.element import Hold, OneWay, Rigid, Sticking
from codegen.declare.symbols import Parameter, ParameterDeclaration, kinds
from codegen.parameter_conditions import ConditionRow, violated_conditions
from codegen.readers.expressions import constant_value

Numbers = Mapping[sympy.Symbol, float]
# accuracy: difference of two ratios of friction coefficients that rounding explains
ROUNDING = 1e-12


@dataclass(frozen=True)
class Condition:
    """low ≤ the first of `numbers` ≤ high, or low < it where that end is open.

    The sentence takes the numbers as arguments of `str.format`.
    """

    sentence: str
    numbers: tuple[sympy.Expr, ...]
    low: float | None = 0.0
    open: bool = False
    high: float | None = None

    @property
    def known(self) -> bool:
        """Whether no parameter changes what is bounded."""
        return bool(self.numbers[0].is_number)

    @property
    def varies(self) -> bool:
        """Whether a number changes during a run, or is no real number at all."""
        symbols = {symbol for number in self.numbers for symbol in number.free_symbols}
        real = self.numbers[0].is_extended_real is not False
        return not real or any(not isinstance(symbol, Parameter) for symbol in symbols)

    def row(self, where: str) -> ConditionRow:
        """The condition without its expressions."""
        return ConditionRow(where, self.sentence, self.low, self.open, self.high, len(self.numbers))

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


def sign_conditions(
    *values: tuple[str, sympy.Expr | None, str], positive: bool = False, advice: str = ""
) -> tuple[Condition, ...]:
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


def static_condition(kinetic: sympy.Expr, static: sympy.Expr | None) -> tuple[Condition, ...]:
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


def hold_conditions(hold: Hold | None) -> tuple[Condition, ...]:
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
