r"""Expressions as LaTeX, in Haug's letters: $x_i$, $\dot\phi_j$, $s'_{jx}$, $\lambda_1$.

Nothing here depends on the order of a set: the same expression gives the same characters.
"""

import re

import sympy
from sympy.printing.latex import LatexPrinter, translate

from codegen.declare.symbols import KINDS, Coordinate, Given, Multiplier, Side, Velocity
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
