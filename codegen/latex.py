r"""Expressions as LaTeX, in Haug's letters: $x_i$, $\dot\phi_j$, $s'_{jx}$, $\lambda_1$.

Nothing here depends on the order of a set: the same expression gives the same characters.

An element's equations are compiled component by component, so that s'_ix cos φ_i - s'_iy sin φ_i
stands there for s_ix. A page puts the letter of the book back, s_i = A_i s'_i, u_i = A_i u'_i or
d_ij: by factoring it out of sums, which changes no value. Other sums that an element's equations
repeat are a_1, a_2 …
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import count

import sympy
from sympy.printing.latex import LatexPrinter, translate

from codegen.declare.element import I, J
from codegen.declare.symbols import (
    KINDS,
    Coordinate,
    Given,
    Multiplier,
    Parameter,
    Side,
    Velocity,
    given,
)
from codegen.tables.table_function import Interpolant

WIDTH = 84  # characters of a line that a page shows without scrolling, nearly

GREEK = {"phi": r"\phi", "alpha": r"\alpha", "beta": r"\beta"}
SHORT = {
    "length": "L", "distance": "c", "value": "C", "radius": "R", "share": r"\rho",
    "offset": "s_{0}", "line": r"\theta_{0}", "angle": r"\theta_{0}", "angle_offset": r"\theta_{0}",
}  # fmt: skip
"""Placeholders that books write with a letter."""

LETTERS = {kind.rate: letter for letter, kind in KINDS.items()}
OF_CURVES = ("alpha", "beta")
FRAMED = re.compile(r"([ij])_([su])([xy])")
COMMAND = re.compile(r"\\(?:left|right|begin|end|quad|mathrm|mathit|tfrac|frac|[,;])(?![a-zA-Z])")
INVISIBLE = re.compile(r"[{}_^&\s]")


class _Printer(LatexPrinter):  # type: ignore[misc]
    def _print_Symbol(self, expr: sympy.Symbol, style: str = "plain") -> str:
        return symbol(expr)

    def _print_sin(self, expr: sympy.Expr, exp: str | None = None) -> str:
        (angle,) = expr.args
        name, text = rf"\{expr.func.__name__}", self._print(angle)
        name = f"{name}^{{{exp}}}" if exp is not None else name
        return f"{name} {text}" if angle.is_Symbol else rf"{name}\left({text}\right)"

    _print_cos = _print_sin

    def _print_Interpolant(self, expr: Interpolant, exp: str | None = None) -> str:
        role = expr.table.role
        own = word(expr.table.name)
        letter = rf"\mathrm{{{role}}}_{{{own}}}" if role in ("knots", "range") else own
        name = rf"{letter}{chr(39) * expr.order}\left({self._print(expr.at)}\right)"
        return name if exp is None else rf"\left({name}\right)^{{{exp}}}"

    def _print_Piecewise(self, expr: sympy.Piecewise) -> str:
        # The branches of a table are the table, for a reader.
        lookup, condition = expr.args[0]
        tables = [node.table.role for node in condition.atoms(Interpolant)]
        if tables and all(role in ("knots", "range") for role in tables):
            return str(self._print(lookup))
        return str(super()._print_Piecewise(expr))

    def _print_Relational(self, expr: sympy.Rel) -> str:
        # A bare < opens a tag where Markdown is read as HTML.
        signs = {"<": r"\lt", ">": r"\gt", "<=": r"\le", ">=": r"\ge"}
        left, right = (self._print(side) for side in (expr.lhs, expr.rhs))
        return f"{left} {signs[expr.rel_op]} {right}"


_PRINT = _Printer({"fold_short_frac": False, "mul_symbol": None, "ln_notation": True})


def latex(expression: sympy.Basic) -> str:
    """An expression in one line."""
    return str(_PRINT.doprint(expression))


def symbol(s: sympy.Symbol) -> str:
    """A symbol of a declaration."""
    owner, _, letter = s.name.rpartition("_")
    if isinstance(s, Multiplier) and letter.isdecimal():
        return rf"\lambda_{{{int(letter) + 1}}}"
    if isinstance(s, Side):
        return r"\sigma"
    if isinstance(s, Coordinate | Velocity) and owner:
        dot = r"\dot " if isinstance(s, Velocity) else ""
        letter = LETTERS[letter] if isinstance(s, Velocity) else letter
        shown = f"{dot}{GREEK.get(letter, letter)}"
        # The parameter of a curve belongs to the joint; there is none other to confuse it with.
        return shown if letter in OF_CURVES else f"{shown}_{{{word(owner)}}}"
    if match := FRAMED.fullmatch(s.name):
        frame, vector, axis = match.groups()
        return f"{vector}'_{{{frame}{axis}}}"
    if isinstance(s, Given) and s.name in SHORT:
        return SHORT[s.name]
    if isinstance(s, Given) and owner in SHORT:
        return f"{SHORT[owner]}_{{{letter}}}"
    return word(s.name)


def word(name: str) -> str:
    """A name: Greek or one letter as it stands, a word upright, what follows ``_`` below."""
    head, _, below = name.partition("_")
    shown = r"\ell" if head == "l" else translate(head)
    if len(head) > 1 and not shown.startswith("\\"):
        shown = rf"\mathrm{{{head}}}"
    if not below:
        return shown
    # Axes and numbers stay as they are: s_{ix}, a_{10}.
    return f"{shown}_{{{below if len(below) < 3 else word(below)}}}"


def width(text: str) -> int:
    """Characters that LaTeX takes on the page, roughly."""
    return len(INVISIBLE.sub("", re.sub(r"\\[a-zA-Z]+", "m", COMMAND.sub("", text))))


def aligned(equations: list[tuple[str, sympy.Expr]]) -> str:
    """``$$ … $$`` with an equation (left side in LaTeX, right side) a line, long sums on more."""
    lines: list[str] = []
    for left, right in equations:
        first, *more = _broken(right, WIDTH - width(left))
        lines.append(f"{left} &= {first}")
        lines += [rf"&\quad {line}" for line in more]
    rows = " \\\\\n".join(lines)
    return f"$$\n\\begin{{aligned}}\n{rows}\n\\end{{aligned}}\n$$"


def _broken(expression: sympy.Expr, room: int) -> list[str]:
    """A sum in as few lines as it takes; every later line begins with a sign."""
    whole = latex(expression)
    if width(whole) <= room or not isinstance(expression, sympy.Add):
        return [whole]
    lines: list[str] = []
    for term in _PRINT._as_ordered_terms(expression, order=None):
        text = latex(term)
        signed = text if text.startswith("-") or not lines else f"+ {text}"
        if lines and width(lines[-1]) + width(signed) <= room:
            lines[-1] += f" {signed}"
        else:
            lines.append(signed)
    return lines


Sum = dict[sympy.Expr, sympy.Expr]  # terms without their numbers → the numbers
LONG = 9  # characters from which a repeated sum gets a name
WIDE = 56  # characters from which a sum inside a product is: lines are broken between terms alone


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
