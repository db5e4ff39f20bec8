"""Parameter values of a run: the defaults, and the user's over them, checked all at once."""

import math

import numpy as np
import numpy.typing as npt

from codegen.argument_readers import real, shortened
from codegen.errors import ParameterError
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism, Values
from runtime.mechanism.module_tables import unknown
from runtime.validation.arguments import check
from runtime.validation.requirements_of_contact_and_stiction import require_sound


def parameter_values(
    mechanism: Mechanism, overrides: Values | None = None
) -> npt.NDArray[np.float64]:
    """Parameters and the constants derived from them, (np,); see `Machine.parameter_values`."""
    check(mechanism, parameters=overrides)
    description = mechanism.description
    table = description.parameters
    values = np.zeros(len(table) + len(description.constants))
    values[: len(table)] = [row.default for row in table]
    problems = []
    for name, value in (overrides or {}).items():
        if name in description.unused:
            problems.append(
                f"{description.title}: nothing that takes part depends on parameter "
                f"{name}. Leave it out of the parameters, or take what needs it into the scene "
                f"(left out: {', '.join(description.left_out.names) or 'nothing'})."
            )
            continue
        if name not in table.names:
            problems.append(f"{description.title}: {unknown('parameter', name, table.names)}")
            continue
        row = table[name]
        finite = real(value)
        if finite is None or not math.isfinite(finite):
            problems.append(f"Parameter {name} is {shortened(value)}; it must be a finite number.")
        elif row.sign == "positive" and finite <= 0.0:
            problems.append(
                f"Parameter {name} is {finite:g} {row.unit}; it must be greater than zero."
            )
        elif row.sign == "nonnegative" and finite < 0.0:
            problems.append(f"Parameter {name} is {finite:g} {row.unit}; it must not be negative.")
        else:
            values[table.index(name)] = finite
    if problems:
        raise ParameterError(problems)
    mechanism.kernels.constants(values)
    require_sound(mechanism, values)
    return values
