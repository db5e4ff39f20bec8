"""Values of a case in the units of its machine, and the names that the machine has."""

from collections.abc import Callable, Mapping
from typing import Any

from codegen.readers.quantities import ConditionText, UnitError, number_in
from runtime.cases.document import Place
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown

Note = Callable[[Place, str], None]
"""Takes a problem: the place of the value in the case, and a sentence."""


def values_of(
    description: Description, given: Mapping[str, Mapping[str, Any]], note: Note
) -> dict[str, dict[str, float]]:
    """Parameters, start values and guesses as numbers; what does not fit is noted.

    Texts with units become numbers: of parameters in their declared units, else in SI units.
    """
    parameters = {row.name: row.unit for row in description.parameters}
    states = {row.name: row.unit for row in description.coordinates}
    states |= {row.velocity: row.velocity_unit for row in description.coordinates}
    found = dict[str, dict[str, float]]()
    for word, values in given.items():
        units = parameters if word == "parameters" else states
        what = "parameter" if word == "parameters" else "coordinate, velocity or state"
        known = units if word == "parameters" else dict.fromkeys(description.variables, "")
        numbers = found.setdefault(word, {})
        for name, value in values.items():
            if name not in units and not (word == "parameters" and name in description.unused):
                note((word, name), unknown(what, name, known))
                continue
            try:
                unit = units.get(name, "")
                numbers[name] = number_in(value, unit) if isinstance(value, str) else float(value)
            except UnitError as error:
                note((word, name), str(error))
    return found


def conditions_of(
    description: Description, texts: Mapping[str, ConditionText], note: Note
) -> dict[str, tuple[str, str, float]]:
    """Conditions on series, as `Machine.simulate` takes them; their numbers are in SI units."""
    found = {}
    for name, condition in texts.items():
        try:
            value = condition.number(_unit_of(description, condition.series))
            found[name] = condition.series, condition.sign, value
        except UnitError as error:
            note(("run", "until", name), str(error))
    return found


def _unit_of(description: Description, series: str) -> str:
    """The unit of a coordinate, velocity or reaction; empty for all others."""
    for row in description.coordinates:
        if series in (row.name, row.velocity):
            return row.unit if series == row.name else row.velocity_unit
    return next((row.unit for row in description.reactions if row.name == series), "")
