"""Peaked functions of the position in a scene: a barrier, a magnet, a detent, a bump of a cam.

The length of a step follows the error of the motion, which feels nothing of a peak between the
places at which a method looks. A run therefore watches the arguments of these functions in each
step (`runtime.hybrid.step_limits`): they change slowly where the functions do not.
"""

from collections.abc import Iterable, Iterator
from itertools import combinations
from typing import TYPE_CHECKING, Literal, NamedTuple

import sympy

from codegen.declare.symbols import Coordinate, Parameter, Time
from codegen.derive.element_expressions import element_expressions
from codegen.derive.piecewise_conditions import (
    STEPS,
    as_pieces,
    boundary,
    conditions,
    is_known_beforehand,
    switching_function,
)
from codegen.derive.switching_functions import Switch, find_switch
from codegen.readers.expressions import powers_with_number_outside
from codegen.tables.table_function import Interpolant

if TYPE_CHECKING:
    from codegen.derive.equations import ConstraintEquations, EffectEquations

Kind = Literal["exponential", "step", "power"]

_STEPS = (sympy.tanh, sympy.atan)
_PARTS_OF_STEPS = (sympy.cosh, sympy.sinh)  # below a fraction's line
_FUNCTIONS = (sympy.Pow, sympy.log, *_STEPS, *_PARTS_OF_STEPS, sympy.exp)  # that may peak
_HIGH = 16  # measured: (1 - x²)^8 has a width of 0.3, which the error of a step shows


class PeakedFunction(NamedTuple):
    """A function that may peak where the motion takes its argument u to an extremum, or to zero.

    It is e^u, a "step" such as tanh u, or |u|^exponent.
    """

    element: str
    kind: Kind
    exponent: float  # of a power, else 0
    argument: sympy.Expr


def peaked_functions(
    constraints: Iterable["ConstraintEquations"],
    effects: Iterable["EffectEquations"],
    switches: tuple[Switch, ...],
) -> tuple[PeakedFunction, ...]:
    """The functions of constraints, potentials and forces that may peak, each argument once."""
    found: dict[tuple[Kind, bool, sympy.Expr], PeakedFunction] = {}
    for element, expression, _ in element_expressions(constraints, effects, _FUNCTIONS):
        for function in _functions(element, expression):
            if not _is_translatable(function.argument, switches):
                continue
            key = function.kind, function.exponent > 0.0, function.argument
            known = found.get(key)
            if known is None or abs(known.exponent) < abs(function.exponent):
                found[key] = function
    return tuple(found.values())


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
    """Whether an expression has coordinates, among them one, the time and parameters in it alone.

    Tables have their knots, and jumps their events.
    """
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
