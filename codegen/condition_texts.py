"""Conditions as texts, ``"body.x > 3"``: a series, a sign and a number, and nothing that is run."""

from typing import NamedTuple

from codegen.plain_values import shown
from codegen.quantities import QuantityError, number_in

FORM = r"^\s*[^<>\s][^<>]*[<>]\s*[^<>\s][^<>]*$"
"""The form of a condition for schemas; no two ways of it fit one text, so it is read in one go."""


class ConditionText(NamedTuple):
    """A condition that holds where a series is on one side of a number."""

    series: str
    sign: str  # "<" or ">"
    value: str  # a number, perhaps with its unit

    def number(self, unit: str) -> float:
        """The number in the unit of the series; `QuantityError` where its own does not fit."""
        return number_in(self.value, unit)


def read_condition(text: str) -> ConditionText:
    """The parts of a condition; `QuantityError` where it has none."""
    sign = "<" if "<" in text else ">"
    series, *values = (part.strip() for part in text.split(sign))
    if len(values) != 1 or not series or not values[0] or ("<" in text and ">" in text):
        raise QuantityError(
            f'{shown(text)} is no condition; write "SERIES > VALUE", or with <, such as '
            '"body.x > 3".'
        )
    return ConditionText(series, sign, values[0])
