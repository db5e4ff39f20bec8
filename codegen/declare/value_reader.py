"""Values of a declaration → SymPy expressions in SI units; problems are collected."""

import math
from typing import Any

import sympy
from sympy.core.relational import Relational

from codegen.declare.units import expression, in_unit


class Reader:
    """Reads values, and notes a sentence about each that cannot be read.

    Attributes
    ----------
    problems
        The sentences, in order.
    """

    def __init__(self) -> None:
        self.problems: list[str] = []

    def value(self, value: Any, unit: str, where: str) -> Any:
        """A number, quantity or expression, as an expression in `unit`."""
        if value is None:
            self.problems.append(f"{where} is missing; give it{f' in {unit}' if unit else ''}.")
            return sympy.S.One  # stands in, so that nothing else is said of it
        try:
            return expression(in_unit(value, unit, where, self.problems))
        except (TypeError, sympy.SympifyError):
            self.problems.append(f"{where}: {value!r} is neither a number nor an expression.")
            return sympy.S.Zero

    def pair(
        self, value: Any, unit: str, where: str, like: str = "two values, (1, 0)"
    ) -> tuple[Any, Any]:
        """Two values; anything else is noted as a problem and read as (1, 0)."""
        try:
            first, second = value
        except (TypeError, ValueError):
            self.problems.append(f"{where}: {value!r} is no pair; write {like}.")
            first, second = 1, 0
        return self.value(first, unit, where), self.value(second, unit, where)

    def gated(self, value: Any, unit: str, where: str, when: Any) -> Any:
        """A value while the condition `when` holds, else zero; None holds always."""
        force = self.value(value, unit, where)
        if when is None:
            return force
        if not isinstance(when, Relational | sympy.And | sympy.Or | sympy.Not):
            reason = "never changes" if str(when) in ("True", "False") else "is no condition"
            self.problems.append(
                f"{where}: when={when!r} {reason}; compare coordinates, velocities, parameters or "
                "t by <, <=, > or >=, joined by And, Or and Not, or leave it out."
            )
            return force
        return sympy.S.Zero if force == 0 else sympy.Piecewise((force, when), (0, True))

    def number(self, value: Any, unit: str, where: str) -> float:
        """A plain number in `unit`."""
        try:
            return float(in_unit(value, unit, where, self.problems))
        except (TypeError, ValueError, OverflowError):
            self.problems.append(f"{where}: {value!r} is not a number.")
            return 1.0

    def finite(self, value: Any, unit: str, where: str) -> float:
        """A plain number that is neither infinite nor undefined."""
        number = self.number(value, unit, where)
        if math.isfinite(number):
            return number
        self.problems.append(f"{where}: the value is {number}; give a finite number.")
        return 0.0

    def choice(self, value: Any, allowed: tuple[str, ...], where: str) -> Any:
        """One of a few words."""
        if value in allowed:
            return value
        words = ", ".join(map(repr, allowed))
        self.problems.append(f"{where}: {value!r} is none of {words}.")
        return allowed[0]
