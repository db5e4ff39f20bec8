"""Powers that end where their piece does, such as δ^(3/2) of a contact, continued past the end.

An event is located between two states, one of them past it, and the force of the piece before is
asked for at both. A power b^e that is not whole has no number where b < 0, and a run would stop at
the switch. So where b is zero at the switch, it is written, n = ⌊e⌋, as

    b^e = b^n (b² + ε²)^((e - n)/2)

which is b^e to rounding from b = 1e-92 on, has a number on either side, and derivatives at b = 0.
Where e follows from parameters, n = 1, which does for all that are positive.
"""

import math
from collections.abc import Sequence

import sympy

from codegen.declare.symbols import Coordinate, Time, Velocity, kinds
from codegen.derive.switching import conditions, switching_function

_EPSILON_SQUARED = sympy.Float(1e-200)


def continued(expression: sympy.Expr) -> sympy.Expr:
    """The same function, its powers continued past the switches at which their base is zero.

    Parameters
    ----------
    expression
        With its kinks as pieces.
    """
    if not expression.has(sympy.Piecewise) or not any(map(_ends, expression.atoms(sympy.Pow))):
        return expression
    gaps = [switching_function(one) for one in conditions((expression,))]
    ends = {
        power: _past(power)
        for power in expression.atoms(sympy.Pow)
        if _ends(power) and _vanishes(power.base, gaps)
    }
    return expression.xreplace(ends)


def _ends(power: sympy.Pow) -> bool:
    """Whether a power has no number where its base is negative, and one where it is zero."""
    e = power.exp
    if not e.is_number:
        return not kinds(e, Coordinate, Velocity, Time)
    return bool(e.is_number and e.is_real and e > 0 and float(e) != math.floor(float(e)))


def _past(power: sympy.Pow) -> sympy.Expr:
    b, e = power.as_base_exp()
    whole = math.floor(float(e)) if e.is_number else 1
    return b**whole * (b**2 + _EPSILON_SQUARED) ** ((e - whole) / 2)


def _vanishes(base: sympy.Expr, gaps: Sequence[sympy.Expr]) -> bool:
    """Whether a base is zero at a switch: a piece itself, or a gap times what never changes."""
    _, rest = base.as_independent(Coordinate, Velocity, Time)
    if isinstance(rest, sympy.Piecewise):
        return True
    moving = kinds(base, Coordinate, Velocity, Time)
    for gap in gaps:
        if kinds(gap, Coordinate, Velocity, Time) != moving:
            continue
        if not kinds(sympy.cancel(base / gap), Coordinate, Velocity, Time):
            return True
    return False
