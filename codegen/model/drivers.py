"""The drivers of a declaration, which prescribe motions.

Each takes its name, the driven quantity, and its law: an expression of the time t and of
parameters. Positions are in m and angles in rad; differences and distances go from `i` to `j`.
"""

from typing import Any

from codegen.declare.element import Constraint
from codegen.declare.symbols import KINDS, LETTERS, Coordinate, Letter
from codegen.elements.drivers.absolute import PointDriver
from codegen.elements.drivers.distance import DistanceDriver
from codegen.elements.drivers.relative import RelativeDriver
from codegen.elements.drivers.translation import TranslationDriver
from codegen.elements.drivers.user_expression import Motion
from codegen.model.base import Declarations, Pair, Place


class Drivers(Declarations):
    """The drivers of a declaration."""

    def driver(self, name: str, driven: Any, law: Any) -> Constraint:
        """A coordinate, or any expression of coordinates, follows `law`, an expression of t."""
        left = self._value(driven, "", f"driver '{name}'")
        unit = left.unit if isinstance(left, Coordinate) else ""
        right = self._law(name, law, unit)
        return self._declare(Motion(name, left, right, self._bodies_in(left)))

    def point_driver(self, name: str, on: Place, letter: Letter, law: Any) -> Constraint:
        """A point's global x or y, or its body's φ, follows `law`."""
        letter = self._read.choice(letter, LETTERS, f"driver '{name}'")
        right = self._law(name, law, KINDS[letter].unit)
        return self._declare(PointDriver(name, self._point(name, on), letter, right))

    def relative_driver(
        self, name: str, i: Place, j: Place, letter: Letter, law: Any
    ) -> Constraint:
        """Global x or y of point `j`, or φ of its body, minus that of `i` follows `law`."""
        letter = self._read.choice(letter, LETTERS, f"driver '{name}'")
        right = self._law(name, law, KINDS[letter].unit)
        return self._declare(RelativeDriver(name, *self._pair(name, i, j), letter, right))

    def rotation_driver(self, name: str, i: Place, j: Place, law: Any) -> Constraint:
        """φ_j - φ_i follows `law`: the motor in a revolute joint between two bodies."""
        return self.relative_driver(name, i, j, "phi", law)

    def translation_driver(
        self, name: str, i: Place, j: Place, law: Any, axis: Pair = (1, 0)
    ) -> Constraint:
        """How far `j` is ahead of `i` along `axis` of body `i` follows `law`: a driven slider."""
        line = self._read.axis(axis, name)
        right = self._law(name, law, "m")
        return self._declare(TranslationDriver(name, *self._pair(name, i, j), line, right))

    def distance_driver(self, name: str, i: Place, j: Place, law: Any) -> Constraint:
        """The distance of two points follows `law`, which stays positive: a cylinder."""
        right = self._law(name, law, "m")
        return self._declare(DistanceDriver(name, *self._pair(name, i, j), right))

    def _law(self, name: str, law: Any, unit: str) -> Any:
        return self._value(law, unit, f"law of driver '{name}'")
