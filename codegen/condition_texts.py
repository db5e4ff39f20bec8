"""Conditions as texts, ``"body.x > 3"``: a series, a sign and a number, and nothing that is run."""

import re
from typing import NamedTuple

from codegen.plain_values import shown
from codegen.quantities import QuantityError, number_in

FORM = r"\s*(?P<series>[^<>]*[^<>\s])\s*(?P<sign>[<>])\s*(?P<value>[^<>]*[^<>\s])\s*"
_CONDITION = re.compile(FORM)


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
    parts = _CONDITION.fullmatch(text)
    if parts is None:
        raise QuantityError(
            f'{shown(text)} is no condition; write "SERIES > VALUE", or with <, such as '
            '"body.x > 3".'
        )
    return ConditionText(parts["series"], parts["sign"], parts["value"])
