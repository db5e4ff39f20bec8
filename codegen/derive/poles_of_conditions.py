"""Switching functions without poles: a/b > 0 is a b > 0, wherever b is not zero.

At a pole a function changes its sign without a zero, which no step shows and no location finds.
"""

from collections.abc import Iterator
from functools import cache

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from codegen.declare.symbols import Coordinate, Time, Velocity, kinds

Facts = tuple[sympy.Expr, ...]
"""What is positive."""

_INVERSES = {sympy.exp: sympy.log, sympy.sinh: sympy.asinh}
"""The inverses of increasing functions without bounds: f(u) > c is u > f⁻¹(c)."""


@cache
def without_poles(g: sympy.Expr, positive: Facts = ()) -> sympy.Expr:
    """A function that has the sign of `g` wherever `g` has a number, and no pole in what moves.

    It is `g` itself where this has none. A pole inside exp or sinh is seen where the comparison
    is with a constant, exp(1/x) > 2; else poles inside other functions stay. It counts where each
    of the functions `positive` is.
    """
    g = _with_inverse(g)
    if not _has_pole(g):
        return g
    if not isinstance(g, sympy.Piecewise) and any(map(_has_pole, _pieces(g))):
        g = sympy.piecewise_fold(g)
    if isinstance(g, sympy.Piecewise):
        return g.func(*((without_poles(e, facts), c) for e, c, facts in _with_facts(g, positive)))
    top, bottom = sympy.fraction(sympy.together(_with_fractions(g)))
    signs = (_sign(factor, positive, top) for factor in sympy.Mul.make_args(bottom))
    return sympy.Mul(top, *signs)


def _with_inverse(g: sympy.Expr) -> sympy.Expr:
    """k (u - f⁻¹(c)) for k (f(u) - c) with a pole in u, and any other function itself."""
    symbols = kinds(g, Coordinate, Velocity, Time)
    constant, rest = g.as_independent(*symbols, as_Add=True)
    factor, increasing = rest.as_independent(*symbols, as_Add=False)
    inverse = _INVERSES.get(increasing.func)
    if inverse is None or factor.is_nonzero is not True or not _has_pole(increasing.args[0]):
        return g
    level = inverse(-constant / factor)
    return factor * (increasing.args[0] - level) if level.is_extended_real else g


def _has_pole(node: sympy.Basic) -> bool:
    """Whether a sum, a product, a power or a piece may become infinite as something moves.

    Broken powers of lengths, as of x² + y², do not count: their rates stay finite.
    """
    if isinstance(node, sympy.Pow) and node.exp.is_number and _moves(node.base):
        base, whole = node.base, bool(node.exp.is_integer)
        never = base.is_positive if whole else base.is_nonnegative
        return bool(node.exp.is_negative and not never) or (whole and _has_pole(base))
    if isinstance(node, sympy.Piecewise):
        return any(_has_pole(piece) for piece, _ in node.args)
    if isinstance(node, sympy.Add | sympy.Mul):
        return any(map(_has_pole, node.args))
    return isinstance(node, sympy.tan) and _moves(node)


def _with_facts(
    node: sympy.Piecewise, positive: Facts
) -> Iterator[tuple[sympy.Expr, Boolean, Facts]]:
    """(piece, condition, what is positive where it counts)."""
    for piece, condition in node.args:
        compares = isinstance(condition, Relational)
        gap = (condition.gts - condition.lts,) if compares else ()
        yield piece, condition, (*positive, *gap)
        positive = (*positive, *(-g for g in gap))


def _moves(node: sympy.Basic) -> bool:
    return bool(kinds(node, Coordinate, Velocity, Time))


def _pieces(node: sympy.Basic) -> list[sympy.Piecewise]:
    """The outermost functions by pieces that a sum or a product has."""
    if isinstance(node, sympy.Piecewise):
        return [node]
    if isinstance(node, sympy.Add | sympy.Mul | sympy.Pow):
        return [piece for part in node.args for piece in _pieces(part)]
    return []


def _with_fractions(node: sympy.Expr) -> sympy.Expr:
    """The same with tan(u) as sin(u)/cos(u) wherever its poles count."""
    if isinstance(node, sympy.tan):
        return sympy.sin(*node.args) / sympy.cos(*node.args)
    if isinstance(node, sympy.Pow) and node.exp.is_Float:  # SymPy takes no x**-1.5 for a fraction
        node = sympy.Pow(node.base, sympy.Rational(str(node.exp)))
    if isinstance(node, sympy.Add | sympy.Mul) or (node.is_Pow and node.exp.is_integer):
        return node.func(*map(_with_fractions, node.args))
    return node


def _sign(factor: sympy.Expr, positive: Facts, top: sympy.Expr) -> sympy.Expr:
    """A factor with the sign of this one below `top`, 1 where it is positive."""
    base, exponent = factor.as_base_exp()
    if not _moves(factor):
        return 1 / factor
    if exponent.is_even or base.is_nonnegative or base in positive or _is_size(base):
        return sympy.S.One
    if -base in positive and exponent.is_odd:
        return sympy.S.NegativeOne
    if exponent.is_integer or not exponent.is_number:
        return base if exponent.is_odd else factor
    # Neither has a number where the base of a broken power is negative.
    ends = any(root.base == base and not root.exp.is_integer for root in top.atoms(sympy.Pow))
    return sympy.S.One if ends else base


def _is_size(base: sympy.Expr) -> bool:
    """Whether this is |x| by its pieces."""
    if not isinstance(base, sympy.Piecewise) or len(base.args) != 2:
        return False
    (one, holds), (other, _) = base.args
    return bool(one == -other and holds.is_Relational and one in (holds.lhs, holds.rhs))
