"""Functions through points, as SymPy functions that can be differentiated and compiled."""

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.symbols import Time, Velocity
from codegen.errors import ModelError
from codegen.object_display import counted
from codegen.readers.calls import declaring
from codegen.readers.expressions import plain_expression
from codegen.readers.quantities import UnitError, in_unit, is_quantity, same_dimension
from codegen.readers.values import KindError, plain_float, shown
from codegen.tables.period import is_angle
from codegen.tables.piecewise_cubic import Kind, Table
from codegen.tables.piecewise_function import ClosedPieces, opened

DEGREE = 3
# formula: the fewest points of each kind; of a periodic table one more, its first point again
FEWEST: dict[Kind, int] = {"linear": 2, "pchip": 2, "akima": 3, "spline": 4}
# accuracy: difference of a periodic table's first and last value, in parts of the largest
CLOSED = 1e-12


class TableAtom(sympy.Atom):  # type: ignore[misc]
    """A table inside an expression; two are equal where all their numbers and units are."""

    __slots__ = ("table", "unit")

    def __new__(cls, table: Table, unit: str = "") -> "TableAtom":
        """Wrap a table of values in `unit`; empty: nobody has said in which."""
        atom: TableAtom = super().__new__(cls)
        atom.table, atom.unit = table, unit
        return atom

    def _hashable_content(self) -> tuple[str, str, str]:
        return (self.table.name, self.table.digest, self.unit)

    def _sympystr(self, _: Any) -> str:
        return f"{self.table.name}_{self.table.digest[:12]}"

    _pythoncode = _sympystr
    _lambdacode = _sympystr


class Interpolant(sympy.Function):  # type: ignore[misc]
    """The derivative of a table, order 0, 1, 2 or 3, at an expression: arguments in this order."""

    nargs = 3
    is_real = True

    @classmethod
    def eval(cls, data: TableAtom, order: sympy.Integer, at: sympy.Expr) -> sympy.Expr | None:
        """A number, where it is taken at a number."""
        if not (at.is_number and at.is_real):
            return None
        value = data.table(float(at), int(order))
        return sympy.nan if math.isnan(value) else sympy.Float(value)

    @property
    def table(self) -> Table:
        """The points."""
        table: Table = self.args[0].table
        return table

    @property
    def table_unit(self) -> str:
        """The unit of its values, where it is no derivative and somebody has said it."""
        return "" if self.order else str(self.args[0].unit)

    @property
    def order(self) -> int:
        """Which derivative."""
        return int(self.args[1])

    @property
    def at(self) -> sympy.Expr:
        """Where it is taken."""
        return self.args[2]

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        slope = self.at.diff(symbol)
        if slope.is_zero or self.order == DEGREE:
            return sympy.S.Zero
        return Interpolant(self.args[0], sympy.Integer(self.order + 1), self.at) * slope


class TableFunction:
    """A table as a function: called with an expression, it returns the table's value there."""

    def __init__(
        self, table: Table, units: tuple[str, str] = ("", ""), over_angle: str = ""
    ) -> None:
        self.table, self.units = table, units
        self.over_angle = over_angle  # why it cannot be called with an angle; empty: it can

    @declaring("table")
    def __call__(self, at: Any) -> sympy.Expr:
        """The table at `at`: t, coordinates, `alpha` or parameters, in SI units, or a quantity."""
        unit, of_values = self.units
        given = at
        try:
            if unit:
                given = in_unit(at, unit)
            elif is_quantity(at):
                given = at.to_base_units().magnitude
            place = plain_expression(given)
            outside = place.is_number and math.isnan(self.table(plain_float(place), 0))
        except UnitError as misfit:
            raise ModelError(f"{self!r}, its abscissa: {misfit}") from None
        except KindError:
            outside = True
        if outside:
            raise ModelError(
                f"{self!r} is called with {shown(at)}; give a number from its first to its last "
                "abscissa, or an expression."
            )
        other = other_dimension(place, unit) if unit else None
        if other:
            raise ModelError(
                f"{self!r} has abscissae in {unit}, and is called with {shown(at)}, in {other}; "
                f"give it what is in {unit}, or the table other units=."
            )
        if self.over_angle and is_angle(place):
            raise ModelError(f"{self!r} is called with {shown(at)}: {self.over_angle}")
        return Interpolant(TableAtom(self.table, of_values), sympy.S.Zero, place)

    def __repr__(self) -> str:
        return f"table '{self.table.name}' of {len(self.table.knots)} points"


def plain_function(
    symbols: Iterable[sympy.Symbol], expressions: Any
) -> Callable[[Iterable[float]], npt.NDArray[np.float64]]:
    """Expressions in nested lists as a function of numbers; nan where one has no value."""
    every, shape, symbols = sympy.flatten(expressions), np.shape(expressions), [*symbols]
    found = sorted({p for e in every for p in e.atoms(ClosedPieces)}, key=str)
    values = {pieces: sympy.Dummy() for pieces in found}  # each is evaluated once
    opened_pieces, every = [*map(opened, found)], [e.xreplace(values) for e in every]
    tables = {str(a): a.table for e in (*opened_pieces, *every) for a in e.atoms(TableAtom)}
    tables["Interpolant"] = lambda table, order, at: table(at, order)
    inner = sympy.lambdify(symbols, opened_pieces, [tables, "math"]) if found else lambda *_: ()
    compiled = sympy.lambdify([*symbols, *values.values()], every, [tables, "math"])

    def evaluated(numbers: Iterable[float]) -> npt.NDArray[np.float64]:
        given = [*map(float, numbers)]
        try:
            return np.reshape([*map(float, compiled(*given, *inner(*given)))], shape)
        except (ArithmeticError, ValueError, TypeError, NameError):
            return np.full(shape, math.nan)

    return evaluated


def other_dimension(expression: sympy.Expr, unit: str) -> str | None:
    """The unit of a term of an expression, where it is known and has not the dimension needed."""
    for term in sympy.Add.make_args(expression):
        factor, symbol = term.as_coeff_Mul()
        measured = "s" if isinstance(symbol, Time) else getattr(symbol, "unit", "")
        if isinstance(symbol, Velocity) and symbol.coordinate.letter == "integral":
            measured = ""  # a state has a unit of its own
        if measured and abs(factor) == 1 and not same_dimension(measured, unit):
            return measured
    return None


def point_problems(x: list[float], y: list[float], periodic: bool, kind: Kind) -> Iterator[str]:
    """Why no curve of a kind goes through points."""
    if len(x) != len(y):
        yield f"{len(x)} abscissae and {len(y)} values; give as many of one as of the other."
        return
    fewest = FEWEST[kind] + (periodic and kind != "spline")
    if len(x) < fewest:
        name = "cubic spline" if kind == "spline" else f"table of kind {kind!r}"
        repeats = " that repeats" if periodic else ""
        count = f"{counted(len(x), 'point')} {'is' if len(x) == 1 else 'are'}"
        yield f"{count} too few for a {name}{repeats}; give at least {fewest}."
        return
    for k, (left, right) in enumerate(pairwise(x)):
        if right == left:
            yield f"the abscissa {left:g} is repeated, at points {k} and {k + 1}; leave one out."
        elif right < left:
            yield f"x falls from {left:g} to {right:g} at point {k + 1}; sort the points by x."
    size = max(map(abs, y))
    if periodic and abs(y[-1] - y[0]) > CLOSED * size:
        yield (
            f"it is to repeat, but begins at {y[0]:g} and ends at {y[-1]:g}; give the first value "
            "again at the end of the period, or period= where this row is missing."
        )
