"""The drivers of a declaration."""

from typing import Any

from codegen.declare.element import Constraint
from codegen.declare.scene_values import UNITS
from codegen.declare.symbols import Coordinate
from codegen.elements.drivers.motion import Motion
from codegen.model.base import Declarations


class Drivers(Declarations):
    """What prescribes a motion."""

    def driver(self, name: str, driven: Any, law: Any) -> Constraint:
        """A coordinate, or any expression of coordinates, follows `law`, an expression of t."""
        left = self._read.value(driven, "", f"driver '{name}'")
        unit = UNITS[left.name.rpartition("_")[2]] if isinstance(left, Coordinate) else ""
        right = self._read.value(law, unit, f"law of driver '{name}'")
        element = Motion(name, left, right, self._bodies_in(left))
        if self._claim("driver", name):
            self.drivers[name] = element
        return element
