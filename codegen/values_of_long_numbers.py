"""Long numbers in expressions give way to their values, before SymPy expands and simplifies."""

import math

import sympy

from codegen.errors import FAILURES
from codegen.real_range import constant_value, distinct_nodes, evaluated, unreal_part

_NODES = 30  # safety: parts of a number that is kept as it is written
_TERMS = 150  # safety: of a power of a sum of numbers that is kept as it is written
_ROOTS = (sympy.CRootOf, sympy.RootSum)  # which no function of numbers is made of
_SMOOTH = (
    sympy.sin,
    sympy.cos,
    sympy.tan,
    sympy.asin,
    sympy.acos,
    sympy.atan,
    sympy.atan2,
    sympy.sinh,
    sympy.cosh,
    sympy.tanh,
    sympy.exp,
    sympy.log,
)


def maximal_numbers(expression: sympy.Basic) -> list[sympy.Expr]:
    """The largest parts of an expression that are numbers, but for plain ones."""
    found: dict[sympy.Expr, None] = {}
    waiting, seen = [expression], {expression}
    while waiting:
        node = waiting.pop()
        if node.is_Atom and (node.is_Number or node.is_Symbol):
            continue
        if isinstance(node, sympy.Expr) and node.is_number:
            if not (node.is_Number or node.is_NumberSymbol):
                found[node] = None
            continue
        inner = [a for a in node.args if isinstance(a, sympy.Basic) and a not in seen]
        seen.update(inner)
        waiting += inner
    return list(found)


def with_short_numbers(expression: sympy.Expr) -> sympy.Expr:
    """The expression with values of numbers: long ones, high powers, ones with kinks, odd ones.

    SymPy would look for their signs, and expand and simplify them, again and again.
    """
    if expression.is_Atom:
        return expression
    values = {}
    for number in maximal_numbers(expression):
        few = len(number.args) < _NODES and not number.is_Function
        if few and all(a.is_Atom for a in number.args):
            continue
        nodes = distinct_nodes(number)
        odd = any((n.is_Function and n.func not in _SMOOTH) or n.func in _ROOTS for n in nodes)
        if odd or len(nodes) > _NODES or any(n.is_Pow and n.base.is_Add for n in nodes):
            if unreal_part(number):
                return expression  # which is refused for it
            if not odd and len(nodes) <= _NODES and not _is_high(nodes):
                continue
            try:
                values[number] = evaluated(number)
            except FAILURES:
                return expression
    return expression.xreplace(values) if values else expression


def _is_high(nodes: list[sympy.Basic]) -> bool:
    """Whether a power of a sum among these has too many terms for being multiplied out."""
    powers = [n for n in nodes if n.is_Pow and n.base.is_Add and n.exp.is_rational]
    highest = ((len(n.base.args) - 1, abs(constant_value(n.exp))) for n in powers)
    return any(x > _TERMS or math.comb(int(x) + k, k) > _TERMS for k, x in highest)
