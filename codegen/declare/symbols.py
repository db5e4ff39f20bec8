"""The symbols of a declaration, distinguished by class and not by name, and derivatives by them."""

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, Literal, NamedTuple

import sympy

from codegen.declare.rotation_entries import SpinEntry
from codegen.errors import ModelError
from codegen.readers.calls import declaring
from codegen.readers.values import shown

Letter = Literal["x", "y", "phi"]
LETTERS = ("x", "y", "phi")
KEPT = 20_000  # measured: symbols that are remembered by name; SymPy remembers a thousand results
SignRule = Literal["", "positive", "nonnegative"]


class CoordinateKind(NamedTuple):
    """The kind of quantity that a coordinate measures."""

    rate: str  # letter of its velocity
    unit: str  # "m", "rad", "kg" of masses, or "1" for numbers such as Euler parameters
    neutral: float = 0.0  # value in the pose in which the body's frame is the global one

    @property
    def rate_unit(self) -> str:
        """Unit of the velocity."""
        return f"{self.unit}/s"

    @property
    def force_unit(self) -> str:
        """Unit of the generalized force, whose product with the velocity is a power."""
        return "N" if self.unit == "m" else "N m"


KINDS = {
    "x": CoordinateKind("vx", "m"),
    "y": CoordinateKind("vy", "m"),
    "phi": CoordinateKind("omega", "rad"),
    "alpha": CoordinateKind("alphadot", "rad"),
    "beta": CoordinateKind("betadot", "rad"),
    "integral": CoordinateKind("value", "1"),
    "mass": CoordinateKind("massflow", "kg", neutral=1.0),
    "inertia": CoordinateKind("inertiaflow", "kg m^2", neutral=1.0),
    "z": CoordinateKind("vz", "m"),
    "e0": CoordinateKind("e0dot", "1", 1.0),
    **{f"e{k}": CoordinateKind(f"e{k}dot", "1") for k in (1, 2, 3)},
    "angle": CoordinateKind("rate", "rad"),
    "slide": CoordinateKind("speed", "m"),
}
"""Letter of a coordinate → its kind.

α and β are contact parameters of elements; the rate of an integral is a state, which has a unit of
its own; e0 to e3 are the Euler parameters of a body in space, angle and slide count how far the
second body of a joint in space has turned and slid.
"""
MASSES = ("mass", "inertia")  # letters of masses that vary


def declare_letter(letter: str, kind: CoordinateKind) -> None:
    """Let bodies have coordinates of another letter.

    Raises ValueError if the letter, or that of its velocity, means something else already.
    """
    rates = {known.rate: place for place, known in KINDS.items()}
    if KINDS.get(letter, kind) != kind or rates.get(kind.rate, letter) != letter:
        raise ValueError(f"coordinate '{letter}' or velocity '{kind.rate}' means something else")
    KINDS[letter] = kind


class ModelSymbol(sympy.Symbol):  # type: ignore[misc]
    """A symbol of a model, which has no value while the model is declared."""

    __slots__ = ()

    def __float__(self) -> float:
        """Refused, as of any symbol, with what to write; `math.sin` and NumPy ask for it."""
        raise TypeError(
            f"{type(self).__name__} '{self.name}' has no value while a model is declared, and "
            "math, numpy and float() need one. Take functions of sympy: sin, sqrt, Abs, Max, And, "
            "Piecewise."
        )


class MeasuredSymbol(ModelSymbol):
    """A symbol that notebooks show with its unit and rate; expressions show its name alone."""

    __slots__ = ()
    unit: Any
    rate: Any = None

    def _repr_latex_(self) -> str:
        """For notebooks."""
        more = f"\\quad \\text{{rate }} {sympy.latex(self.rate)}" if self.rate else ""
        return f"$\\displaystyle {sympy.latex(self)}\\ [\\mathrm{{{self.unit}}}]{more}$"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """For a terminal of IPython."""
        more = f", rate {self.rate.name}" if self.rate else ""
        printer.text(f"{self.name} ({self.unit}){more}")


class Coordinate(MeasuredSymbol):
    """A generalized coordinate, ``owner_letter``; `rate` is its velocity."""

    __slots__ = ()

    @property
    def owner(self) -> str:
        """The body or element that brings it."""
        return str(self.name.rpartition("_")[0])

    @property
    def letter(self) -> str:
        """Its letter within the owner."""
        return str(self.name.rpartition("_")[2])

    @property
    def measure(self) -> CoordinateKind:
        """The kind of quantity that it measures."""
        return KINDS[self.letter]

    @property
    def unit(self) -> str:
        """Its unit."""
        return self.measure.unit

    @property
    def rate(self) -> "Velocity":
        """The velocity symbol that belongs to this coordinate (``crank_phi`` → ``crank_omega``)."""
        return _velocity(f"{self.owner}_{self.measure.rate}")


class Velocity(MeasuredSymbol):
    """The time derivative of a generalized coordinate; `coordinate` is that coordinate."""

    __slots__ = ()

    @property
    def unit(self) -> str:
        """Its unit."""
        return self.coordinate.measure.rate_unit

    @property
    def coordinate(self) -> Coordinate:
        """The coordinate whose rate this is (``crank_omega`` → ``crank_phi``)."""
        owner, _, letter = self.name.rpartition("_")
        (place,) = (place for place, kind in KINDS.items() if kind.rate == letter)
        return Coordinate(f"{owner}_{place}", real=True)


class QuasiCoordinate(Coordinate):
    """A direction in which a body in space turns, about an axis of its own: ``rod_turnx``.

    It has no value. A force along it is a component of a torque n', and its rate one of ω'.
    """

    __slots__ = ()

    @property
    def measure(self) -> CoordinateKind:
        """An angle."""
        return CoordinateKind(f"omega_{self.letter[-1]}", "rad")

    @property
    def rate(self) -> sympy.Expr:
        """ω'_k, a function of the Euler parameters and their rates."""
        p = [Coordinate(f"{self.owner}_e{k}", real=True) for k in range(4)]
        return SpinEntry("xyz".index(self.letter[-1]), *p, *(e.rate for e in p))


class Acceleration(ModelSymbol):
    """The second time derivative of a coordinate; occurs in rates of switching functions."""

    __slots__ = ()


class ResultSeries(ModelSymbol):
    """A series of results by its name, such as ``A.fx`` or ``a(crank.phi)``, in an output."""

    __slots__ = ()

    @property
    def owner(self) -> str:
        """The body or element, or ``ground``, whose series it is."""
        return str(self.name.removeprefix("a(").partition(".")[0])


class Multiplier(ModelSymbol):
    """A Lagrange multiplier."""

    __slots__ = ()


class Time(ModelSymbol):
    """The time, in seconds."""

    __slots__ = ()


class Side(ModelSymbol):
    """A number that says on which side of its surface an effect acts; its mode decides."""

    __slots__ = ()


class Speed(ModelSymbol):
    """The rate ṡ of the scalar along which a force acts."""

    __slots__ = ()


class Given(ModelSymbol):
    """A placeholder in the equations of an element, bound to a number or parameter in a model."""

    __slots__ = ()


class Parameter(ModelSymbol):
    """A number that may change between runs without a new build."""

    __slots__ = ()


@dataclass(frozen=True)
class ParameterDeclaration:
    """A parameter's name, default value, unit label, and the rule that its values obey."""

    name: str
    value: float
    unit: str
    sign: SignRule

    @property
    def symbol(self) -> Parameter:
        """The parameter in expressions."""
        return Parameter(self.name, real=True)

    def problem(self, value: float) -> str | None:
        """Why `value` is not allowed, or None."""
        if not math.isfinite(value):
            return f"parameter '{self.name}' is {value}; give a finite number."
        if (self.sign == "positive" and value <= 0) or (self.sign == "nonnegative" and value < 0):
            return f"parameter '{self.name}' is {value:g} {self.unit}, but must be {self.sign}."
        return None


t = Time("t", real=True)

SPEED = Speed("s_rate", real=True)  # ṡ, in which a force along a scalar s is written: f = k s + c ṡ
alpha = Given("alpha", real=True)  # the parameter in which the profile of a cam is written, rad


@lru_cache(KEPT)
def _coordinate(owner: str, letter: str) -> Coordinate:
    return Coordinate(f"{owner}_{letter}", real=True)


@lru_cache(KEPT)
def _velocity(name: str) -> Velocity:
    return Velocity(name, real=True)


@declaring("coordinate")
def coordinate(owner: str, letter: str) -> Coordinate:
    """Coordinate `letter`, one of `KINDS`, of the body or element."""
    words: tuple[object, object] = (owner, letter)
    if not all(isinstance(word, str) for word in words) or letter not in KINDS:
        known = ", ".join(KINDS)
        raise ModelError(
            f"coordinate({shown(owner)}, {shown(letter)}): give a name, and one of {known}."
        )
    return _coordinate(owner, letter)


def own_coordinate(letter: str, text: str) -> Coordinate:
    """A property of bodies and joints: the coordinate of that letter; `text` describes it."""
    return property(lambda owner: _coordinate(owner.name, letter), doc=text)  # type: ignore[return-value]


def side(name: str) -> Side:
    """The side on which the effect of that name acts, as its `hold` says."""
    return Side(f"{name}_side", real=True)


@declaring("given")
def given(name: str) -> Given:
    """Placeholder called `name` for a real number."""
    text: object = name
    if not isinstance(text, str):
        raise ModelError(f"given({shown(name)}): give a name.")
    return Given(name, real=True)


@lru_cache(maxsize=4096)
def symbols_in(expression: sympy.Basic) -> frozenset[sympy.Basic]:
    """The free symbols of an immutable expression; joints of one kind state the same one."""
    return frozenset(expression.free_symbols)


def kinds(expression: sympy.Basic, *classes: type[Any]) -> list[Any]:
    """Symbols of the given classes in an expression, in the order of their names."""
    symbols = [s for s in symbols_in(expression) if isinstance(s, classes)]
    return sorted(symbols, key=lambda s: s.name)


def nonlinear_in(expression: sympy.Expr) -> list[Any]:
    """The velocities of which an expression is no linear function."""
    return [v for v in kinds(expression, Velocity) if kinds(sympy.diff(expression, v), Velocity)]


def dotted(symbol: sympy.Symbol) -> str:
    """``crank_phi`` → ``crank.phi``, and a state by its own name."""
    owner, _, letter = str(symbol.name).rpartition("_")
    is_state = isinstance(symbol, Velocity) and letter == KINDS["integral"].rate
    return owner if is_state else f"{owner}.{letter}" if owner else letter


def owners(expression: sympy.Basic) -> set[str]:
    """Names of what has the coordinates and velocities in an expression."""
    return {s.name.rpartition("_")[0] for s in kinds(expression, Coordinate, Velocity)}


def rate(s: sympy.Expr) -> sympy.Expr:
    """ds/dt = s_q q̇ + s_t."""
    slopes = (sympy.diff(s, q) * q.rate for q in kinds(s, Coordinate))
    return sympy.Add(*slopes, sympy.diff(s, t))


@cache
def derivative(expression: sympy.Expr, symbol: sympy.Symbol) -> sympy.Expr:
    """∂ expression / ∂ symbol, by the rules of calculus alone: sums, products, constant powers.

    SymPy differentiates a power as if its exponent might vary, and asks a page of questions about
    the sign of its base: half the time of a build. All else is left to SymPy.
    """
    if expression == symbol:
        return sympy.S.One
    if symbol not in expression.free_symbols:
        return sympy.S.Zero
    args = list(expression.args)
    if expression.is_Add:
        return sympy.Add(*(derivative(a, symbol) for a in args))
    if expression.is_Mul:
        return sympy.Add(
            *(
                sympy.Mul(*args[:k], derivative(a, symbol), *args[k + 1 :])
                for k, a in enumerate(args)
            )
        )
    if expression.is_Pow and args[1].is_number:
        base, exponent = args
        return expression * (derivative(base, symbol) * exponent / base)
    if isinstance(expression, sympy.floor):
        return sympy.S.Zero  # between its jumps, at which steps end
    if isinstance(expression, sympy.sin | sympy.cos):
        return expression.fdiff(1) * derivative(args[0], symbol)
    return sympy.diff(expression, symbol)
