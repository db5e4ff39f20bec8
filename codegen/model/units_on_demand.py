"""Units of what a scene gives values: those of bodies, and others where they are asked for.

Whether a joint has coordinates of its own is known once it has stated its equations. A scene that
names coordinates of bodies alone asks no joint.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property

from codegen.declare.symbols import Coordinate, dotted


def units_of(coordinates: Iterable[Coordinate]) -> dict[str, str]:
    """Name of a coordinate or velocity → its SI unit."""
    units: dict[str, str] = {}
    for q in coordinates:
        units[dotted(q)] = q.unit
        units[dotted(q.rate)] = q.measure.rate_unit
    return units


class UnitsOnDemand(Mapping[str, str]):
    """Units by name; the `others` are found when a name is none of the `first`."""

    def __init__(self, first: Mapping[str, str], others: Callable[[], Mapping[str, str]]) -> None:
        self._first, self._find_others = first, others

    @cached_property
    def _all(self) -> dict[str, str]:
        return {**self._first, **self._find_others()}

    def __getitem__(self, name: str) -> str:
        return self._first[name] if name in self._first else self._all[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)
