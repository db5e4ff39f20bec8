"""Potentials whose pieces do not meet: a step in V exerts no force, and the energy would jump.

The jump at a surface on which an expression changes its piece is the difference of the smooth
pieces on both sides, an expression of its own for each choice of the other conditions. Gauss-Newton
steps look for points of the surface at which these hold, however small the region; a step stays as
such a point is approached, a kink does not. Scalars along which forces act, such as gaps, are
looked at alike.
"""

import math
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.body import Bodies
from codegen.declare.element import Effect, label
from codegen.declare.returned_values import optional_terms, potential_of
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate, Time, dotted, kinds
from codegen.derive.equations import Parts
from codegen.derive.piecewise_conditions import (
    as_pieces,
    conditions,
    switching_function,
    without_marks,
)
from codegen.elements.forces.contacts import GapSprings
from codegen.readers.calls import errors_at
from codegen.readers.values import shown
from codegen.tables.table_function import plain_function

Vector = npt.NDArray[np.float64]
Numbers = dict[sympy.Symbol, float]

_CHOICES = 32  # safety: choices of the other conditions that are looked at for a surface
_STARTS = (0.0, 1.0, 30.0)  # safety: sizes of the region in which a search begins
# accuracy: distances by which conditions are met, in parts of 1 m or 1 rad
_MARGINS = (0.1, 1e-3, 1e-5, 1e-7)
_ROUNDED = 1e-15  # accuracy: a step of a search in parts of the place, which is rounding
_STEPS = 15  # safety: Gauss-Newton steps of a search
_DIGITS = 30  # accuracy: digits of differences of pieces that are below the smallest float
# accuracy: of the terms of a difference; less is the rounding of numbers in the pieces
_ZERO = 1e-9
_NEAR, _FAR = 1e-11, 1e-8  # accuracy: distances from a surface, in parts of the place


def step_problems(scene: Scene, parts: Parts, parameters: Numbers) -> Iterator[str]:
    """Steps in the potentials of a scene's effects, and in scalars along which forces act."""
    known = dict((*scene.guess, *scene.start))
    for effect in parts.effects.values() if parts.moves else ():
        with errors_at(label(effect)):
            for word, unit, expression in _continuous(effect, parts.bodies):
                numbers = {**parameters}
                for q in kinds(expression, Coordinate):
                    numbers[q] = float(known.get(dotted(q), q.measure.neutral))
                if found := find_step(expression, numbers):
                    condition, size, change = found
                    yield (
                        f"the {word} of {label(effect)} jumps by {size:.4g} {unit} where "
                        f"{condition} changes, at one such place, and by {shown(change)} in "
                        "general; a step exerts no force, and energy would come from nowhere: make "
                        "the pieces meet, or write a force."
                    )
                    break  # one of an effect is enough


def _continuous(effect: Effect, bodies: Bodies) -> Iterator[tuple[str, str, sympy.Expr]]:
    """(word, unit, expression) of what has to be continuous and may not be."""
    potential = potential_of(effect, bodies)
    answers = optional_terms(effect, bodies)
    scalars = [("length or angle", "m or rad", s) for s, _ in answers.pulls]
    if isinstance(effect, GapSprings):
        scalars = [("gap", "m", gap) for gap in effect.gaps]
    # A spring's k g²/2 ends at zero where g does; what its gap may have is looked at with the gap.
    known = potential is None or isinstance(effect, GapSprings)
    energy = [] if known else [("potential", "J", potential)]
    for word, unit, expression in (*energy, *scalars):
        yield word, unit, as_pieces(expression, may_switch=False)  # tables have no steps


class Step(NamedTuple):
    """A step: the condition that changes there, its size at a place, and as an expression."""

    condition: str
    size: float
    change: sympy.Expr


class _Jump(NamedTuple):
    """A surface, what an expression changes by across it, and what has to hold beside it."""

    condition: str
    g: sympy.Expr
    change: sympy.Expr
    others: tuple[tuple[sympy.Expr, int], ...]  # (g, sign that it must have)


def find_step(expression: sympy.Expr, numbers: Numbers) -> Step | None:
    """A step of an expression; None where none is found.

    `numbers` has the parameters and, of the coordinates, the values about which is looked.
    """
    moving = kinds(expression, Coordinate, Time)
    start = np.array([numbers.get(s, 1.0) for s in moving])
    others = {s: sympy.Float(numbers.get(s, 1.0)) for s in expression.free_symbols - {*moving}}
    for jump in _jumps(without_marks(expression)):
        if kinds(jump.g, Coordinate):
            surfaces = [g.xreplace(others) for g in (jump.g, *(s * g for g, s in jump.others))]
            sizes_at = _sizes_at(jump.change.xreplace(others), moving)
            for point, normal in _points(surfaces, moving, start):
                size = _step(sizes_at, point, normal)
                if size is not None:
                    return Step(jump.condition, size, jump.change)
    return None


def _jumps(expression: sympy.Expr) -> Iterator[_Jump]:
    """The surfaces of an expression at which its pieces may not meet."""
    sides: dict[sympy.Symbol, sympy.Expr] = {}  # symbol that says whether g > 0 → g
    texts: dict[sympy.Symbol, str] = {}
    choices: dict[sympy.Basic, sympy.Basic] = {}
    beside: dict[sympy.Symbol, tuple[tuple[sympy.Expr, int], ...]] = {}
    known: dict[sympy.Expr, sympy.Symbol] = {}
    for relation in conditions([expression]):
        g = switching_function(relation)
        if -g in known:
            choices[relation] = sympy.Not(known[-g])
            continue
        symbol = known.setdefault(g, sympy.Symbol(f"side {len(known)}"))
        choices[relation], sides[symbol] = symbol, g
        texts.setdefault(symbol, str(relation))
    for angle in sorted(expression.atoms(sympy.atan2), key=str):
        (y, x), symbol = angle.args, sympy.Symbol(f"side of {angle}")
        size = sympy.atan2(sympy.Abs(y), x)
        choices[angle] = sympy.Piecewise((size, symbol), (-size, True))
        sides[symbol], beside[symbol] = y, ((x, -1),)
        texts[symbol] = f"the sign of {angle} at ±π"
    chosen = expression.xreplace(choices)
    for symbol, g in sides.items():
        above, below = (chosen.xreplace({symbol: side}) for side in (sympy.true, sympy.false))
        change = above - below
        for smooth, others in islice(_smooth_pieces(change, sides), _CHOICES):
            yield _Jump(texts[symbol], g, smooth, (*others, *beside.get(symbol, ())))


def _smooth_pieces(
    change: sympy.Expr,
    sides: dict[sympy.Symbol, sympy.Expr],
    chosen: tuple[tuple[sympy.Expr, int], ...] = (),
) -> Iterator[tuple[sympy.Expr, tuple[tuple[sympy.Expr, int], ...]]]:
    """The smooth pieces of a difference that are not zero, each with (g, sign) of its region."""
    symbol = next((s for s in sides if s in change.free_symbols), None)
    if symbol is not None:
        for sign in (1, -1):
            piece = change.xreplace({symbol: sympy.sympify(sign > 0)})
            yield from _smooth_pieces(piece, sides, (*chosen, (sides[symbol], sign)))
    elif change != 0:
        yield change, chosen


def _sizes_at(change: sympy.Expr, moving: list[sympy.Symbol]) -> Callable[[Vector], list[Any]]:
    """At a place, the size of a difference and of its terms; nan where it has no real value."""
    expressions = change, _sizes(change)
    numbers = plain_function(moving, expressions)

    def exact(expression: sympy.Expr, place: Vector) -> Any:
        values = dict(zip(moving, map(sympy.Float, place), strict=True))
        try:
            value = expression.evalf(_DIGITS, subs=values)
            return abs(value) if value.is_real and value.is_finite else math.nan
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            return math.nan

    def at(place: Vector) -> list[Any]:
        found = np.abs(numbers(place))
        return [exact(e, place) for e in expressions] if found[1] == 0.0 else found.tolist()

    return at


def _step(sizes_at: Callable[[Vector], list[Any]], point: Vector, normal: Vector) -> float | None:
    """By how much two pieces differ at a point of their surface; None where they meet there."""
    found = []
    for side in (-1.0, 1.0):
        unit = side * (1.0 + np.abs(point).max()) * normal
        (near, terms), (far, _) = (sizes_at(point + d * unit) for d in (_NEAR, _FAR))
        if near == near and far == far:  # noqa: PLR0124 (both are numbers)
            if not (near > _ZERO * terms and near > far / 2):
                return None
            found.append(float(near))
    return max(found, default=None)


def _points(
    surfaces: list[sympy.Expr], moving: list[sympy.Symbol], start: Vector
) -> Iterator[tuple[Vector, Vector]]:
    """(point, unit normal) of the first surface where the others are positive, one a start."""
    values = plain_function(moving, surfaces)
    slopes = plain_function(moving, [[sympy.diff(g, q) for q in moving] for g in surfaces])

    def scaled(place: Vector) -> tuple[Vector, Vector]:
        """The distances from all surfaces, nearly, and their gradients."""
        g, gradients = values(place), slopes(place)
        sizes = np.maximum(np.linalg.norm(gradients, axis=-1), 1e-300)
        return g / sizes, gradients / sizes[..., None]

    random = np.random.default_rng(0)
    for size in _STARTS:
        begin = start + size * random.standard_normal(len(moving))
        for margin in _MARGINS:
            place = _search(scaled, begin, margin)
            if place is not None:
                yield place, scaled(place)[1][0]
                break


def _search(
    scaled: Callable[[Vector], tuple[Vector, Vector]], place: Vector, margin: float
) -> Vector | None:
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


def _sizes(node: sympy.Basic) -> sympy.Basic:
    """The expression with the sizes of all terms added up."""
    if isinstance(node, sympy.Piecewise):
        return sympy.Piecewise(*((_sizes(e), c) for e, c in node.args), evaluate=False)
    if node.is_Add or node.is_Mul:
        return node.func(*map(_sizes, node.args))
    if node.is_Pow and node.exp.is_nonnegative:
        return sympy.Pow(_sizes(node.base), node.exp)
    return sympy.Abs(node)
