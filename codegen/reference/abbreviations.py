"""Letters for the sums that an element's equations repeat, so that they fit on a page."""

from collections import Counter
from collections.abc import Iterable

import sympy

from codegen.declare.element import I, J
from codegen.declare.symbols import given
from codegen.reference.latex import latex, width

LONG = 14
"""Characters from which a sum that occurs again is given a letter."""

SPAN = tuple(J.point - I.point)
KNOWN = dict(zip(SPAN, (given("d_x"), given("d_y")), strict=True))
"""The way from point i to point j has its letters in every book."""


class Abbreviations:
    """Sums that occur more than once, each with a letter.

    Parameters
    ----------
    expressions
        All that a page shows, in the order in which it does.
    """

    def __init__(self, expressions: Iterable[sympy.Expr]) -> None:
        counts: Counter[sympy.Expr] = Counter()
        for expression in expressions:
            for sum_ in _sums(expression):
                # -(a + b) is the sum of -a and -b, and the same thing to a reader.
                counts[-sum_ if -sum_ in counts else sum_] += 1
        repeated = [s for s, n in counts.items() if n > 1 and width(latex(s)) >= LONG]
        self._letters: dict[sympy.Expr, sympy.Symbol] = {}
        for sum_ in repeated:
            turned = -sum_ if -sum_ in KNOWN else sum_
            free = given(f"a_{len(self._letters) + 1}")
            self._letters[turned] = KNOWN.get(turned, free)
        self._used: dict[sympy.Symbol, None] = {}

    def __call__(self, expression: sympy.Expr) -> sympy.Expr:
        """The same expression, with letters in place of the sums."""
        for sign in (1, -1):
            if letter := self._letters.get(sign * expression):
                self._used[letter] = None
                return sign * letter
        return self.inside(expression)

    def inside(self, expression: sympy.Expr) -> sympy.Expr:
        """The same, where `expression` itself is not to become a letter."""
        if not expression.args or expression.is_Relational:
            return expression
        arguments = [self(a) if isinstance(a, sympy.Expr) else a for a in expression.args]
        return expression.func(*arguments)

    def definitions(self) -> list[tuple[str, sympy.Expr]]:
        """(letter in LaTeX, sum) of the letters in use, each before it is used in another."""
        meanings = {letter: sum_ for sum_, letter in self._letters.items()}
        found: dict[sympy.Symbol, sympy.Expr] = {}

        def define(letter: sympy.Symbol) -> None:
            if letter in found:
                return
            shown = self.inside(meanings[letter])
            inner = (s for s in shown.free_symbols if s in meanings)
            for other in sorted(inner, key=lambda s: s.name):
                define(other)
            found[letter] = shown

        for letter in sorted(self._used, key=lambda s: s.name):
            define(letter)
        return [(latex(letter), shown) for letter, shown in found.items()]


def _sums(expression: sympy.Basic) -> Iterable[sympy.Expr]:
    """Sums inside an expression and it itself, from the outside, in the order of its arguments."""
    if isinstance(expression, sympy.Add):
        yield expression
    for argument in expression.args:
        yield from _sums(argument)
