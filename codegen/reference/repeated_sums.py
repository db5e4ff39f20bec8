"""Short names for the sums that an element's equations repeat, so that they fit on a page."""

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import count

import sympy

from codegen.declare.symbols import given
from codegen.reference.latex import latex, width
from codegen.reference.vector_letters import lettered, scaled, used

LONG = 9  # characters from which a repeated sum gets a name
WIDE = 56  # characters from which a sum inside a product is: lines are broken between terms alone


class Abbreviations:
    """The letters of the book, and a_1, a_2 … for other sums that occur more than once.

    Where the expressions have a symbol a, it is b_1, b_2 …, and so on.

    `expressions` are all that a page shows, in the order in which it does.
    """

    def __init__(self, expressions: Iterable[sympy.Expr]) -> None:
        shown = [lettered(expression) for expression in expressions]
        counts: Counter[sympy.Expr] = Counter()
        wide: set[sympy.Expr] = set()
        for expression in shown:
            for sum_ in _sums(expression):
                bare = scaled(sum_)[1]
                counts[bare] += 1
                if sum_ is not expression and width(latex(sum_)) >= WIDE:
                    wide.add(bare)
        taken = {s.name for expression in shown for s in expression.free_symbols}
        heads = {name.partition("_")[0] for name in taken}
        letter = next((letter for letter in "abhkw" if letter not in heads), "a")
        free = (given(f"{letter}_{k}") for k in count(1) if f"{letter}_{k}" not in taken)
        chosen = [
            sum_
            for sum_, times in counts.items()
            if sum_ in wide or (times > 1 and width(latex(sum_)) >= LONG)
        ]
        self._names = {sum_: next(free) for sum_ in chosen}
        self._meanings = {name: sum_ for sum_, name in self._names.items()}
        self._met: list[sympy.Expr] = []

    def __call__(self, expression: sympy.Expr, *, whole: bool = True) -> sympy.Expr:
        """The same expression, shorter; unless `whole`, it has no name itself, but its parts do."""
        short = (self._named if whole else self._inside)(lettered(expression))
        self._met.append(short)
        return short

    def definitions(self) -> list[tuple[str, sympy.Expr]]:
        """(name in LaTeX, meaning) of the abbreviations in use, each before its first use."""
        pairs: dict[sympy.Symbol, sympy.Expr] = {}

        def define(names: set[sympy.Symbol]) -> None:
            for name in (n for n in self._meanings if n in names and n not in pairs):
                meaning = self._inside(self._meanings[name])
                define(meaning.free_symbols)
                pairs[name] = meaning

        define(set().union(*(e.free_symbols for e in self._met)))
        letters = used([*self._met, *pairs.values()])
        return [(latex(name), meaning) for name, meaning in (*letters, *pairs.items())]

    def _named(self, expression: sympy.Basic) -> sympy.Basic:
        if isinstance(expression, sympy.Add):
            number, sum_ = scaled(expression)
            if sum_ in self._names:
                return number * self._names[sum_]
        return self._inside(expression)

    def _inside(self, expression: sympy.Basic) -> sympy.Basic:
        if not expression.args:
            return expression
        return expression.func(*(self._named(argument) for argument in expression.args))


def _sums(expression: sympy.Basic) -> Iterator[sympy.Expr]:
    """Sums inside an expression and it itself, from the outside, in the order of its arguments."""
    if isinstance(expression, sympy.Add):
        yield expression
    for argument in expression.args:
        yield from _sums(argument)
