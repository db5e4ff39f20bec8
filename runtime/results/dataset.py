"""A result as an xarray.Dataset: its variables, each some columns of its samples, with labels."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.mechanism.series_table import Series
from runtime.results.result import Result

if TYPE_CHECKING:
    import xarray as xr


class Variable(NamedTuple):
    """A variable over time, and perhaps more: columns of an array of a result."""

    name: str
    dims: tuple[str, ...]
    array: str  # field of `Samples`, or "works"; to energies their sum is added
    columns: npt.NDArray[np.int64]  # over all dimensions but the time; -1: not a number
    about: dict[str, str]

    def values(self, result: Result) -> npt.NDArray[Any]:
        """Its values in a result of the scene, as a copy."""
        works, samples = [*result.works.values()], result.samples
        array = np.column_stack(works) if self.array == "works" else getattr(samples, self.array)
        if self.array == "energy":
            array = np.column_stack([array, array.sum(axis=1)])
        found: npt.NDArray[Any] = np.take(array, self.columns, axis=1, mode="wrap")
        if (self.columns < 0).any():
            found[:, self.columns < 0] = np.nan
        return found


class Labels(NamedTuple):
    """The variables of a result, and its coordinates but for the time."""

    variables: list[Variable]
    coords: dict[str, Any]

    def add(
        self, name: str, over: str, array: str, columns: npt.ArrayLike, units: Iterable[str] = (),
        long_name: str = "",
    ) -> None:  # fmt: skip
        """Add a variable over the time and the dimensions `over`, with the unit that all share."""
        shared, about = {*units}, {"long_name": long_name} if long_name else {}
        if len(shared) == 1:
            about["units"] = shared.pop()
        places = np.asarray(columns, np.int64)
        self.variables.append(Variable(name, ("time", *over.split()), array, places, about))

    def label(self, dimension: str, texts: Iterable[str], **of_each: Iterable[str]) -> None:
        """Add the labels along a dimension, and other texts of each of them."""
        # of type text also where there are none
        self.coords[dimension] = np.array([*texts], dtype=np.str_)
        for name, values in of_each.items():
            self.coords[name] = dimension, np.array([*values], dtype=np.str_)


def dataset(result: Result) -> "xr.Dataset":
    """Label the arrays of a result; reactions that a joint does not have are not a number."""
    import xarray as xr

    labels = labels_of(result)
    data = {row.name: (row.dims, row.values(result), row.about) for row in labels.variables}
    time = {"time": ("time", result.samples.t, {"units": "s"})}
    return xr.Dataset(data, coords=time | labels.coords, attrs=result.about())


def labels_of(result: Result) -> Labels:
    """The variables and coordinates of all results of the scene that have the same works."""
    description, labels = result.description, Labels([], {})
    series, places = description.series, description.positions
    labels.label(
        "coordinate", (row.name for row in places),
        velocity=(row.velocity for row in places), unit=(row.unit for row in places),
        velocity_unit=(row.velocity_unit for row in places),
        acceleration_unit=(row.acceleration_unit for row in places),
    )  # fmt: skip

    def add(name: str, over: str, kind: str, long_name: str = "") -> list[Series]:
        """Add the series of a kind, whose labels are those of a dimension."""
        rows = series.of_kind(kind)
        array = rows[0].array if rows else name
        columns = [row.column for row in rows]
        labels.add(name, over, array, columns, [row.unit for row in rows], long_name)
        return rows

    add("q", "coordinate", "coordinate", "coordinates")
    add("v", "coordinate", "velocity", "velocities")
    add("a", "coordinate", "acceleration", "accelerations")
    labels.add("constraint_residual", "", "residual", 0, (), "largest |Phi|, m or rad")
    largest = "largest |Phi_q v - nu|, m/s or rad/s"
    labels.add("velocity_residual", "", "residual", 1, (), largest)
    if description.states:
        rows = add("y", "state", "state", "first-order states and sampled values")
        units = [row.unit for row in rows]
        labels.label("state", description.states.names, state_unit=units)
    if description.has_masses:
        rows = series.of_kind("power")
        labels.label("source", (row.name for row in rows))
        labels.add("power", "source", "power", [row.column for row in rows], ["W"])
        over, what = "nonconservative_source", "power of the forces without a potential"
        if series.of_kind("nonconservative power"):
            rows = add("nonconservative_power", over, "nonconservative power", what)
            labels.label(over, (row.name for row in rows))
        if rows := series.of_kind("energy"):
            labels.label("part", (row.name for row in rows))
            labels.add("energy", "part", "energy", [0, 1, 2], ["J"])
        _add_reactions(labels, series.of_kind("reaction"))
    _add_effects(labels, series.of_kind("effect"))
    if result.works:
        labels.label("worker", result.works)
        labels.add("work", "worker", "works", range(len(result.works)), ["J"])
    if points := description.tracked:
        labels.label("place", points)
        labels.label("axis", "xy")
        for name, axes, unit in (
            ("point", ("x", "y"), "m"),
            ("point_velocity", ("vx", "vy"), "m/s"),
        ):
            columns = [[series.call("point", of, axis).column for axis in axes] for of in points]
            labels.add(name, "place axis", "reaction", columns, [unit])
    if switches := description.switches:
        kinds = (row.kind for row in switches)
        labels.label("switch", (row.title for row in switches), switch_kind=kinds)
        every, holds = (
            range(len(switches)),
            "1: condition holds, 0: not, 2: its function stays at zero",
        )
        labels.add("mode", "switch", "modes", every, (), holds)
        share = "share of the force of mode 1 where mode is 2"
        labels.add("share", "switch", "share", every, ["1"], share)
    return labels


def _add_reactions(labels: Labels, rows: Sequence[Series]) -> None:
    """The reactions over joint and component."""
    columns = {(row.element, row.component): row.column for row in rows}
    joints = dict.fromkeys(row.element for row in rows)
    units = {row.component: row.unit for row in rows}
    labels.label("joint", joints)
    labels.label("component", units, component_unit=units.values())
    table = np.array([[columns.get((joint, one), -1) for one in units] for joint in joints])
    about = "first body on second, in joint axes, in component_unit"
    labels.add(
        "reaction", "joint component", "reaction", table.reshape(len(joints), len(units)), (), about
    )


def _add_effects(labels: Labels, rows: Sequence[Series]) -> None:
    """A variable for each quantity of effects, over time and effect; not a number of others."""
    found: dict[str, dict[str, Series]] = {}  # quantity → label → series
    for row in rows:
        label = f"{row.element}.{row.component}" if row.component else row.element
        found.setdefault(row.quantity or "component", {})[label] = row
    names = dict.fromkeys(name for parts in found.values() for name in parts)
    if names:
        labels.label("effect", names)
    for quantity, parts in found.items():
        units = {name: row.unit for name, row in parts.items()}
        columns = [parts[name].column if name in parts else -1 for name in names]
        labels.add(quantity, "effect", "reaction", columns, units.values())
        if len({*units.values()}) > 1:
            of_each = {f"{quantity}_unit": [units.get(name, "") for name in names]}
            labels.label("effect", names, **of_each)
