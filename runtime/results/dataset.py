"""A result as an xarray.Dataset: its variables, each computed from the samples, with labels."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.mechanism.series_table import Series
from runtime.results.result import Result

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]


class Variable(NamedTuple):
    """A variable over time, and perhaps more, and how it follows from the samples of a result."""

    name: str
    dims: tuple[str, ...]
    values: Callable[[Result], npt.NDArray[Any]]
    about: dict[str, str]


class Labels(NamedTuple):
    """The variables of a result, and its coordinates but for the time."""

    variables: list[Variable]
    coords: dict[str, Any]

    def add(
        self, name: str, dims: str, values: Callable[[Result], npt.NDArray[Any]],
        about: dict[str, str],
    ) -> None:  # fmt: skip
        """Add a variable over `dims`, words."""
        self.variables.append(Variable(name, tuple(dims.split()), values, about))


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
    _add_motion(labels, result)
    if description.has_masses:
        whole = description.whole_powers
        labels.coords["source"] = _texts(whole)
        of_whole = [*whole.values()]
        labels.add(
            "power", "time source", lambda r: _columns(r.samples.power, of_whole), {"units": "W"}
        )
        parts = [k for k, row in enumerate(description.powers) if row.kind == "nonconservative"]
        if parts:
            source = "nonconservative_source"
            labels.coords[source] = _texts(description.powers[k].name for k in parts)
            about = {"units": "W", "long_name": "power of the forces without a potential"}
            labels.add(
                "nonconservative_power", f"time {source}",
                lambda r: _columns(r.samples.power, parts), about,
            )  # fmt: skip
        if not description.leaves_out("energy"):
            labels.coords["part"] = ["kinetic", "potential", "total"]
            labels.add("energy", "time part", _energies, {"units": "J"})
        _add_reactions(labels, result)
    _add_effects(labels, result)
    if result.works:
        labels.coords["worker"] = _texts(result.works)
        labels.add(
            "work", "time worker", lambda r: np.column_stack([*r.works.values()]), {"units": "J"}
        )
    if description.tracked:
        labels.coords["place"], labels.coords["axis"] = _texts(description.tracked), ["x", "y"]
        for variable, axes, unit in (("point", "x y", "m"), ("point_velocity", "vx vy", "m/s")):
            points = _points(description.tracked, axes.split())
            labels.add(variable, "time place axis", points, {"units": unit})
    if switches := description.switches:
        labels.coords["switch"] = _texts(row.title for row in switches)
        labels.coords["switch_kind"] = "switch", _texts(row.kind for row in switches)
        mode = {"long_name": "1: condition holds, 0: not, 2: its function stays at zero"}
        share = {"units": "1", "long_name": "share of the force of mode 1 where mode is 2"}
        labels.add("mode", "time switch", lambda r: r.samples.modes, mode)
        labels.add("share", "time switch", lambda r: r.samples.share, share)
    return labels


def _energies(result: Result) -> FloatArray:
    energy = result.samples.energy
    return np.column_stack([energy, energy.sum(axis=1)])


def _points(names: Iterable[str], axes: list[str]) -> Callable[[Result], FloatArray]:
    def points(result: Result) -> FloatArray:
        places = [[result.point(name, axis) for axis in axes] for name in names]
        return np.moveaxis(np.array(places), 2, 0)

    return points


def _columns(array: FloatArray, columns: list[int]) -> FloatArray:
    """Columns of an array, (k, w), as a copy; not a number where there is none, -1."""
    if columns == [*range(array.shape[1])]:
        return array.copy()
    if not array.shape[1]:
        return np.full((len(array), len(columns)), np.nan)
    found = np.take(array, columns, axis=1, mode="wrap")
    found[:, [place for place, column in enumerate(columns) if column < 0]] = np.nan
    return found


def _texts(values: Iterable[str]) -> npt.NDArray[np.str_]:
    """Labels, of type text also where there are none."""
    return np.array(list(values), dtype=np.str_)


def _add_motion(labels: Labels, result: Result) -> None:
    """Coordinates, velocities, accelerations and residuals."""
    description, over = result.description, "time coordinate"
    table = description.positions
    columns = [k for k, row in enumerate(description.coordinates) if not row.is_state]

    def about(name: str, unit: str) -> dict[str, str]:
        units = {getattr(row, unit) for row in table}
        return {"long_name": name} | ({"units": units.pop()} if len(units) == 1 else {})

    positions = {"long_name": "largest |Phi|, m or rad"}
    velocities = {"long_name": "largest |Phi_q v - nu|, m/s or rad/s"}
    of_q = about("coordinates", "unit")
    of_v, of_a = about("velocities", "velocity_unit"), about("accelerations", "acceleration_unit")
    labels.add("q", over, lambda r: _columns(r.samples.q, columns), of_q)
    labels.add("v", over, lambda r: _columns(r.samples.v, columns), of_v)
    labels.add("a", over, lambda r: _columns(r.samples.a, columns), of_a)
    labels.add("constraint_residual", "time", lambda r: r.samples.residual[:, 0], positions)
    labels.add("velocity_residual", "time", lambda r: r.samples.residual[:, 1], velocities)
    labels.coords.update(
        {
            "coordinate": [row.name for row in table],
            "velocity": ("coordinate", [row.velocity for row in table]),
            "unit": ("coordinate", [row.unit for row in table]),
            "velocity_unit": ("coordinate", [row.velocity_unit for row in table]),
            "acceleration_unit": ("coordinate", [row.acceleration_unit for row in table]),
        }
    )
    if states := description.states:
        units = {row.unit or "1" for row in states}
        about_y = {"long_name": "first-order states and sampled values"}
        about_y |= {"units": units.pop()} if len(units) == 1 else {}
        of_states = [row.column for row in states]
        labels.add("y", "time state", lambda r: _columns(r.samples.v, of_states), about_y)
        labels.coords["state"] = list(states.names)
        labels.coords["state_unit"] = "state", [row.unit or "1" for row in states]


def _add_reactions(labels: Labels, result: Result) -> None:
    rows = result.description.series.of_kind("reaction")
    joints = {name: k for k, name in enumerate(dict.fromkeys(row.element for row in rows))}
    units = {row.component: row.unit for row in rows}
    components = {name: k for k, name in enumerate(units)}
    places = np.full((len(joints), len(components)), -1)
    for row in rows:
        places[joints[row.element], components[row.component]] = row.column
    flat = places.ravel().tolist()
    labels.coords["joint"], labels.coords["component"] = _texts(joints), _texts(components)
    labels.coords["component_unit"] = "component", _texts(units.values())
    about = {"long_name": "first body on second, in joint axes, in component_unit"}
    labels.add(
        "reaction", "time joint component",
        lambda r: _columns(r.samples.reaction, flat).reshape(len(r.t), *places.shape), about,
    )  # fmt: skip


def _add_effects(labels: Labels, result: Result) -> None:
    """A variable for each quantity of effects, over time and effect; not a number of others."""
    found: dict[str, dict[str, Series]] = {}  # quantity → label → series
    for row in result.description.series.of_kind("effect"):
        quantity = row.quantity or "component"
        part = row.component.removeprefix(quantity).removeprefix(".")
        found.setdefault(quantity, {})[f"{row.element}.{part}" if part else row.element] = row
    names = list(dict.fromkeys(name for parts in found.values() for name in parts))
    if names:
        labels.coords["effect"] = _texts(names)
    for quantity, parts in found.items():
        columns = [parts[name].column if name in parts else -1 for name in names]
        units = {row.unit for row in parts.values()}
        if len(units) > 1:
            of_name = (parts[name].unit if name in parts else "" for name in names)
            labels.coords[f"{quantity}_unit"] = "effect", _texts(of_name)
        about = {"units": units.pop()} if len(units) == 1 else {}
        labels.add(quantity, "time effect", _reactions_in(columns), about)


def _reactions_in(columns: list[int]) -> Callable[[Result], FloatArray]:
    return lambda result: _columns(result.samples.reaction, columns)
