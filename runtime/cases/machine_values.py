"""Values of a case in the units of its machine, and the names that the machine has."""

from collections.abc import Callable, Mapping
from typing import Any

from codegen.readers.quantities import QuantityError, number_in, read_condition
from runtime.integrate.simulation_options import OPTIONS
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown

Note = Callable[[str, str], None]
"""Takes a problem: path of the value in the case, and a sentence."""


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
                note(f"{word}.{name}", unknown(what, name, known))
                continue
            try:
                unit = units.get(name, "")
                numbers[name] = number_in(value, unit) if isinstance(value, str) else float(value)
            except QuantityError as error:
                note(f"{word}.{name}", str(error))
    return found


def arguments_of(description: Description, run: Mapping[str, Any], note: Note) -> dict[str, Any]:
    """The words of an analysis; seconds are numbers, conditions as `Machine.simulate` has them."""
    words = dict[str, Any]()
    for name, value in run.items():
        if name == "until":
            words[name] = _conditions(description, value, note)
        elif isinstance(value, list) and name == "t_eval":
            words[name] = [seconds(instant) for instant in value]
        elif name in SECONDS_WORDS:
            words[name] = seconds(value)
        else:
            words[name] = value
    return words


SECONDS_WORDS = {"t", *(option.name for option in OPTIONS if option.kind == "seconds")}
"""Words that are times, s."""


def seconds(value: float | str) -> float:
    """A time in s, which was checked when the case was read."""
    return number_in(value, "s") if isinstance(value, str) else float(value)


def _conditions(
    description: Description, texts: Mapping[str, str], note: Note
) -> dict[str, tuple[str, str, float]]:
    """Conditions on series, as `Machine.simulate` takes them; their numbers are in SI units."""
    found = {}
    for name, text in texts.items():
        condition = read_condition(text)
        try:
            value = number_in(condition.value, _unit_of(description, condition.series))
            found[name] = condition.series, condition.sign, value
        except QuantityError as error:
            note(f"run.until.{name}", str(error))
    return found


def _unit_of(description: Description, series: str) -> str:
    """The unit of a coordinate, velocity or reaction; empty for all others."""
    for row in description.coordinates:
        if series in (row.name, row.velocity):
            return row.unit if series == row.name else row.velocity_unit
    return next((row.unit for row in description.reactions if row.name == series), "")
