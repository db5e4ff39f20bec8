"""The parameters of a run: defaults, and what the user gives over them, checked all at once."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.mechanism.description import Description, unknown
from runtime.validation.arguments import number


def resolved(
    told: Description, overrides: Mapping[str, Any]
) -> tuple[npt.NDArray[np.float64], list[str]]:
    """Values of parameters, with room behind them for derived constants, and all complaints."""
    table = told.parameters
    values = np.zeros(len(table) + len(told.constants))
    values[: len(table)] = [row.default for row in table]
    problems = []
    for name, given in overrides.items():
        if name in told.unused:
            problems.append(
                f"{told.title}: nothing that takes part depends on parameter "
                f"{name}. Leave it out of the parameters, or take what needs it into the scene "
                f"(left out: {', '.join(told.left_out.names) or 'nothing'})."
            )
            continue
        if name not in table.names:
            problems.append(f"{told.title}: {unknown('parameter', name, table.names)}")
            continue
        row = table[name]
        value = number(given)
        if value is None or not math.isfinite(value):
            problems.append(f"Parameter {name} is {given!r}; it must be a finite number.")
        elif row.sign == "positive" and value <= 0.0:
            problems.append(
                f"Parameter {name} is {value:g} {row.unit}; it must be greater than zero."
            )
        elif row.sign == "nonnegative" and value < 0.0:
            problems.append(f"Parameter {name} is {value:g} {row.unit}; it must not be negative.")
        else:
            values[table.index(name)] = value
    return values, problems
