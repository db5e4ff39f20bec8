"""Conditions → switching functions: every smooth piece of a force gets a mode.

`Abs`, `Max`, `Min`, `sign` and `Heaviside` are written as pieces first, so that each step of an
integration sees a smooth function.
"""

from collections.abc import Iterable
from enum import IntEnum
from functools import partial
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from codegen.declare.symbols import Coordinate, Parameter, Speed, Time, Velocity, kinds
from codegen.derive.poles_of_conditions import without_poles
from codegen.errors import ModelError
from codegen.tables.branches import branches, end_pieces, range_function, without_ends
from codegen.tables.piecewise_cubic import Table
from codegen.tables.table_function import Interpolant, TableAtom

_MOVING = (Coordinate, Velocity, Time, Speed)
KINKED = (sympy.Abs, sympy.Max, sympy.Min, sympy.sign, sympy.Heaviside)
STEPS = (sympy.Mod, sympy.ceiling, sympy.floor)
"""Functions with a jump at every whole number, in which only what is known beforehand may stand."""
INVERSES = (sympy.asin, sympy.acos)
"""Functions that make a triangle wave of a sine or cosine, in closed form 0/0 at its corners."""


class Boundary(IntEnum):
    """What holds where a motion stays on g = 0 and no mode moves it from there."""

    OPEN = 0  # of g > 0: the condition does not
    CLOSED = 1  # of g ≥ 0: it does
    BALANCED = 2  # of sign and Heaviside: the mean of both sides
    MIXED = 3  # of conditions of different kinds on one velocity: each as it is written
    INDIFFERENT = 4  # of a kink such as Abs: both sides are the same

    def of_opposite(self) -> "Boundary":
        """The same of -g."""
        return Boundary(1 - self) if self in (Boundary.OPEN, Boundary.CLOSED) else self

    def joined_with(self, other: "Boundary") -> "Boundary":
        """What two conditions on one g agree on; MIXED where they do not."""
        if Boundary.INDIFFERENT in (self, other):
            return min(self, other)
        return self if self is other else Boundary.MIXED


class Mark(sympy.Function):  # type: ignore[misc]
    """One side of a condition, itself, with a mark that says what holds where both are equal."""

    is_extended_real = True
    means: Boundary

    @classmethod
    def eval(cls, side: sympy.Expr) -> sympy.Expr | None:
        """Numbers need no mark."""
        return side if side.is_number else None

    def _sympystr(self, printer: Any) -> str:
        return str(printer._print(self.args[0]))

    _latex = _sympystr


class Balanced(Mark):
    """Of sign and Heaviside."""

    means = Boundary.BALANCED


class Indifferent(Mark):
    """Of a kink."""

    means = Boundary.INDIFFERENT


def marked(condition: Boolean, mark: type[Mark]) -> Boolean:
    """A condition with its inequalities marked, in the form that SymPy gives them in pieces."""
    pieces = sympy.Piecewise((1, condition), (0, True))
    if not isinstance(pieces, sympy.Piecewise):
        return condition
    return pieces.args[0].cond.replace(
        lambda c: isinstance(c, Relational),
        lambda c: c.func(*((c.lhs, mark(c.rhs)) if c.lhs.is_number else (mark(c.lhs), c.rhs))),
    )


def without_marks(expression: sympy.Basic) -> Any:
    """An expression or condition with its marks taken off."""
    while marks := expression.atoms(Mark):  # one may stand inside another
        expression = expression.xreplace({mark: mark.args[0] for mark in marks})
    return expression


def boundary(condition: Relational) -> Boundary:
    """What holds at g = 0 of a condition g > 0 or g ≥ 0."""
    for mark in (Balanced, Indifferent):
        if condition.has(mark):
            return mark.means
    return Boundary.CLOSED if isinstance(condition, sympy.Ge | sympy.Le) else Boundary.OPEN


def as_pieces(expression: sympy.Expr, may_switch: bool = True) -> sympy.Expr:
    """The same function with every kink spelled out as a Piecewise, see `tables_by_branches`."""
    return tables_by_branches(kinks_as_pieces(expression), may_switch)


def kinks_as_pieces(expression: sympy.Expr) -> sympy.Expr:
    """The same function with every kink spelled out as a Piecewise, but for those of tables."""
    for inverse in INVERSES:
        if expression.has(inverse):
            expression = expression.replace(inverse, partial(_triangle, inverse))
    for function in KINKED:
        if expression.has(function):
            expression = expression.replace(function, partial(_pieces, function))
    if expression.has(sympy.Mod, sympy.ceiling):
        expression = expression.replace(sympy.Mod, lambda a, b: a - b * sympy.floor(a / b))
        expression = expression.replace(sympy.ceiling, lambda a: -sympy.floor(-a))
    return expression.replace(sympy.ITE, _alternatives)


def tables_by_branches(expression: sympy.Expr, may_switch: bool = True) -> sympy.Expr:
    """The same function with every table whose derivatives jump spelled out as a Piecewise.

    Where nothing may switch, in constraints, only those of the time and parameters. A condition
    compares the table itself where that is continuous: by branches, each of them would be a switch,
    and its events would be those of a table that does not act.
    """
    if not expression.has(Interpolant):
        return expression
    outside = _taken_outside_conditions(expression)

    def spelled_out(node: sympy.Basic) -> sympy.Basic:
        if isinstance(node, Relational):
            return _by_branches(may_switch, outside, node)
        arguments = tuple(spelled_out(a) if a.args else a for a in node.args)
        if isinstance(node, Interpolant):
            return _branches(may_switch, *arguments)
        return node if arguments == node.args else node.func(*arguments)

    return spelled_out(expression).replace(sympy.ITE, _alternatives)


Taken = set[tuple[sympy.Basic, sympy.Basic]]


def _by_branches(may_switch: bool, outside: Taken, relation: Relational) -> Boolean:
    """A condition by its tables' branches, unlike SymPy's; a continuous one that acts by itself."""
    found = sorted(relation.atoms(Interpolant), key=lambda i: len(i.atoms(Interpolant)))
    for node in found:
        data, order, at = node.args
        table: Table = data.table
        # Of a table that ends, what is outside says where the motion leaves it.
        if order <= table.smooth and (not table.stops or (data, at) in outside):
            continue
        value = _branches(may_switch, data, order, at)
        if isinstance(value, sympy.Piecewise):
            return _by_cases(may_switch, outside, relation, node, value)
    return relation


def _by_cases(
    may_switch: bool, outside: Taken, relation: Relational, node: sympy.Expr, value: sympy.Expr
) -> Boolean:
    """A condition with a value in place of a table."""
    if not isinstance(value, sympy.Piecewise):
        return _by_branches(may_switch, outside, relation.xreplace({node: value}))
    (first, condition), (second, _) = value.args
    cases = (_by_cases(may_switch, outside, relation, node, part) for part in (first, second))
    return _alternatives(condition, *cases)


def _taken_outside_conditions(expression: sympy.Basic) -> Taken:
    """(table, what it is taken at) of the tables that do more than switch."""
    found: Taken = set()
    stack = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Interpolant):
            found.add((node.args[0], node.args[2]))
        if not isinstance(node, Relational):
            stack += node.args
    return found


def _branches(
    may_switch: bool, data: TableAtom, order: sympy.Integer, at: sympy.Expr
) -> sympy.Expr:
    """A table by its smooth branches, and undefined beyond its ends alone.

    The third derivative of a spline jumps too. It matters where switches are, measured by the error
    of a run; a spline of the time stays as it is, for the sake of laws of motion.
    """
    table: Table = data.table
    known = is_known_beforehand(at)
    abrupt = table.smooth < 2 or table.held is not None
    splits = abrupt if known else may_switch
    if table.role != "values" or table.smooth > 2 or not (splits and kinds(at, *_MOVING)):
        return Interpolant(data, order, at)
    dealt = branches(table)

    def taken(part: Table, derivative: sympy.Expr = order) -> sympy.Expr:
        return Interpolant(TableAtom(part, data.unit), derivative, at)

    def positive(part: Table) -> Boolean:
        return marked(taken(part, sympy.S.Zero) > 0, Indifferent)

    inside = taken(without_ends(table) if table.stops else table)
    if dealt is not None:
        inside = sympy.Piecewise(
            (taken(dealt.even), positive(dealt.knots)), (taken(dealt.odd), True)
        )
    if not table.stops:
        return inside
    within = positive(range_function(table))
    return sympy.Piecewise((inside, within), (taken(end_pieces(table)), True))


def _triangle(inverse: type[sympy.Function], argument: sympy.Expr) -> sympy.Expr:
    """The inverse of a sine or cosine of the time by straight pieces, acos(cos u) = |u - 2πk|."""
    if not (isinstance(argument, sympy.sin | sympy.cos) and is_known_beforehand(argument)):
        return inverse(argument)
    phase = argument.args[0] - (sympy.pi / 2 if isinstance(argument, sympy.sin) else 0)
    apart = sympy.Mod(phase + sympy.pi, 2 * sympy.pi) - sympy.pi
    wave = sympy.Piecewise((apart, apart >= 0), (-apart, True))  # a corner: the side behind it
    return sympy.pi / 2 - wave if inverse is sympy.asin else wave


def _alternatives(condition: Boolean, yes: Boolean, no: Boolean) -> Boolean:
    """SymPy's form of a kink inside a condition, in terms of And, Or and Not."""
    return sympy.Or(sympy.And(condition, yes), sympy.And(sympy.Not(condition), no))


def _pieces(function: type[sympy.Function], *arguments: sympy.Expr) -> sympy.Expr:
    first = arguments[0]
    halves = {sympy.Abs: (first, -first), sympy.sign: (1, -1), sympy.Heaviside: (1, 0)}
    if function in halves:
        above, below = halves[function]
        if function is sympy.Heaviside and arguments[1] in (0, 1):
            condition = first >= 0 if arguments[1] == 1 else first > 0
        else:
            condition = marked(first > 0, Indifferent if function is sympy.Abs else Balanced)
        return sympy.Piecewise((above, condition), (below, True))
    *firsts, last = arguments
    pieces: list[tuple[sympy.Expr, Boolean | bool]] = []
    for k, one in enumerate(firsts):
        beats = sympy.Gt if function is sympy.Max else sympy.Lt
        wins = sympy.And(*(beats(one, other) for other in arguments[k + 1 :]))
        pieces.append((one, marked(wins, Indifferent)))
    return sympy.Piecewise(*pieces, (last, True))


def switching_function(condition: Relational) -> sympy.Expr:
    """g with `condition` ⇔ g > 0, without poles; a condition and its negation give g and -g."""
    if isinstance(condition, sympy.Eq | sympy.Ne):
        raise ModelError(
            f"the condition {condition} is an equality, which no motion meets for a time; "
            "use an inequality."
        )
    g: sympy.Expr = condition.gts - condition.lts
    return without_poles(without_marks(g) if g.has(Mark) else g)


def is_known_beforehand(node: sympy.Basic) -> bool:
    """Whether nothing but the time and parameters is in an expression."""
    return all(isinstance(symbol, Time | Parameter) for symbol in node.free_symbols)


def conditions(expressions: Iterable[sympy.Expr]) -> tuple[Relational, ...]:
    """Every inequality in the expressions, each once, in the order of its first appearance."""
    relations: dict[Relational, None] = {}
    stack: list[sympy.Basic] = list(expressions)[::-1]
    while stack:
        piece = stack.pop()
        if isinstance(piece, Relational):
            relations[piece] = None
        stack += piece.args[::-1]  # SymPy's own traversal takes And and Or by their hashes
    return tuple(relations)
