"""The letters of the book for quantities of a pair of bodies: s_i = A_i s'_i, u_i = A_i u'_i, d_ij.

An element's equations are compiled component by component, so that s'_ix cos φ_i - s'_iy sin φ_i
stands there for s_ix. A page puts the letter back: by factoring it out of sums, which changes
no value.
"""

from collections.abc import Iterator
from functools import cache

import sympy

from codegen.declare.element import I, J
from codegen.declare.symbols import Parameter, given
from codegen.reference.latex import FRAMED

Sum = dict[sympy.Expr, sympy.Expr]  # terms without their numbers → the numbers


def _rotated() -> Iterator[tuple[sympy.Symbol, sympy.Expr]]:
    """Global components of the vectors s and u of both frames."""
    for frame in (I, J):
        for vector in "su":
            placeholders = sympy.Matrix([given(f"{frame.name}_{vector}{axis}") for axis in "xy"])
            for axis, component in zip("xy", frame.A * placeholders, strict=True):
                yield given(f"{vector}_{frame.name}{axis}"), component


MEANINGS: dict[sympy.Symbol, sympy.Expr] = {
    **dict(_rotated()),
    # of the way between the points, d_ij: r_j + s_j - r_i - s_i
    given("d_x"): J.x + given("s_jx") - I.x - given("s_ix"),
    given("d_y"): J.y + given("s_jy") - I.y - given("s_iy"),
}


@cache
def lettered(expression: sympy.Basic) -> sympy.Basic:
    """The same expression in letters, with sin² + cos² = 1, and 1/2 where the computer has 0.5."""
    if expression.is_Float:
        eighths = 8 * float(expression)
        return sympy.Rational(int(eighths), 8) if eighths.is_integer() else expression
    if isinstance(expression, Parameter) and FRAMED.fullmatch(expression.name):
        return given(expression.name)
    if not expression.args:
        return expression
    inner = expression.func(*(lettered(argument) for argument in expression.args))
    if isinstance(inner, sympy.Mul):
        parts = [scaled(factor) for factor in inner.args]
        return sympy.Mul(*(number for number, _ in parts), *(factor for _, factor in parts))
    if not isinstance(inner, sympy.Add):
        return inner
    for letter, meaning in (*_ones(inner), *MEANINGS.items()):
        inner = _factored(inner, letter, meaning)
    return inner


def scaled(expression: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    """A number, and a sum without it: 2 a - 2 b and b - a are multiples of one sum."""
    if not isinstance(expression, sympy.Add):
        return sympy.S.One, expression
    first = min((a for a in expression.args if not a.is_number), key=sympy.default_sort_key)
    number = first.as_coeff_Mul()[0]
    return number, sympy.Add(*(term / number for term in expression.args))


def used(expressions: list[sympy.Expr]) -> list[tuple[sympy.Symbol, sympy.Expr]]:
    """(letter, meaning) of the letters that occur, and of those in their meanings."""
    letters: set[sympy.Symbol] = set()
    stack = list(expressions)
    while stack:
        fresh = {s for s in stack.pop().free_symbols if s in MEANINGS} - letters
        letters |= fresh
        stack += [MEANINGS[s] for s in fresh]
    return [(letter, meaning) for letter, meaning in MEANINGS.items() if letter in letters]


def _ones(sum_: sympy.Expr) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """1 = sin² + cos² of each angle whose sine is squared in a sum."""
    angles = sorted({s.args[0] for s in sum_.atoms(sympy.sin)}, key=sympy.default_sort_key)
    for angle in angles:
        yield sympy.S.One, sympy.sin(angle) ** 2 + sympy.cos(angle) ** 2


def _factored(sum_: sympy.Expr, letter: sympy.Expr, meaning: sympy.Expr) -> sympy.Expr:
    """Every m · meaning that the terms of a sum contain, as m · letter."""
    pattern = _terms(meaning)
    first, *others = sorted(pattern, key=sympy.default_sort_key)
    if not first.free_symbols <= sum_.free_symbols:
        return sum_
    terms = _terms(sum_)
    for term in sorted(terms, key=sympy.default_sort_key):
        factor = _quotient(term, first)
        if factor is None or term not in terms:
            continue
        number = terms[term] / pattern[first]
        target = {factor * other: number * pattern[other] for other in others}
        if all(terms.get(t) == n for t, n in target.items()):
            for t in (term, *target):
                del terms[t]
            key, scale = _bare(number * factor * letter)
            terms[key] = terms.get(key, sympy.S.Zero) + scale
    return sympy.Add(*(number * term for term, number in terms.items()))


def _terms(expression: sympy.Expr) -> Sum:
    return dict(map(_bare, sympy.Add.make_args(expression)))


def _bare(term: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    number, bare = term.as_coeff_Mul()
    return bare, number


def _quotient(term: sympy.Expr, divisor: sympy.Expr) -> sympy.Expr | None:
    """term / divisor, where every factor of the divisor is one of the term."""
    has, target = term.as_powers_dict(), divisor.as_powers_dict()
    if all((has.get(base, 0) - power).is_nonnegative for base, power in target.items()):
        return term / divisor
    return None
