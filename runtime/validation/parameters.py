"""Parameter values of a run: the defaults, and the user's over them, checked all at once.

Masses and inertias that they make impossible are refused, with the parameters behind them.
"""

import numpy as np
import numpy.typing as npt

from codegen.errors import ParameterError
from codegen.parameter_conditions import ALPHAS, shape_problems, violated_conditions
from codegen.readers.values import finite_float, shown
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.mechanism.table_rows import unknown
from runtime.validation.arguments import check


def parameter_values(
    mechanism: Mechanism, overrides: Values | None = None
) -> npt.NDArray[np.float64]:
    """Parameters and the constants derived from them, (np,); see `Machine.parameter_values`."""
    check(mechanism, parameters=overrides)
    description = mechanism.description
    table = description.parameters
    values = np.zeros(description.parameter_slots)
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
        finite = finite_float(value)
        if finite is None:
            unit = row.unit and f" in {row.unit}"
            problems.append(
                f"Parameter {name} is {shown(value)}; it must be a finite number{unit}."
            )
            continue
        if row.sign == "positive" and finite <= 0.0:
            problems.append(
                f"Parameter {name} is {finite:g} {row.unit}; it must be greater than zero."
            )
        elif row.sign == "nonnegative" and finite < 0.0:
            problems.append(f"Parameter {name} is {finite:g} {row.unit}; it must not be negative.")
        values[table.index(name)] = finite
    mechanism.kernels.constants(values)
    if (values[: len(table)] != [row.default for row in table]).any():
        problems += _broken(mechanism, values)  # the build judged the defaults
    if problems:
        raise ParameterError(problems)
    return values


def _broken(mechanism: Mechanism, p: npt.NDArray[np.float64]) -> list[str]:
    """What the elements ask of the parameters p, and these do not meet."""
    description, kernels = mechanism.description, mechanism.kernels
    numbers = np.zeros(sum(row.shown for row in description.conditions))
    kernels.conditions(p, numbers)
    problems = [*violated_conditions(description.conditions, numbers)]
    if description.profiles:
        points = np.zeros((len(ALPHAS), 6 * len(description.profiles)))
        for at, row in zip(ALPHAS, points, strict=True):
            kernels.profiles(at, p, row)
        for k, curve in enumerate(description.profiles):
            found = shape_problems(points[:, 6 * k : 6 * k + 6], curve.convex)
            problems += [f"{curve.element}: {problem}" for problem in found]
    return [f"{description.title}: {problem}" for problem in problems]


def require_masses(mechanism: Mechanism, p: FloatArray) -> None:
    """Refuse masses and inertias that are not positive finite numbers."""
    description = mechanism.description
    values = Equations(mechanism, p).masses(description.neutral)
    problems: dict[tuple[str, str], str] = {}
    for index in np.flatnonzero(~((values > 0.0) & (values < np.inf))).tolist():
        row = description.coordinates[index]
        body = row.name.rpartition(".")[0]
        quantity, unit = ("mass", "kg") if row.is_length else ("inertia", "kg m^2")
        if body in description.bodies:  # a coordinate of no body has no mass to refuse
            problems.setdefault(
                (body, quantity),
                f"{description.title}: the {quantity} of {body} is {values[index]:g} {unit}; "
                f"it must be a positive finite number. {_given(mechanism, p)}",
            )
    if problems:
        raise ParameterError(problems.values())


def _given(mechanism: Mechanism, p: FloatArray) -> str:
    """The parameters that are not those of the build, with which all masses are positive."""
    rows = zip(mechanism.description.parameters, p, strict=False)
    given = [f"{row.name} = {value:g} {row.unit}" for row, value in rows if value != row.default]
    return f"Given are {', '.join(map(str.rstrip, given))}: give other values."
