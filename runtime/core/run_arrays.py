"""The arrays of a run, taken out of its table.

An array is seven arguments to compiled code. What is called often takes the table alone, and its
arrays from here.
"""

from runtime.core.array_views import floats_at, integers_at
from runtime.core.function_table import (
    CONSTRAINT_COUNT,
    COORDINATES,
    MODES,
    MULTIPLIERS,
    PARAMETER_COUNT,
    PARAMETERS,
    SURFACES,
    SWITCHES,
    WORKSPACE,
)
from runtime.core.jit import fetched
from runtime.core.signatures import Integers, Vector
from runtime.core.workspace import ROWS, SWITCH_ROWS


@fetched
def workspace(machine: Integers) -> Vector:
    """States and derivatives, `w`."""
    found: Vector = floats_at(machine, WORKSPACE, ROWS * 2 * machine[COORDINATES])
    return found


@fetched
def surfaces(machine: Integers) -> Vector:
    """Values of switching functions, `sw`."""
    found: Vector = floats_at(machine, SURFACES, SWITCH_ROWS * machine[SWITCHES])
    return found


@fetched
def parameters(machine: Integers) -> Vector:
    """Parameters and derived constants, `p`."""
    found: Vector = floats_at(machine, PARAMETERS, machine[PARAMETER_COUNT])
    return found


@fetched
def mode_numbers(machine: Integers) -> Integers:
    """The mode of every switching function, `modes`."""
    found: Integers = integers_at(machine, MODES, machine[SWITCHES])
    return found


@fetched
def multipliers(machine: Integers) -> Vector:
    """Lagrange multipliers, `lam`."""
    found: Vector = floats_at(machine, MULTIPLIERS, machine[CONSTRAINT_COUNT])
    return found
