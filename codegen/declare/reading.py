"""Values as a modeller writes them → SymPy expressions in SI units; what is wrong is noted."""

from typing import Any

import sympy

from codegen.declare.quantities import expression, in_unit


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
        """A number, quantity or expression, as an expression in `unit`; None stays None."""
        if value is None:
            return None
        try:
            return expression(in_unit(value, unit, where, self.problems))
        except (TypeError, sympy.SympifyError):
            self.problems.append(f"{where}: {value!r} is neither a number nor an expression.")
            return sympy.S.Zero

    def gated(self, value: Any, unit: str, where: str, when: Any) -> Any:
        """A value while the condition `when` holds, else zero."""
        force = self.value(value, unit, where)
        condition = sympy.sympify(when)
        if condition == sympy.true or force == 0:
            return force
        return sympy.Piecewise((force, condition), (0, True))

    def number(self, value: Any, unit: str, where: str) -> float:
        """A plain number in `unit`."""
        try:
            return float(in_unit(value, unit, where, self.problems))
        except (TypeError, ValueError):
            self.problems.append(f"{where}: {value!r} is not a number.")
            return 1.0
