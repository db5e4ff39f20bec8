"""The quantities of a result as curves: series in groups that a panel shows, with units."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.mechanism.series_table import ENERGIES, quantity_of
from runtime.show.animation.curve_panels import MAX_LINES
from runtime.show.animation.payload import Arrays

if TYPE_CHECKING:
    from runtime.results.result import Result

_ROUNDING = 1e-9  # accuracy: of a group's largest value; a curve that changes by less is constant


class Quantity(NamedTuple):
    """A series: what it belongs to, its name, its unit and its values."""

    section: str  # "Bodies", "Joints" …
    owner: str  # body, joint or effect; empty of sums over bodies
    kind: str  # "position", "reaction" …
    name: str
    unit: str
    values: npt.NDArray[np.float64]

    @property
    def group(self) -> str:
        """The title of the panel that shows it."""
        title = f"{self.owner}: {self.kind}" if self.owner else self.kind
        return f"{title}, {self.unit}" if self.unit else title


def quantities(result: "Result") -> Iterator[Quantity]:
    """All series that are finite somewhere, in the order of a report."""
    for quantity in _all(result):
        if np.isfinite(quantity.values).any():
            yield quantity


def _all(result: "Result") -> Iterator[Quantity]:
    description = result.description
    for row in description.positions:
        owner = row.name.rpartition(".")[0]
        parts = (
            ("position", row.name, row.unit, result.q(row.name)),
            ("velocity", row.velocity, row.velocity_unit, result.v(row.name)),
            ("acceleration", f"a({row.name})", row.acceleration_unit, result.a(row.name)),
        )
        for kind, name, unit, values in parts:
            word = _ANGULAR.get((kind, unit.partition("/")[0]), kind)
            yield Quantity("Bodies", owner, word, name, unit, values)
    for state in description.states:
        yield Quantity("States", "", "state", state.name, state.unit or "", result.y(state.name))
    for number, reaction in enumerate(description.reactions):
        section, kind = "Joints", "reaction"
        if reaction.element in description.drivers:
            section, kind = "Drivers", "exerts"
        elif reaction.element in description.effects.names:
            point = reaction.element in description.tracked
            section = "Points" if point else "Effects"
            kind = "path" if point else quantity_of(reaction) or "effect"
        values = result.samples.reaction[:, number]
        yield Quantity(section, reaction.element, kind, reaction.name, reaction.unit, values)
    for name in description.whole_powers:
        yield Quantity("Energy", "", "power", f"power({name})", "W", result.power(name))
    for part in ENERGIES:
        try:
            yield Quantity("Energy", "", "energy", part, "J", result.energy(part))
        except InputError:
            return  # a scene without masses, or whose outputs leave energies out


_ANGULAR = {
    ("position", "rad"): "angle",
    ("velocity", "rad"): "angular velocity",
    ("acceleration", "rad"): "angular acceleration",
}


def curves(result: "Result", arrays: Arrays) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """The series of a result and their groups, as the page has them.

    A group is a panel's worth of curves: those of a body, joint or effect that share a unit, and
    those of one kind of all bodies.
    """
    series: list[dict[str, Any]] = []
    groups: dict[tuple[str, str], dict[str, Any]] = {}
    for quantity in quantities(result):
        number = len(series)
        column = arrays.add(quantity.values, rounded=True)
        series.append({"name": quantity.name, "unit": quantity.unit, "values": column})
        values = quantity.values[np.isfinite(quantity.values)]
        shared = quantity._replace(section="All bodies", owner="", kind=quantity.kind)
        for one in (shared, quantity) if quantity.section == "Bodies" else (quantity,):
            key = (one.section, one.group)
            group = groups.setdefault(
                key, {"section": one.section, "title": one.group, "owner": one.owner,
                      "unit": one.unit, "series": [], "sizes": []},
            )  # fmt: skip
            group["series"].append(number)
            group["sizes"].append((float(np.abs(values).max()), float(np.ptp(values))))
    return series, [part for group in groups.values() for part in _parts(group)]


def _parts(group: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A group without the curves that stay constant, unless all do, in panels."""
    sizes = group.pop("sizes")
    least = _ROUNDING * max(size for size, _ in sizes)
    chosen = [k for k, (_, change) in zip(group["series"], sizes, strict=True) if change > least]
    constant = not chosen
    chosen = chosen or group["series"]
    pieces = range(0, len(chosen), MAX_LINES)
    for first in pieces:
        number = f" ({first // MAX_LINES + 1})" if len(pieces) > 1 else ""
        part = chosen[first : first + MAX_LINES]
        yield {**group, "title": group["title"] + number, "series": part, "constant": constant}
