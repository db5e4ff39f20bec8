"""Jumps of an expression along the surfaces on which it changes its pieces, however small.

The jump at a surface is the difference of the smooth pieces on both sides, an expression of its own
for each choice of the other conditions. Where it is not zero as it stands, Gauss–Newton steps look
for a point of the surface at which these conditions hold.
"""

import math
from collections.abc import Callable, Iterator
from itertools import islice, product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.symbols import Coordinate, kinds
from codegen.derive.piecewise_conditions import conditions, switching_function, without_marks

Vector = npt.NDArray[np.float64]
Function = Callable[..., float]
Numbers = dict[sympy.Symbol, float]
Distances = Callable[[Vector], tuple[Vector, npt.NDArray[np.float64]]]
Compile = Callable[[sympy.Expr, tuple[sympy.Symbol, ...]], Function]

_CHOICES = 32  # safety: choices of the other conditions that are looked at for a surface
_STARTS = (0.0, 1.0, 30.0)  # safety: sizes of the region in which a search begins
# accuracy: distances by which conditions are met, in parts of 1 m or 1 rad
_MARGINS = (0.1, 1e-3, 1e-5, 1e-7)
_ROUNDED = 1e-15  # accuracy: a step in parts of the place, which is rounding
_DIGITS = 30  # accuracy: of differences of pieces, which a float may not tell from zero
# accuracy: of the terms of a difference; less is the rounding of numbers in the pieces
_ZERO = 1e-9
_BESIDE = (1e-9, 1e-6)  # accuracy: distances, m or rad, at which a step is still there
_SAMPLES = 3  # safety: places of a surface at which a difference that vanishes everywhere is taken
_STEPS = 15  # safety: Gauss-Newton steps of a search


class Jump(NamedTuple):
    """A surface, what an expression changes by across it, and what has to hold beside it."""

    condition: str
    g: sympy.Expr
    change: sympy.Expr
    others: tuple[tuple[sympy.Expr, int], ...]  # (g, sign that it must have)


def jumps(expression: sympy.Expr) -> Iterator[Jump]:
    """The surfaces of an expression at which its pieces may not meet."""
    expression = without_marks(expression)
    texts: dict[sympy.Expr, str] = {}
    bits: dict[sympy.Basic, sympy.Basic] = {}
    for relation in conditions([expression]):
        g = switching_function(relation)
        key = -g if -g in texts else g
        texts.setdefault(key, str(relation))
        bit = sympy.Symbol(f"bit {[*texts].index(key)}")
        bits[relation] = bit if key == g else sympy.Not(bit)
    choices = expression.xreplace(bits)
    symbols = {sympy.Symbol(f"bit {k}"): g for k, g in enumerate(texts)}
    for symbol, (g, text) in zip(symbols, texts.items(), strict=True):
        above, below = (choices.xreplace({symbol: side}) for side in (sympy.true, sympy.false))
        change = above - below
        others = [s for s in symbols if s in change.free_symbols]
        for chosen in islice(product((True, False), repeat=len(others)), _CHOICES):
            bound = dict(zip(others, map(sympy.sympify, chosen), strict=True))
            if (smooth := change.xreplace(bound)) != 0:
                signs = tuple(
                    (symbols[s], 1 if yes else -1) for s, yes in zip(others, chosen, strict=True)
                )
                yield Jump(text, g, smooth, signs)


def vanishes(jump: Jump, known: Numbers) -> bool:
    """Whether both pieces are equal all along a surface, as far as it can be solved for."""
    for q in sorted(kinds(jump.g, Coordinate), key=str):
        slope = sympy.diff(jump.g, q)
        if slope.free_symbols - {*known} or slope == 0:
            continue
        place = q - jump.g / slope
        random = np.random.default_rng(0)
        for _ in range(_SAMPLES):
            free = {*jump.change.free_symbols, *jump.g.free_symbols} - {*known}
            numbers = {s: sympy.Float(random.uniform(-2.0, 2.0)) for s in sorted(free, key=str)}
            numbers |= known
            numbers[q] = place.evalf(_DIGITS, subs=numbers)
            size, most = _size(jump.change, numbers), _size(sizes(jump.change), numbers)
            if _undefined(size, most) or not size <= _ZERO * most:
                return False
        return True
    return False


def differs(
    change: sympy.Expr, moving: list[sympy.Symbol], known: Numbers, point: Vector,
    normal: Vector,
) -> bool:  # fmt: skip
    """Whether the difference of two pieces is no zero of rounding, and stays beside the surface."""

    def at(expression: sympy.Expr, distance: float) -> Any:
        place = map(sympy.Float, point + distance * normal)
        return _size(expression, known | dict(zip(moving, place, strict=True)))

    here, most = at(change, 0.0), at(sizes(change), 0.0)
    if _undefined(here, most) or not here > _ZERO * most:
        return False
    beside = [at(change, sign * far) for sign in (-1, 1) for far in _BESIDE]
    return not _undefined(*beside) and all(bool(abs(one - here) < here / 2) for one in beside)


def _undefined(*sizes: Any) -> bool:
    """Whether one of some sizes is nan, which SymPy does not compare."""
    return any(isinstance(size, float) for size in sizes)


def _size(expression: sympy.Expr, numbers: Numbers) -> Any:
    """The size of an expression, of many digits; nan where it is not real and finite."""
    try:
        value = expression.evalf(_DIGITS, subs=numbers)
        return abs(value) if value.is_real and value.is_finite else math.nan
    except (TypeError, ValueError, ArithmeticError, AttributeError):
        return math.nan


def points(
    jump: Jump, moving: list[sympy.Symbol], rest: tuple[float, ...],
    symbols: tuple[sympy.Symbol, ...], start: Vector, function: Compile,
) -> Iterator[tuple[Vector, Vector]]:  # fmt: skip
    """(point, unit normal) of a surface where the other conditions hold, one a start at most."""
    surfaces = [jump.g, *(sign * g for g, sign in jump.others)]
    values = [function(g, symbols) for g in surfaces]
    slopes = [[function(sympy.diff(g, q), symbols) for q in moving] for g in surfaces]

    def scaled(place: Vector) -> tuple[Vector, npt.NDArray[np.float64]]:
        """The distances from all surfaces, nearly, and their gradients."""
        g = np.array([f(*place, *rest) for f in values])
        gradients = np.array([[f(*place, *rest) for f in row] for row in slopes])
        sizes = np.maximum(np.linalg.norm(gradients, axis=1), 1e-300)
        return g / sizes, gradients / sizes[:, None]

    random = np.random.default_rng(0)
    for size in _STARTS:
        begin = start + size * random.standard_normal(len(moving))
        for margin in _MARGINS:
            place = _search(scaled, begin, margin)
            if place is not None:
                yield place, scaled(place)[1][0]
                break


def _search(scaled: Distances, place: Vector, margin: float) -> Vector | None:
    """A point where the first function vanishes and the others are positive; None without one."""
    for all_of_them in (True, False):  # then back onto the surface alone
        for _ in range(_STEPS):
            g, gradients = scaled(place)
            if not (np.isfinite(g).all() and np.isfinite(gradients).all()):
                return None
            short = np.where((g < margin) & all_of_them, g - margin, 0.0)
            short[0] = g[0]
            change = np.linalg.lstsq(gradients * (short != 0.0)[:, None], short, rcond=1e-12)[0]
            place = place - change
            if np.abs(change).max() <= _ROUNDED * (1.0 + np.abs(place).max()):
                break
    g = scaled(place)[0]
    close = abs(g[0]) <= 1e3 * _ROUNDED * (1.0 + np.abs(place).max())
    return place if close and np.all(g[1:] > 0.0) else None


def sizes(node: sympy.Basic) -> sympy.Basic:
    """The expression with the sizes of all terms added up."""
    if isinstance(node, sympy.Piecewise):
        return sympy.Piecewise(*((sizes(e), c) for e, c in node.args), evaluate=False)
    if node.is_Add or node.is_Mul:
        return node.func(*map(sizes, node.args))
    if node.is_Pow and node.exp.is_nonnegative:
        return sympy.Pow(sizes(node.base), node.exp)
    return sympy.Abs(node)
