"""Functions of the position in a scene that may be narrow: a barrier, a magnet, a bump of a cam.

The length of a step follows the error of the motion, which feels nothing of what lies between the
places at which a method looks. A run therefore encloses these functions over each step
(`runtime.explicit_time.position_step_check`). A polynomial, a sine, a root, and a power, logarithm
or exponential of what is linear in the position are not narrow.
"""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import sympy
from sympy.core.relational import Relational

from codegen.declare.symbols import Coordinate, Parameter, Time, Velocity, kinds
from codegen.declare.table_function import Interpolant
from codegen.real_range import powers_with_number_outside

if TYPE_CHECKING:
    from codegen.derive.equations import ConstraintEquations, EffectEquations

_STEPS = (sympy.tanh, sympy.atan)
_BENDS = (sympy.exp, sympy.log)
_HIGH = 16  # measured: (1 - x²)^8 has a width of 0.3, which the error of a step shows


def position_functions(
    constraints: Iterable["ConstraintEquations"], effects: Iterable["EffectEquations"]
) -> tuple[sympy.Expr, ...]:
    """The largest parts of constraints, potentials and forces that may be narrow, each once."""
    found: dict[sympy.Expr, None] = {}
    for constraint in constraints:
        bindings = constraint.statement.bindings
        for expression in (*constraint.terms.phi, *bindings.values()):
            for part in _narrow_parts(expression, {*bindings}):
                found[part.xreplace(bindings)] = None
    for effect in effects:
        terms = effect.terms
        forces = (*(f for pair in terms.pulls for f in pair), *(f for _, f in terms.loads))
        for expression in (*forces, *([] if terms.potential is None else [terms.potential])):
            found |= dict.fromkeys(_narrow_parts(expression, set()))
    return tuple(part for part in found if kinds(part, Coordinate))


def _narrow_parts(expression: sympy.Basic, places: set[sympy.Basic]) -> Iterator[sympy.Expr]:
    """Parts of positions, and of `places` that stand for them, in the order of the text."""
    stack = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, sympy.Mul) and (powers := powers_with_number_outside(node)):
            whole = sympy.Mul(node.args[0], *powers)  # the number alone is no float
            if _is_of_position(whole, places):
                yield whole
                stack += [a for a in node.args[:0:-1] if a not in powers]
                continue
        if _is_of_position(node, places) and _may_be_narrow(node, places):
            yield node
        elif not isinstance(node, Relational):  # that is a switching function, which runs follow
            stack += node.args[::-1]


def _may_be_narrow(node: sympy.Basic, places: set[sympy.Basic]) -> bool:
    if isinstance(node, _STEPS):
        return True
    if isinstance(node, sympy.Pow):
        inner, exponent = node.args
        if not exponent.is_number:
            return True
        if 0 <= exponent < _HIGH:
            return False
        return exponent >= _HIGH or not _is_linear(inner, places)
    return isinstance(node, _BENDS) and not _is_linear(node.args[0], places)


def _is_linear(expression: sympy.Basic, places: set[sympy.Basic]) -> bool:
    """Whether an expression changes with the position, and nothing else, at a constant rate."""
    moving = {s for s in expression.free_symbols if not isinstance(s, Parameter)}
    return not any(moving & sympy.diff(expression, s).free_symbols for s in moving)


def _is_of_position(node: sympy.Basic, places: set[sympy.Basic]) -> bool:
    """Whether an expression has coordinates, the time and parameters in it alone, and no pieces.

    Steps end where pieces meet; of these, the parts are looked at.
    """
    known = (Coordinate, Time, Parameter)
    symbols = node.free_symbols
    moving = any(isinstance(s, Coordinate) or s in places for s in symbols)
    if not moving or any(isinstance(s, Velocity) for s in symbols):
        return False
    if not all(isinstance(s, known) or s in places for s in symbols):
        return False
    return not node.has(sympy.Piecewise, Interpolant, sympy.floor, sympy.ceiling, sympy.Mod)
