"""Places and speeds of a machine, sorted by what its scene fixes: arguments of an analysis."""

from collections.abc import Mapping

from runtime import Machine


def start_and_guess(machine: Machine, values: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """What the scene fixes as `start`, the others as `guess`."""
    fixed = {row.name for row in machine.description.start if row.role == "fixed"}
    return {
        "start": {name: value for name, value in values.items() if name in fixed},
        "guess": {name: value for name, value in values.items() if name not in fixed},
    }
