"""Functions of time by pieces, closed to SymPy: in places that move, and in gaps.

SymPy writes the pieces of what stands in a condition out into conditions of its own, and gives a
kink a derivative with Dirac's delta. A gap stands in the condition of its contact.
"""

from typing import Any

import sympy

from codegen.declare.symbols import Parameter, Time, derivative

_PIECES = (
    *(sympy.Piecewise, sympy.Abs, sympy.Max, sympy.Min, sympy.sign, sympy.Heaviside),
    *(sympy.Mod, sympy.floor, sympy.ceiling),
)


class PiecesAtom(sympy.Atom):  # type: ignore[misc]
    """A function of time by pieces, and its symbols."""

    __slots__ = ("expression", "symbols")

    def __new__(cls, expression: sympy.Expr) -> "PiecesAtom":
        """Wrap an expression of time and parameters."""
        atom: PiecesAtom = super().__new__(cls)
        atom.expression = expression
        atom.symbols = tuple(sorted(expression.free_symbols, key=str))
        return atom

    def _hashable_content(self) -> tuple[sympy.Expr]:
        return (self.expression,)

    def _sympystr(self, printer: Any) -> str:
        return str(printer._print(self.expression))


class TimePieces(sympy.Function):  # type: ignore[misc]
    """A function of time by pieces at its symbols: arguments are the atom, and they."""

    is_real = True

    @property
    def expression(self) -> sympy.Expr:
        """The function as it was written."""
        atom, *symbols = self.args
        return atom.expression.xreplace(dict(zip(atom.symbols, symbols, strict=True)))

    def _eval_derivative(self, symbol: sympy.Symbol) -> sympy.Expr:
        return closed(derivative(_spelled_out(self.expression), symbol))

    def _sympystr(self, printer: Any) -> str:
        return str(printer._print(self.expression))


def closed(expression: sympy.Expr) -> sympy.Expr:
    """The expression with its parts that are functions of time by pieces closed to SymPy."""
    if not (expression.has(Time) and expression.has(*_PIECES)):
        return expression
    if all(isinstance(symbol, Time | Parameter) for symbol in expression.free_symbols):
        atom = PiecesAtom(expression)
        return TimePieces(atom, *atom.symbols)
    return expression.func(*map(closed, expression.args))


def _spelled_out(expression: sympy.Expr) -> sympy.Expr:
    """The same with its kinks and jumps as pieces, the side behind it at each instant."""

    def halves(argument: sympy.Expr, above: Any, below: Any) -> sympy.Expr:
        return sympy.Piecewise((above, argument >= 0), (below, True))

    kinks = expression.replace(sympy.Heaviside, lambda a, *_: halves(a, 1, 0))
    kinks = kinks.replace(sympy.sign, lambda a: halves(a, 1, -1))
    kinks = kinks.replace(sympy.Mod, lambda a, b: a - b * sympy.floor(a / b))
    return kinks.rewrite([sympy.Abs, sympy.Max, sympy.Min], sympy.Piecewise)
