"""Potentials whose pieces do not meet: a step in V exerts no force, and the energy would jump.

A point is sought on each surface at which an expression changes its piece, along random lines, and
then where the pieces differ (`codegen.check.boundary_points`); there both sides are compared at
distances that shrink to the rounding of the point. A step stays, a kink does not. Scalars along
which forces act, such as gaps, are looked at alike.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import sympy
from sympy.core.relational import Relational

from codegen.check.boundary_points import differs, jumps, points, sizes, vanishes
from codegen.declare.body import Body
from codegen.declare.element import Effect, label
from codegen.declare.returned_kinds import name_errors
from codegen.declare.returned_terms import optional_terms, potential_of
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate, Parameter, Time, kinds
from codegen.derive.piecewise_conditions import (
    as_pieces,
    conditions,
    switching_function,
    without_marks,
)
from codegen.elements.forces.contacts import GapSprings
from codegen.model import Model
from codegen.readers.values import shown
from codegen.tables.table_function import Interpolant

_LINES = 24  # safety: random lines along which a surface is sought, of sizes from 1e-3 to 1e3
_FOUND = 6  # safety: points of a surface that are looked at
# accuracy: of the terms on both sides; a step below it is the rounding of numbers in the pieces
_ROUNDED = 1e-9
_APART = 1e-14  # accuracy: of a line's size; the least distance of both sides
_FURTHER = 1e3  # accuracy: times that distance; a step is much larger than the change up to there
_BISECTIONS = 100  # safety: until two neighbouring numbers are reached, from any bracket
_SECANTS = 20  # safety: steps towards a surface that is far away

Scalar = Callable[[float], float]


@dataclass(frozen=True)
class _Line:
    """Functions of the place along a straight line of the coordinates."""

    value: Scalar  # of the expression
    terms: Scalar  # the sum of the sizes of its terms, as if nothing cancelled
    g: Scalar
    size: float


def step_problems(model: Model, scene: Scene) -> Iterator[str]:
    """Steps in the potentials of a scene's effects, and in scalars along which forces act."""
    if scene.analysis == "kinematics":
        return
    bodies = tuple(model.bodies[name] for name in scene.bodies)
    overrides = {Parameter(name, real=True): value for name, value in scene.parameters}
    known = dict((*scene.guess, *scene.start))
    for effect in model.acting(scene).values():
        with name_errors(effect):
            for sentence in _steps_of(effect, bodies, {**model.defaults, **overrides}, known):
                yield f"scene '{scene.name}': {sentence}"


def _steps_of(
    effect: Effect, bodies: tuple[Body, ...], defaults: dict[sympy.Symbol, float],
    known: dict[str, float],
) -> Iterator[str]:  # fmt: skip
    """The first step of what has to be continuous in an effect."""
    for word, unit, expression in _continuous(effect, bodies):
        numbers = {**defaults}
        for q in kinds(expression, Coordinate):
            numbers[q] = float(known.get(f"{q.owner}.{q.letter}", q.measure.neutral))
        if found := find_step(expression, numbers):
            place, below, above, change = found
            size = f"{abs(above - below):.4g} {unit} where {place} changes, from {below:.4g} to "
            size += f"{above:.4g} {unit} at one such place"
            if change is not None:
                size = f"{shown(change)} where {place} changes"
            yield (
                f"the {word} of {label(effect)} jumps by {size}; a step "
                "exerts no force, and energy would come from nowhere: make the pieces meet, or "
                "write a force."
            )
            return


def _continuous(effect: Effect, bodies: tuple[Body, ...]) -> Iterator[tuple[str, str, sympy.Expr]]:
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
    """A step: the condition that changes there, the values on both sides, or their difference."""

    place: str
    below: float
    above: float
    change: sympy.Expr | None = None


def find_step(expression: sympy.Expr, numbers: dict[sympy.Symbol, float]) -> Step | None:
    """A step of an expression; None where none is found.

    `numbers` has the parameters and, of the coordinates, the values about which is looked.
    """
    return _on_lines(expression, numbers) or _in_regions(expression, numbers)


def _in_regions(expression: sympy.Expr, numbers: dict[sympy.Symbol, float]) -> Step | None:
    """A step where the pieces on both sides of a surface differ, and their conditions hold."""
    if not expression.has(Relational):
        return None
    symbols = kinds(expression, Coordinate, Time)
    start = np.array([numbers.get(s, 1.0) for s in symbols])
    others = sorted(expression.free_symbols - {*symbols}, key=str)
    known = {s: numbers.get(s, 1.0) for s in others}
    everything = (*symbols, *others)
    rest = tuple(known.values())
    functions = [_function(e, everything) for e in (expression, sizes(expression))]
    for jump in jumps(expression):
        if not kinds(jump.g, Coordinate) or vanishes(jump, known):
            continue
        for point, normal in points(jump, symbols, rest, everything, start, _function):
            value, terms = (
                lambda s, f=f, o=point, a=normal: f(*(o + s * a), *rest) for f in functions
            )
            line = _Line(value, terms, value, float(np.abs(point).max(initial=1e-3)))
            if sides := _step(line, 0.0):
                return Step(jump.condition, *sides)
            if differs(jump.change, symbols, known, point, normal):
                return Step(jump.condition, 0.0, 0.0, jump.change)
    return None


def _on_lines(expression: sympy.Expr, numbers: dict[sympy.Symbol, float]) -> Step | None:
    """A step that a random line meets."""
    random = np.random.default_rng(0)
    for text, g in _surfaces(expression):
        moving = kinds(sympy.Tuple(expression, g), Coordinate)
        rest = sorted(sympy.Tuple(expression, g).free_symbols - {*moving}, key=str)
        start = np.array([numbers.get(s, 1.0) for s in moving])
        functions = [_function(e, (*moving, *rest)) for e in (expression, sizes(expression), g)]
        found = 0
        for _ in range(_LINES):
            size = 10.0 ** random.uniform(-3, 3)
            origin, along = start + size * random.standard_normal((2, len(moving)))
            along = along - start
            others = [numbers.get(s, random.uniform(0.5, 2.0)) for s in rest]
            value, terms, g_along = (
                lambda s, f=f, o=origin, a=along, r=others: f(*(o + s * a), *r) for f in functions
            )
            reach = float(np.abs(origin).max(initial=1e-3)) / size
            line = _Line(value, terms, g_along, reach)
            at = _root(line)
            if at is None:
                continue
            if sides := _step(line, at):
                return Step(text, *sides)
            found += 1
            if found == _FOUND:
                break
    return None


def _surfaces(expression: sympy.Expr) -> Iterator[tuple[str, sympy.Expr]]:
    """(condition, g) of the surfaces g = 0 at which an expression may have a step."""
    seen: list[sympy.Expr] = []
    found = [(str(c), switching_function(c)) for c in conditions([expression])]
    cuts = sorted(expression.atoms(sympy.atan2), key=str)
    for text, g in (*found, *((f"the sign of {a} at ±π", a.args[0]) for a in cuts)):
        if kinds(g, Coordinate) and g not in seen and -g not in seen:
            seen.append(g)
            yield text, g


def _function(expression: sympy.Expr, symbols: tuple[sympy.Symbol, ...]) -> Callable[..., float]:
    """The expression as a function of plain numbers, nan where it has no real value."""
    expression = without_marks(expression)
    tables: dict[str, Callable[[float], float]] = {}
    for k, node in enumerate(sorted(expression.atoms(Interpolant), key=str)):
        name, table, order = f"table_{k}", node.table, node.order
        tables[name] = lambda x, table=table, order=order: float(table(x, order))  # type: ignore[misc]
        expression = expression.xreplace({node: sympy.Function(name)(node.at)})
    compiled = sympy.lambdify(symbols, expression, [tables, "math"])

    def evaluated(*numbers: float) -> float:
        try:
            value = compiled(*map(float, numbers))
        except (ArithmeticError, ValueError, TypeError):
            return math.nan
        return math.nan if isinstance(value, complex) else float(value)

    return evaluated


def _root(line: _Line) -> float | None:
    """A place s at which g changes its sign along a line, to the last digit."""
    places = [float(s) for s in np.linspace(-3.0, 3.0, 13)]
    signs = [line.g(s) > 0 for s in places]
    low, high = next(
        (pair for k, pair in enumerate(pairwise(places)) if signs[k] != signs[k + 1]),
        _far_bracket(line, places[0], places[-1]),
    )
    side = line.g(low) > 0
    if side == (line.g(high) > 0):
        return None
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if (line.g(middle) > 0) == side else (low, middle)
    return low


def _far_bracket(line: _Line, a: float, b: float) -> tuple[float, float]:
    """An interval about the place where the secants through g end."""
    for _ in range(_SECANTS):
        one, other = line.g(a), line.g(b)
        if not math.isfinite(one + other) or one == other:
            break
        a, b = b, b - other * (b - a) / (other - one)
    wide = 1e-3 * (1.0 + abs(b))
    return b - wide, b + wide


def _step(line: _Line, at: float) -> tuple[float, float] | None:
    """The values on both sides where they stay apart; None where they meet."""
    least = max(_APART, 16.0 * np.finfo(float).eps * max(1.0, line.size, abs(at)))
    near, far = ([line.value(at + sign * d) for sign in (-1, 1)] for d in (least, _FURTHER * least))
    if not np.isfinite((*far, *near)).all():
        return None
    change = abs(near[1] - near[0])
    size = max(line.terms(at + sign * least) for sign in (-1, 1))
    course = max(abs(far[k] - near[k]) for k in (0, 1))
    return (near[0], near[1]) if change > max(0.5 * course, _ROUNDED * size) else None
