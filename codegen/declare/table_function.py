"""Functions through points, as SymPy functions that can be differentiated and compiled."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import sympy

from codegen.cubic_spline import Table
from codegen.declare.plain_expression import plain_expression
from codegen.declare.units import is_quantity
from codegen.errors import ModelError
from codegen.plain_values import KindError, plain_float, shown
from codegen.public_callables import declaration

DEGREE = 3
FEWEST = 4
# accuracy: difference of a periodic table's first and last value, in parts of the largest
CLOSED = 1e-12


class TableAtom(sympy.Atom):  # type: ignore[misc]
    """A table inside an expression; two are equal where all their numbers are."""

    __slots__ = ("table",)

    def __new__(cls, table: Table) -> "TableAtom":
        """Wrap a table."""
        atom: TableAtom = super().__new__(cls)
        atom.table = table
        return atom

    def _hashable_content(self) -> tuple[str, str]:
        return (self.table.name, self.table.digest)

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

    def __init__(self, table: Table) -> None:
        self.table = table

    def __call__(self, at: Any) -> sympy.Expr:
        """The table at `at`: t, coordinates, `alpha` or parameters, in SI units, or a quantity."""
        if is_quantity(at):
            at = at.to_base_units().magnitude
        try:
            place = plain_expression(at)
            if place.is_number and math.isnan(self.table(plain_float(place), 0)):
                raise KindError
            return Interpolant(TableAtom(self.table), sympy.S.Zero, place)
        except Exception:  # also of numbers beyond floats
            raise ModelError(
                f"{self!r} is called with {shown(at)}; give a number from its first to its last "
                "abscissa, or an expression."
            ) from None

    def __repr__(self) -> str:
        return f"table '{self.table.name}' of {len(self.table.knots)} points"


for _word in ("__init__", "__call__"):
    setattr(TableFunction, _word, declaration(getattr(TableFunction, _word), "table"))


def point_problems(x: list[float], y: list[float], periodic: bool) -> Iterator[str]:
    """Why no spline goes through points."""
    if len(x) != len(y):
        yield f"{len(x)} abscissae and {len(y)} values; give as many of one as of the other."
        return
    if len(x) < FEWEST:
        yield f"{len(x)} points are too few for a cubic spline; give at least {FEWEST}."
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
            "again at the end of the period."
        )
