"""Functions by pieces, closed to SymPy: of time in gaps, of angles in profiles, of coordinates.

SymPy writes the pieces of what stands in a condition out into conditions of its own, and gives a
kink a derivative with Dirac's delta. A gap stands in the condition of its contact.
"""

from typing import Any

import sympy
from sympy.core.relational import Relational

from codegen.declare.symbols import Coordinate, Parameter, Time, alpha, derivative, kinds

_PIECES = (
    *(sympy.Piecewise, sympy.Abs, sympy.Max, sympy.Min, sympy.sign, sympy.Heaviside),
    *(sympy.Mod, sympy.floor, sympy.ceiling),
)

_CLOSED = sympy.Piecewise, sympy.sin, sympy.cos


class PiecesAtom(sympy.Atom):  # type: ignore[misc]
    """A function by pieces, and its symbols; one of the angle `alpha` repeats at each turn."""

    __slots__ = ("expression", "name", "symbols")

    def __new__(cls, expression: sympy.Expr, name: str = "") -> "PiecesAtom":
        """Wrap an expression of parameters and the time, `alpha` or coordinates.

        A `name` of its own stands for it in texts.
        """
        atom: PiecesAtom = super().__new__(cls)
        atom.expression, atom.name = expression, name
        atom.symbols = tuple(sorted(expression.free_symbols, key=str))
        return atom

    def _hashable_content(self) -> tuple[sympy.Expr]:
        return (self.expression,)

    def _sympystr(self, printer: Any) -> str:
        return str(printer._print(self.expression))


def _placed(atom: PiecesAtom, values: tuple[sympy.Expr, ...]) -> sympy.Expr:
    """The function of an atom with values for its symbols."""
    of = dict(zip(atom.symbols, values, strict=True))
    if alpha in of:
        of[alpha] -= 2 * sympy.pi * sympy.floor(of[alpha] / (2 * sympy.pi))
    return atom.expression.xreplace(of)


class ClosedPieces(sympy.Function):  # type: ignore[misc]
    """A function by pieces at its symbols: arguments are the atom, and they."""

    is_real = True

    @classmethod
    def eval(cls, atom: PiecesAtom, *values: sympy.Expr) -> sympy.Expr | None:
        """A number, where it is taken at numbers."""
        return _placed(atom, values) if all(value.is_number for value in values) else None

    @property
    def places(self) -> dict[sympy.Symbol, sympy.Expr]:
        """What the symbols stand for."""
        atom, *values = self.args
        return dict(zip(atom.symbols, values, strict=True))

    @property
    def expression(self) -> sympy.Expr:
        """The function as it was written."""
        return _placed(self.args[0], self.args[1:])

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        terms = []
        for own, value in self.places.items():
            if (inner := derivative(value, symbol)) != 0:
                slope = derivative(_spelled_out(self.args[0].expression), own)
                if slope.has(alpha, *_PIECES):
                    name = self.args[0].name
                    slope = close(slope, name and f"{name}_{own}")
                terms.append(inner * slope.xreplace(self.places))
        return sympy.Add(*terms)

    def _sympystr(self, printer: Any) -> str:
        atom, *places = self.args
        if atom.name:
            return f"{atom.name}({', '.join(map(printer._print, places))})"
        return str(printer._print(self.expression))


def close(expression: sympy.Expr, name: str = "") -> ClosedPieces:
    """A function by pieces, of parameters and the time, `alpha` or coordinates, closed to SymPy."""
    atom = PiecesAtom(expression, name)
    return ClosedPieces(atom, *atom.symbols)


def closed(expression: sympy.Expr) -> sympy.Expr:
    """The expression with its parts that are functions of time by pieces closed to SymPy."""
    if not (expression.has(Time) and expression.has(*_PIECES)):
        return expression
    if all(isinstance(symbol, Time | Parameter) for symbol in expression.free_symbols):
        return close(expression)
    return expression.func(*map(closed, expression.args))


def closed_where_smooth(phi: sympy.Expr) -> sympy.Expr:
    """An equation in coordinates, its terms with pieces closed to SymPy where all slopes agree.

    Where a slope jumps, or is not known to agree, it is left as it is, for the checks to refuse.
    Nobody looks into what is closed: only powers, sines and cosines are, and no pieces of the time.
    """
    terms = sympy.Add.make_args(phi)
    parts = [e for e in terms if any(node.has(Coordinate) for node in e.atoms(*_PIECES))]
    pieces = _spelled_out(sympy.Add(*parts))
    powers = (power.exp for part in parts for power in part.atoms(sympy.Pow))
    surfaces = {c.lhs - c.rhs for c in pieces.atoms(Relational)}
    if (
        parts
        and all(isinstance(f, _CLOSED) for f in pieces.atoms(sympy.Function))
        and all(e.is_integer or (e - 2).is_nonnegative for e in powers)
        and all(_is_smooth_across(sympy.nsimplify(pieces, rational=True), g) for g in surfaces)
    ):
        return phi - sympy.Add(*parts) + close(pieces)
    return phi


def _is_smooth_across(pieces: sympy.Expr, g: sympy.Expr) -> bool:
    """Whether value and slopes are the same on both sides of g = 0, linear in a coordinate."""
    g, sides = sympy.nsimplify(g, rational=True), []
    for sign in (1, -1):
        of = {own: sign * (1 if own.lhs - own.rhs == g else -1) for own in pieces.atoms(Relational)}
        of = {own: own.func(s, 0) for own, s in of.items() if own.lhs - own.rhs in (g, -g)}
        sides.append(pieces.xreplace(of))
    change = sides[0] - sides[1]
    for one in kinds(g, Coordinate):
        slope = g.diff(one)
        if slope.is_nonzero and not slope.has(one):
            there = {one: one - g / slope}
            parts = [change, *(change.diff(symbol) for symbol in kinds(change, Coordinate))]
            return all(sympy.simplify(part.subs(there)) == 0 for part in parts)
    return False


def opened(expression: sympy.Basic) -> Any:
    """The expression with such functions as they were written."""
    return expression.replace(lambda e: isinstance(e, ClosedPieces), lambda e: e.expression)


def _spelled_out(expression: sympy.Expr) -> sympy.Expr:
    """The same with its kinks and jumps as pieces, the side behind it at each instant."""

    def halves(argument: sympy.Expr, above: Any, below: Any) -> sympy.Expr:
        return sympy.Piecewise((above, argument >= 0), (below, True))

    kinks = expression.replace(sympy.Heaviside, lambda a, *_: halves(a, 1, 0))
    kinks = kinks.replace(sympy.sign, lambda a: halves(a, 1, -1))
    kinks = kinks.replace(sympy.Mod, lambda a, b: a - b * sympy.floor(a / b))
    return kinks.rewrite([sympy.Abs, sympy.Max, sympy.Min], sympy.Piecewise)
