"""One constraint element → its equations and reactions, derived once for each statement.

All elements of a type state the same placeholder equations, so a machine of a thousand revolute
joints differentiates one of them.

Is an expression zero, whatever its symbols are? Numbers tell sooner than expanding does.
"""

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import NamedTuple

import sympy

from codegen.declare.element import (
    ConjugateReaction,
    Constraint,
    JointReaction,
    Statement,
    WrenchReaction,
)
from codegen.declare.returned_values import statement_of
from codegen.declare.symbols import Coordinate, Multiplier, derivative, kinds, t
from codegen.derive.piecewise_conditions import as_pieces
from codegen.derive.wrench import wrench

# safety: golden and silver ratio; symbols get fractional parts of multiples of these
_POINTS = (0.6180339887498949, 0.4142135623730951)
_ROUNDING = 1e-12  # accuracy: a sum below this part of its terms' sizes is zero


class _Sized(NamedTuple):
    value: float
    size: float  # what the value would be if nothing cancelled


class _UnknownError(Exception):
    """The expression contains a function that is not evaluated here."""


def is_zero(expr: sympy.Expr) -> bool:
    """Whether sums, products, powers, sines and cosines cancel at points where nothing else would.

    False also where the expression holds other functions: then it is not known.
    """
    symbols = sorted(expr.free_symbols, key=str)
    try:
        for step in _POINTS:
            at = {symbol: 0.5 + math.modf((k + 1) * step)[0] for k, symbol in enumerate(symbols)}
            sized = _number(expr, at)
            if not abs(sized.value) <= _ROUNDING * sized.size:
                return False
    except (_UnknownError, ArithmeticError, ValueError):
        return False
    return True


def _number(expr: sympy.Expr, at: dict[sympy.Symbol, float]) -> _Sized:
    if expr.is_Symbol:
        return _Sized(at[expr], at[expr])
    if expr.is_number:
        number = float(expr)
        return _Sized(number, abs(number))
    parts = [_number(part, at) for part in expr.args]
    if expr.is_Add or expr.is_Mul:
        return _Sized(*map(math.fsum if expr.is_Add else math.prod, zip(*parts, strict=True)))
    if expr.is_Pow:
        base, power = parts
        number = math.pow(base.value, power.value)
        return _Sized(number, max(abs(number), math.pow(base.size, power.value)))
    if expr.func in (sympy.sin, sympy.cos):
        number = math.sin(parts[0].value) if expr.func is sympy.sin else math.cos(parts[0].value)
        return _Sized(number, 1.0)
    raise _UnknownError


Reactions = tuple[tuple[str, str, sympy.Expr], ...]  # (component, unit, value in the multipliers)


@dataclass(frozen=True)
class ConstraintTerms:
    """The terms of one constraint, in placeholders or in coordinates of the model.

    The kernels take the derivatives of Φ from its values (`codegen.lower.differentiation`); those
    here are for reading, and are taken when somebody asks.
    """

    coordinates: tuple[Coordinate, ...]  # the columns of the Jacobian
    phi: tuple[sympy.Expr, ...]  # Φ, one a row
    reactions: Reactions
    multipliers: tuple[Multiplier, ...]  # λ of the rows

    @cached_property
    def jacobian(self) -> tuple[tuple[sympy.Expr, ...], ...]:
        """Φ_q, row by row."""
        return tuple(tuple(derivative(e, q) for q in self.coordinates) for e in self.phi)

    @cached_property
    def nu(self) -> tuple[sympy.Expr, ...]:
        """ν = -Φ_t, one a row."""
        return tuple(-derivative(e, t) for e in self.phi)

    @cached_property
    def gamma(self) -> tuple[sympy.Expr, ...]:
        """γ = -(Φ_q q̇)_q q̇ - 2 Φ_qt q̇ - Φ_tt (Haug 3.6.7, 3.6.10), one a row."""
        rows = zip(self.phi, self.jacobian, strict=True)
        return tuple(_gamma(e, row, self.coordinates) for e, row in rows)


def constraint_terms(element: Constraint) -> tuple[Statement, ConstraintTerms]:
    """The element's statement, and everything that follows from it."""
    statement = statement_of(element)
    return statement, statement_terms(statement)


def statement_terms(statement: Statement) -> ConstraintTerms:
    """Everything that follows from a statement."""
    reaction = statement.reaction
    if isinstance(reaction, JointReaction):  # in matrices that can be the key of a cache
        arm = reaction.on.arm if reaction.arm is None else reaction.arm
        direction, arm = map(sympy.ImmutableMatrix, (reaction.direction, arm))
        reaction = replace(reaction, direction=direction, arm=arm)
    elif isinstance(reaction, WrenchReaction):
        arm = reaction.on.arm if reaction.arm is None else reaction.arm
        reaction = replace(reaction, arm=sympy.ImmutableMatrix(arm))
    return _derive(statement.phi, reaction)


@cache
def _derive(
    phi: tuple[sympy.Expr, ...], reaction: JointReaction | WrenchReaction | ConjugateReaction | None
) -> ConstraintTerms:
    phi = tuple(as_pieces(e, may_switch=False) for e in phi)
    coordinates = tuple(kinds(sympy.Tuple(*phi), Coordinate))
    multipliers = tuple(Multiplier(f"lambda_{k}", real=True) for k in range(len(phi)))
    reactions: Reactions = ()
    if isinstance(reaction, JointReaction):
        reactions = _joint_reaction(phi, multipliers, reaction)
    elif isinstance(reaction, WrenchReaction):
        reactions = wrench(phi, multipliers, reaction)
    elif reaction is not None:
        pairs = zip(reaction.components, multipliers, strict=True)
        reactions = tuple((name, unit, -lam) for (name, unit), lam in pairs)
    return ConstraintTerms(coordinates, phi, reactions, multipliers)


def _gamma(
    phi: sympy.Expr, row: tuple[sympy.Expr, ...], coordinates: tuple[Coordinate, ...]
) -> sympy.Expr:
    """γ of one equation; mixed second derivatives are taken once and doubled."""
    terms = [derivative(derivative(phi, t), t)]
    for k, (entry, p) in enumerate(zip(row, coordinates, strict=True)):
        terms.append(2 * derivative(entry, t) * p.rate)
        terms.append(derivative(entry, p) * p.rate**2)
        terms += [2 * derivative(entry, q) * p.rate * q.rate for q in coordinates[k + 1 :]]
    return sympy.Add(*(-term for term in terms))


def _joint_reaction(
    phi: tuple[sympy.Expr, ...], multipliers: tuple[Multiplier, ...], reaction: JointReaction
) -> Reactions:
    """F = -Φ_rᵀ λ and T = (s'ᵀ Bᵀ Φ_rᵀ - Φ_φᵀ) λ at the joint's point (Haug 6.6.9), in its axes."""
    assert reaction.arm is not None
    (ux, uy), on, (sx, sy) = reaction.direction, reaction.on, reaction.arm
    pairs = tuple(zip(phi, multipliers, strict=True))
    fx, fy, couple = (
        -reaction.sign * sum(derivative(e, c) * lam for e, lam in pairs)
        for c in (on.x, on.y, on.phi)
    )
    torque = couple - (sx * fy - sy * fx)
    torque = sympy.S.Zero if is_zero(torque) else sympy.expand(torque)
    return (
        ("fx", "N", ux * fx + uy * fy),
        ("fy", "N", ux * fy - uy * fx),
        ("torque", "N m", torque),
    )
