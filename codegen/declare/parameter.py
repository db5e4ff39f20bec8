"""Parameters: numbers that runs may change without a new build."""

import math
from dataclasses import dataclass
from typing import Literal

SignRule = Literal["", "positive", "nonnegative"]


@dataclass(frozen=True)
class ParameterDeclaration:
    """A parameter's name, default value, unit label, and the rule that its values obey."""

    name: str
    value: float
    unit: str
    sign: SignRule

    def problem(self, value: float) -> str | None:
        """Why `value` is not allowed, or None."""
        if not math.isfinite(value):
            return f"parameter '{self.name}' is {value}; give a finite number."
        if (self.sign == "positive" and value <= 0) or (self.sign == "nonnegative" and value < 0):
            return f"parameter '{self.name}' is {value:g} {self.unit}, but must be {self.sign}."
        return None
