"""Masses and inertias that parameter values make impossible, and the parameters behind them."""

from itertools import product

import numpy as np

from codegen.errors import ParameterError
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.validation.parameters import parameter_values


def require_masses(mechanism: Mechanism, p: FloatArray) -> None:
    """Refuse masses and inertias that are not positive finite numbers."""
    description = mechanism.description
    values = _masses(mechanism, p)
    impossible: dict[tuple[str, bool], int] = {}
    for index in np.flatnonzero(~((values > 0.0) & (values < np.inf))).tolist():
        row = description.coordinates[index]
        impossible.setdefault((row.name.rpartition(".")[0], row.is_length), index)
    problems = []
    for body, is_length in product(description.bodies, (True, False)):
        if (body, is_length) in impossible:  # a coordinate of no body has no mass to refuse
            index = impossible[body, is_length]
            quantity, unit = ("mass", "kg") if is_length else ("inertia", "kg m^2")
            problems.append(
                f"{description.title}: the {quantity} of {body} is {values[index]:g} {unit}; "
                f"it must be a positive finite number. {_behind(mechanism, p, index)}"
            )
    if problems:
        raise ParameterError(problems)


def _masses(mechanism: Mechanism, p: FloatArray) -> FloatArray:
    """Diagonal of M in the neutral pose, shape (n,)."""
    return Equations(mechanism, p).masses(mechanism.description.neutral)


def _behind(mechanism: Mechanism, p: FloatArray, place: int) -> str:
    """The parameters on which a mass depends, determined by changing one at a time."""
    table = mechanism.description.parameters
    defaults = parameter_values(mechanism)
    names = []
    for index, row in enumerate(table):
        changed = defaults.copy()
        changed[index] = 1.25 * changed[index] or 1.0
        mechanism.kernels.constants(changed)
        if _masses(mechanism, changed)[place] != _masses(mechanism, defaults)[place]:
            names.append(f"{row.name} = {p[index]:g} {row.unit}".rstrip())
    if not names:
        return "It depends on no parameter: correct the model."
    return f"It follows from {', '.join(names)}: give other values."
