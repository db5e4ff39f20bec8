"""Functions in the equations of a scene that a run watches: tables, laws in time, narrow peaks.

A switch ends a simulation where an effect's table does (`codegen.derive.piecewise_conditions`); all
other analyses, and tables of motion laws and constraints, have no number beyond: messages name the
table, and what it is taken at.

At explicit functions of time, the largest parts of the equations without coordinates, a run looks
before its first step (`runtime.mechanism.explicit_time`): where they bend sharply its steps are
short, and where their pieces meet steps end.

Peaked functions of the position are a barrier, a magnet, a detent, a bump of a cam. The length of a
step follows the error of the motion, which feels nothing of a peak between the places at which a
method looks. A run therefore watches their arguments in each step (`runtime.hybrid.step_limits`):
they change slowly where the functions do not.
"""

from collections.abc import Iterator
from itertools import combinations, zip_longest
from typing import Literal, NamedTuple

import sympy
from sympy.core.relational import Relational

from codegen.declare.element import Rigid
from codegen.declare.symbols import SPEED, Coordinate, Parameter, Time, Velocity, kinds
from codegen.derive.equations import Equations
from codegen.derive.piecewise_conditions import (
    STEPS,
    as_pieces,
    boundary,
    conditions,
    is_known_beforehand,
    switching_function,
)
from codegen.derive.switching_functions import Switch, find_switch, rate
from codegen.readers.expressions import distinct_nodes, powers_with_number_outside
from codegen.tables.piecewise_function import ClosedPieces
from codegen.tables.table_function import Interpolant


class ElementExpression(NamedTuple):
    """An expression by coordinates and velocities, the time and parameters."""

    element: str
    expression: sympy.Expr
    along: sympy.Expr | None = None  # the scalar along which it is a force, with SPEED its rate


def element_expressions(
    equations: Equations, *functions: type[sympy.Basic]
) -> Iterator[ElementExpression]:
    """Those that have any of `functions`: of constraints, with their bindings, and of effects."""
    for constraint in equations.constraints:
        bindings = constraint.statement.bindings
        for expression in (*constraint.terms.phi, *bindings.values()):
            if expression.has(*functions):
                yield ElementExpression(constraint.name, expression.xreplace(bindings))
    for effect in equations.effects:
        scalars = [s for pair in effect.terms.pulls for s in (None, pair[0])]
        for expression, along in zip_longest(effect.terms.moving, scalars):
            if expression.has(*functions) or (along is not None and along.has(*functions)):
                yield ElementExpression(effect.name, expression, along)


class TableRange(NamedTuple):
    """A table that is undefined beyond its ends, and the expression that it is taken at."""

    element: str
    table: str
    at: sympy.Expr
    low: float
    high: float


def table_ranges(equations: Equations) -> tuple[TableRange, ...]:
    """The tables of constraints and effects that a motion may leave, each use once."""
    found: dict[TableRange, None] = {}
    for element, expression, along in element_expressions(equations, Interpolant):
        moved = along is not None and expression.has(SPEED)
        taken = expression.xreplace({SPEED: rate(along)}) if moved else expression
        for node in sorted(taken.atoms(Interpolant), key=str):
            table = node.table
            moves = kinds(node.at, Coordinate, Velocity, Time)
            if table.stops and table.role in ("values", "end") and moves:
                found[TableRange(element, table.name, node.at, table.first, table.last)] = None
    return tuple(found)


Role = Literal["law", "effect", "place"]


class TimeFunction(NamedTuple):
    """A function of time and parameters alone, and the element that it belongs to."""

    element: str
    # a "law" chooses its pieces by the time itself, an "effect" by its modes; so does a "place",
    # which may not jump where its rate acts
    role: Role
    expression: sympy.Expr
    along: tuple[tuple[sympy.Expr, sympy.Expr], ...] = ()  # (s, f) of the forces, of a "place"


def time_functions(equations: Equations) -> tuple[TimeFunction, ...]:
    """The explicit functions of time of constraints and effects, each once."""
    found: dict[TimeFunction, None] = {}
    for constraint in equations.constraints:
        for expression in (*constraint.terms.phi, *constraint.statement.bindings.values()):
            for part in _parts(expression):
                found[TimeFunction(constraint.name, "law", part)] = None
    for effect in equations.effects:
        moving = [(s, f, {*_parts(s)}) for s, f in effect.terms.pulls if _takes_rate(f, s)]
        hold = vars(effect.terms.hold).values() if effect.terms.hold else ()
        parts = (part for part in hold if isinstance(part, sympy.Basic))
        if isinstance(effect.terms.hold, Rigid):  # its reaction keeps up with the gap at any rate
            moving.append((gap := effect.terms.hold.gap, SPEED, {*_parts(gap)}))
        for expression in (*effect.terms.moving, *parts):
            for part in _parts(expression):
                along = tuple((s, f) for s, f, places in moving if part in places)
                role: Role = "place" if along else "effect"
                role = "law" if part.has(ClosedPieces) else role
                found[TimeFunction(effect.name, role, part, along)] = None
    return tuple(found)


def _takes_rate(force: sympy.Expr, scalar: sympy.Expr) -> bool:
    """Whether a force takes the rate of the scalar along which it acts, by name or written out."""
    rates = {q.rate for q in kinds(scalar, Coordinate)}
    return force.has(SPEED) or (bool(rates) and rates <= {*kinds(force, Velocity)})


def is_of_time(node: sympy.Basic) -> bool:
    """Whether nothing but the time and parameters is in an expression, the time among it."""
    return is_known_beforehand(node) and any(isinstance(s, Time) for s in node.free_symbols)


def _parts(expression: sympy.Basic) -> Iterator[sympy.Expr]:
    """The largest parts of an expression that are functions of time, in the order of the text."""
    stack: list[sympy.Basic] = [expression] if expression.has(Time) else []
    while stack:
        node = stack.pop()
        if isinstance(node, Relational) and is_of_time(node):
            g = switching_function(node)
            yield sympy.Piecewise((sympy.S.One, g > 0), (sympy.S.Zero, True))
        elif isinstance(node, sympy.Add | sympy.Mul):
            timely = [a for a in node.args if is_of_time(a)]
            if timely and powers_with_number_outside(node):
                timely.insert(0, node.args[0])
            if timely:
                yield node.func(*timely)
            stack += [a for a in node.args[::-1] if a not in timely]
        elif isinstance(node, sympy.Expr) and is_of_time(node):
            yield node
        else:
            stack += node.args[::-1]


Kind = Literal["exponential", "step", "power", "kink"]

_ROOT = -0.5  # formula: exponent of the slope of a root
_STEPS = (sympy.tanh, sympy.atan)
_PARTS_OF_STEPS = (sympy.cosh, sympy.sinh)  # below a fraction's line
_FUNCTIONS = (sympy.Pow, sympy.log, *_STEPS, *_PARTS_OF_STEPS, sympy.exp)  # that may peak
_HIGH = 16  # measured: power; (1 - x²)^8 has a width of 0.3, which the error of a step shows


class PeakedFunction(NamedTuple):
    """A function that may peak where the motion takes its argument u to an extremum, or to zero.

    It is e^u, a "step" such as tanh u, or |u|^exponent. A "kink" is a place u = 0 at which the
    equation of a joint or driver is not smooth, with the kind of place and the function in words.
    """

    element: str
    kind: Kind
    exponent: float  # of a power, else 0
    argument: sympy.Expr
    place: tuple[str, ...] = ()  # of a kink


def peaked_functions(equations: Equations) -> tuple[PeakedFunction, ...]:
    """The functions of constraints, potentials and forces that may peak, each argument once."""
    found: dict[tuple[Kind, bool, sympy.Expr], PeakedFunction] = {}
    for element, expression, _ in element_expressions(equations, *_FUNCTIONS):
        for function in _functions(element, expression):
            if not _is_translatable(function.argument, equations.switches):
                continue
            key = function.kind, function.exponent > 0.0, function.argument
            known = found.get(key)
            if known is None or abs(known.exponent) < abs(function.exponent):
                found[key] = function
    return tuple(found.values())


_KINKED = (sympy.Pow, sympy.asin, sympy.acos, sympy.atan2)


def kinks(equations: Equations) -> Iterator[PeakedFunction]:
    """The places at which equations of joints and drivers are not smooth, each once.

    Roots at 0, asin and acos at the ends of their range, atan2 at its cut and at its origin,
    atan and other bounded functions at poles of their arguments.
    """
    found = dict[sympy.Expr, None]()
    for constraint in equations.constraints:
        bindings = constraint.statement.bindings
        if not any(e.has(*_KINKED) for e in (*constraint.terms.phi, *bindings.values())):
            continue
        for phi in (phi.xreplace(bindings) for phi in constraint.terms.phi):
            for node in distinct_nodes(phi):
                for argument, kind in _kinks_of(node, phi) if node.has(Coordinate) else ():
                    if argument not in found and not argument.is_positive:
                        found[argument] = None
                        place = kind, str(node)
                        yield PeakedFunction(constraint.name, "kink", _ROOT, argument, place)


def _kinks_of(node: sympy.Basic, phi: sympy.Expr) -> Iterator[tuple[sympy.Expr, str]]:
    """What vanishes where a node of Φ is not smooth, and the kind of that place."""
    half = sympy.Rational(1, 2)
    if isinstance(node, sympy.Pow) and node.exp.is_number and 0 < node.exp < 1:
        base = node.base
        if not base.is_nonnegative and base.is_polynomial(*kinds(base, Coordinate)):
            base = sympy.factor(base)  # perhaps a square
        if not base.is_nonnegative or node.exp < half:
            yield node.base, "steep"
        elif node.exp == half and not _is_gentle(node, base, phi):
            yield node.base, "root"
    elif isinstance(node, sympy.asin | sympy.acos):
        yield 1 - node.args[0] ** 2, "end"
    elif isinstance(node, sympy.atan2):
        y, x = node.args
        if phi.xreplace({node: node + 2 * sympy.pi}) != phi:  # else turns do not count
            yield sympy.cos(node / 2) ** 2, "cut"
        yield x**2 + y**2, "origin"
    if isinstance(node, sympy.atan | sympy.tanh) or (node.is_Pow and node.exp.is_negative):
        # What is bounded at a pole of its argument may jump there.
        divisor = sympy.fraction(sympy.together(node.args[0]))[1]
        if divisor.has(Coordinate) and phi.xreplace({node: node + sympy.pi}) != phi:
            yield divisor**2, "quotient"


def _is_gentle(root: sympy.Pow, squares: sympy.Expr, phi: sympy.Expr) -> bool:
    """Whether Φ has a continuous slope where a sum of `squares` vanishes under a root.

    All are fourth powers there, or the factor of the root in Φ's differential vanishes with them.
    """
    size = sympy.Dummy()
    factor = phi.xreplace({root: size}).diff(size).xreplace({size: sympy.S.Zero})
    terms = sympy.Add.make_args(squares)
    powers = [term.as_coeff_Mul()[1].as_base_exp() for term in terms]
    if all(exponent >= 4 for base, exponent in powers if base.has(Coordinate)):
        return True
    for base, _ in powers:
        factor = factor.subs(base, 0)
        for s in [s for s in base.atoms(Coordinate) if base.diff(s).is_number][:1]:
            factor = factor.subs(s, s - base / base.diff(s))
    return bool(factor.expand() == 0)


def _functions(element: str, expression: sympy.Basic) -> Iterator[PeakedFunction]:
    """The functions in an expression that may peak, in the order of the text."""
    stack = [(expression, False)]
    while stack:
        node, divides = stack.pop()
        if not any(isinstance(s, Coordinate) for s in node.free_symbols):
            continue
        if isinstance(node, sympy.Expr) and _is_of_position(node):
            yield from _function(element, node, divides)
        below = divides or _may_divide(node)
        stack += [(a, below) for a in node.args[::-1]]


def _function(element: str, node: sympy.Expr, divides: bool) -> Iterator[PeakedFunction]:
    """A node as a function that may peak; it is below a fraction's line if it `divides`."""
    if isinstance(node, _STEPS) or (divides and isinstance(node, _PARTS_OF_STEPS)):
        yield PeakedFunction(element, "step", 0.0, node.args[0])
    elif isinstance(node, sympy.log) and _may_dip(node.args[0]):
        yield PeakedFunction(element, "power", -1.0, node.args[0])
    elif isinstance(node, sympy.Add) and divides:
        # 1 / (1 + e^u) is a step, where one of two terms takes over from the other.
        for one, other in combinations(_logarithms(node), 2):
            yield PeakedFunction(element, "step", 0.0, one - other)
    elif (u := _logarithm(node)) is not None:
        if not _is_linear(u):
            yield PeakedFunction(element, "exponential", 0.0, u)
    elif isinstance(node, sympy.Pow) and node.exp.is_number:
        x = float(node.exp)
        if (x < 0.0 or x >= _HIGH) and _may_dip(node.base):
            yield PeakedFunction(element, "power", x, node.base)


def _may_dip(base: sympy.Expr) -> bool:
    """Whether the base of a power may come near to an extremum without another function's help.

    A sum of exponentials and a constant does so where one takes over from another, which is a step.
    """
    moving = [term for term in sympy.Add.make_args(base) if not _is_constant(term)]
    exponential = all(
        isinstance(term, _PARTS_OF_STEPS) or _logarithm_of_product(term) is not None
        for term in moving
    )
    return not exponential and not _is_linear(base)


def _logarithm(node: sympy.Expr) -> sympy.Expr | None:
    """log|b^x| of a power whose exponent moves, or of a product of such and numbers, else None."""
    base, exponent = node.as_base_exp()
    if not exponent.is_number:
        return _logarithm_of_power(base, exponent)
    if isinstance(node, sympy.Mul) and powers_with_number_outside(node):
        return _logarithm_of_product(node)
    return None


def _logarithm_of_power(base: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr | None:
    """log|b^x|; None for powers of 0."""
    if base.is_number:
        return None if base == 0 else exponent * _logarithm_of_constant(base)
    return exponent * sympy.log(base)


def _logarithm_of_product(node: sympy.Expr) -> sympy.Expr | None:
    """log of a product of constants and at least one power whose exponent moves, else None."""
    factors = sympy.Mul.make_args(node)
    constants = [factor for factor in factors if _is_constant(factor)]
    powers = [factor.as_base_exp() for factor in factors if not _is_constant(factor)]
    if not powers or any(exponent.is_number for _, exponent in powers):
        return None
    logarithms = [_logarithm_of_power(*power) for power in powers]
    if None in logarithms:
        return None
    return sympy.Add(*logarithms, *map(_logarithm_of_constant, constants))


def _logarithms(node: sympy.Add) -> list[sympy.Expr]:
    """Logarithms of the exponential terms of a sum, and of its constant, or of 1 without any."""
    found = [u for u in map(_logarithm_of_product, node.args) if u is not None]
    constant = sympy.Add(*filter(_is_constant, node.args))
    if len(found) == 1 or constant != 0:
        found.append(_logarithm_of_constant(constant) if constant != 0 else sympy.S.Zero)
    return found if len(found) > 1 else []


def _logarithm_of_constant(constant: sympy.Expr) -> sympy.Expr:
    """log|c|, for parameters of any sign without a kink."""
    return sympy.log(abs(constant)) if constant.is_number else sympy.log(constant**2) / 2


def _is_constant(node: sympy.Expr) -> bool:
    return all(isinstance(s, Parameter) for s in node.free_symbols)


def _may_divide(node: sympy.Basic) -> bool:
    """Whether a node is a power of which parameters or the motion may make a quotient."""
    return isinstance(node, sympy.Pow) and not (node.exp.is_number and node.exp >= 0)


def _is_linear(expression: sympy.Expr) -> bool:
    """Whether an expression changes with the position, and nothing else, at a constant rate."""
    moving = {s for s in expression.free_symbols if not isinstance(s, Parameter)}
    return not any(moving & sympy.diff(expression, s).free_symbols for s in moving)


def _is_of_position(node: sympy.Basic) -> bool:
    """Whether an expression is of one coordinate or more, t and parameters alone, not of tables."""
    known = (Coordinate, Time, Parameter)
    if not all(isinstance(s, known) for s in node.free_symbols):
        return False
    moving = any(isinstance(s, Coordinate) for s in node.free_symbols)
    return moving and not node.has(Interpolant, *STEPS)


def _is_translatable(argument: sympy.Expr, switches: tuple[Switch, ...]) -> bool:
    """Whether modes of the scene choose the pieces of an argument, where it has some."""
    for condition in conditions([as_pieces(argument)]):
        if is_known_beforehand(condition):
            return False
        if find_switch(switching_function(condition), boundary(condition), switches) is None:
            return False
    return True
