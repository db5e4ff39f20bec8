"""Continuation of powers, such as δ^(3/2) of a contact, past the end of their piece.

An event is located between two states, one of them past it, and the force of the piece before is
asked for at both. A power b^e that is not whole has no number where b < 0, and a run would stop at
the switch. Where the conditions of a piece say that b = c g, with g ≥ 0 and c from parameters, it
is written in that piece, n = ⌊e⌋, as

    b^e = c^e gⁿ (g² + ε²)^((e - n)/2)

which is b^e to rounding from g = 1e-92 on, has a number on either side, and derivatives at g = 0.
Where e follows from parameters, n = 1, which does for all that are positive. What stands in
another piece, or in none, stays: g may be negative there, and the power have a value, or rightly
none.
"""

import math

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from codegen.declare.symbols import Coordinate, Speed, Time, Velocity, kinds
from codegen.derive.piecewise_conditions import switching_function

_EPSILON_SQUARED = sympy.Float(1e-200)
_MOVING = (Coordinate, Velocity, Time, Speed)

Facts = tuple[sympy.Expr, ...]  # not negative where the value of another expression is used


def continue_powers(expression: sympy.Expr) -> sympy.Expr:
    """A function in pieces, its powers continued past the switches at which their base is zero."""
    if not expression.has(sympy.Piecewise):
        return expression
    return _continue(expression, Facts())


def _continue(node: sympy.Basic, facts: Facts) -> sympy.Basic:
    """The node with its powers continued past the ends of the facts."""
    if not any(map(_ends_at_zero, node.atoms(sympy.Pow))):
        return node
    if isinstance(node, sympy.Piecewise):
        return _pieces(node, facts)
    if isinstance(node, Relational):
        facts = Facts()  # a condition is evaluated in all pieces
    elif isinstance(node, sympy.Pow) and _ends_at_zero(node):
        return _power(node, facts)
    elif isinstance(node, sympy.Mul):
        return _rebuild(
            node, [_continue(f, (*facts, *_facts_of_cofactors(f, node))) for f in node.args]
        )
    return _rebuild(node, [_continue(part, facts) for part in node.args])


def _rebuild(node: sympy.Basic, parts: list[sympy.Basic]) -> sympy.Basic:
    return node if tuple(parts) == node.args else node.func(*parts)


def _pieces(node: sympy.Piecewise, facts: Facts) -> sympy.Expr:
    """Every piece by the facts that hold in it."""
    pairs = tuple(
        (_continue(piece, (*facts, *here)), _continue(condition, Facts()))
        for (piece, condition), here in zip(node.args, _facts_of_pieces(node), strict=True)
    )
    if pairs == tuple(map(tuple, node.args)):
        return node
    # As they are: √x and √-x become the same, but have a switch between them.
    return sympy.Piecewise(*pairs, evaluate=False)


def _facts_of_pieces(node: sympy.Piecewise) -> list[Facts]:
    """The facts of each piece: its condition holds, and none of those before it."""
    facts: list[Facts] = []
    before: list[tuple[Boolean, bool]] = []
    for _, condition in node.args:
        facts.append(_conclude([*before, (condition, True)]))
        before.append((condition, False))
    return facts


def _conclude(conditions: list[tuple[Boolean, bool]]) -> Facts:
    """Expressions that are not negative where conditions hold or, as stated, do not.

    Of several, one of which is not negative, the largest is: ``Max(0, x, y)`` has x where one of
    x and y is not negative, and x > y.
    """
    facts: dict[sympy.Expr, None] = {}
    open_ones: list[Facts] = []
    for condition, holds in conditions:
        for alternatives in _alternatives(condition, holds):
            facts.update(dict.fromkeys(alternatives if len(alternatives) == 1 else ()))
            open_ones.append(alternatives)
    for alternatives in reversed(open_ones):
        for one in alternatives:
            if all(one == other or one - other in facts for other in alternatives):
                facts[one] = None
    return tuple(facts)


def _alternatives(condition: Boolean, holds: bool) -> list[Facts]:
    """Of each of these, at least one is not negative where a condition holds, or does not."""
    if isinstance(condition, Relational):
        gap = switching_function(condition)
        return [(gap if holds else -gap,)]
    if isinstance(condition, sympy.Not):
        return _alternatives(condition.args[0], not holds)
    if not isinstance(condition, sympy.And | sympy.Or):
        return []
    each = [_alternatives(one, holds) for one in condition.args]
    if isinstance(condition, sympy.And) is holds:
        return [alternatives for one in each for alternatives in one]
    if all(len(one) == 1 for one in each):
        return [tuple(fact for one in each for fact in one[0])]
    return []


def _facts_of_cofactors(factor: sympy.Expr, product: sympy.Mul) -> Facts:
    """The facts where the other factors are not zero, as in ``Heaviside(x) * x**1.5``."""
    facts = Facts()
    for other in product.args:
        if isinstance(other, sympy.Piecewise) and other != factor:
            pairs = zip(other.args, _facts_of_pieces(other), strict=True)
            acting = [here for (piece, _), here in pairs if piece != 0]
            facts += acting[0] if len(acting) == 1 else Facts()
    return facts


def _ends_at_zero(power: sympy.Pow) -> bool:
    """Whether a power has no number where its base is negative, and one where it is zero."""
    e = power.exp
    if not e.is_number:
        terms = sympy.Add.make_args(e)
        falls = all(term.as_coeff_Mul()[0].is_negative for term in terms)
        return not falls and not kinds(e, *_MOVING)
    return bool(e.is_real and e > 0 and float(e) != math.floor(float(e)))


def _power(power: sympy.Pow, facts: Facts) -> sympy.Expr:
    base, e = power.args
    factors = sympy.Mul.make_args(base)
    pieces = [factor for factor in factors if isinstance(factor, sympy.Piecewise)]
    if len(pieces) == 1:
        # The power of each piece, since the pieces may differ in sign.
        cofactor = sympy.Mul(*(factor for factor in factors if factor != pieces[0]))
        each = sympy.Piecewise(*(((cofactor * one) ** e, where) for one, where in pieces[0].args))
        changed = _continue(each, facts)
        if changed != each:
            return changed
    moving = kinds(base, *_MOVING)
    for gap in facts:
        if not moving or kinds(gap, *_MOVING) != moving:
            continue
        share = sympy.cancel(base / gap)
        if kinds(share, *_MOVING) or share.is_nonpositive:
            continue
        if share.is_nonnegative:
            return _past(_continue(base, facts), e)
        return share**e * _past(_continue(gap, facts), e)
    return _rebuild(power, [_continue(base, facts), e])


def _past(b: sympy.Expr, e: sympy.Expr) -> sympy.Expr:
    whole = math.floor(float(e)) if e.is_number else 1
    return b**whole * (b**2 + _EPSILON_SQUARED) ** ((e - whole) / 2)
