"""Forces along a scalar s(q, t), such as a length, an angle or a gap: what springs share."""

import sympy

from codegen.declare.body import Body
from codegen.declare.symbols import Coordinate, Time, Velocity, kinds, t


def rate(s: sympy.Expr) -> sympy.Expr:
    """ds/dt = s_q q̇ + s_t."""
    slopes = (sympy.diff(s, q) * q.rate for q in kinds(s, Coordinate))
    return sympy.Add(*slopes, sympy.diff(s, t))


def without_angle(where: str, *bodies: Body) -> list[str]:
    """Particles among the bodies, which nothing can turn, and bodies that count no angle."""
    return [
        f"{where} needs the angle of '{body.name}', which has none: it is oriented by "
        f"{', '.join(q.letter for q in body.coordinates)}. Use an element that asks for points."
        for body in bodies
        if body.angle is None
    ] + [
        f"{where} turns '{body.name}', which is a particle and has no angle; use a body."
        for body in bodies
        if not body.turns
    ]


def constant(*expressions: sympy.Expr) -> bool:
    """Whether the expressions are numbers or parameters, the same throughout a run."""
    return not any(kinds(e, Coordinate, Velocity, Time) for e in expressions)


def negative(expression: sympy.Expr) -> bool:
    """Whether an expression is a number, and less than zero."""
    return bool(expression.is_number and expression.is_real and expression < 0)
