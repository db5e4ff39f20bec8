"""A result as an xarray.Dataset."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from runtime.results.effect_series import quantity_of
from runtime.results.result import Result

if TYPE_CHECKING:
    import xarray as xr


def dataset(result: Result) -> "xr.Dataset":
    """Label the arrays of a result; reactions that a joint does not have are not a number."""
    description, samples = result.description, result.samples
    data = _motion(result)
    if description.has_masses:
        whole = description.whole_powers
        data["source"] = _texts(whole)
        data["power"] = ("time", "source"), samples.power[:, list(whole.values())], {"units": "W"}
        parts = [k for k, row in enumerate(description.powers) if row.kind == "nonconservative"]
        if parts:
            over = "time", "nonconservative_source"
            data[over[1]] = _texts(description.powers[k].name for k in parts)
            about = {"units": "W", "long_name": "power of the forces without a potential"}
            data["nonconservative_power"] = over, samples.power[:, parts], about
        if not description.leaves_out("energy"):
            energy = np.column_stack([samples.energy, samples.energy.sum(axis=1)])
            data["part"] = ["kinetic", "potential", "total"]
            data["energy"] = ("time", "part"), energy, {"units": "J"}
        _add_reactions(data, result)
    _add_effects(data, result)
    if result.works:
        data["worker"] = _texts(result.works)
        work = np.column_stack(list(result.works.values()))
        data["work"] = ("time", "worker"), work, {"units": "J"}
    if description.tracked:
        data["place"], data["axis"] = _texts(description.tracked), ["x", "y"]
        for variable, axes, unit in (("point", "x y", "m"), ("point_velocity", "vx vy", "m/s")):
            places = [
                [result.point(name, axis) for axis in axes.split()] for name in description.tracked
            ]
            values = np.moveaxis(np.array(places), 2, 0)
            data[variable] = ("time", "place", "axis"), values, {"units": unit}
    if switches := description.switches:
        data["switch"] = _texts(row.title for row in switches)
        data.coords["switch_kind"] = "switch", _texts(row.kind for row in switches)
        mode = {"long_name": "1: condition holds, 0: not, 2: its function stays at zero"}
        share = {"units": "1", "long_name": "share of the force of mode 1 where mode is 2"}
        data["mode"] = ("time", "switch"), samples.modes, mode
        data["share"] = ("time", "switch"), samples.share, share
    return data


def _texts(values: Iterable[str]) -> npt.NDArray[np.str_]:
    """Labels, of type text also where there are none."""
    return np.array(list(values), dtype=np.str_)


def _motion(result: Result) -> "xr.Dataset":
    """Coordinates, velocities, accelerations and residuals."""
    import xarray as xr

    description, samples, over = result.description, result.samples, ("time", "coordinate")
    table = description.positions
    columns = [k for k, row in enumerate(description.coordinates) if not row.is_state]

    def about(name: str, unit: str) -> dict[str, str]:
        units = {getattr(row, unit) for row in table}
        return {"long_name": name} | ({"units": units.pop()} if len(units) == 1 else {})

    positions = {"long_name": "largest |Phi|, m or rad"}
    velocities = {"long_name": "largest |Phi_q v - nu|, m/s or rad/s"}
    variables: dict[str, Any] = {
        "q": (over, samples.q[:, columns], about("coordinates", "unit")),
        "v": (over, samples.v[:, columns], about("velocities", "velocity_unit")),
        "a": (over, samples.a[:, columns], about("accelerations", "acceleration_unit")),
        "constraint_residual": ("time", samples.residual[:, 0], positions),
        "velocity_residual": ("time", samples.residual[:, 1], velocities),
    }
    coords: dict[str, Any] = {
        "time": ("time", samples.t, {"units": "s"}),
        "coordinate": [row.name for row in table],
        "velocity": ("coordinate", [row.velocity for row in table]),
        "unit": ("coordinate", [row.unit for row in table]),
        "velocity_unit": ("coordinate", [row.velocity_unit for row in table]),
        "acceleration_unit": ("coordinate", [row.acceleration_unit for row in table]),
    }
    if states := description.states:
        units = {row.unit or "1" for row in states}
        about_y = {"long_name": "first-order states and sampled values"}
        about_y |= {"units": units.pop()} if len(units) == 1 else {}
        variables["y"] = ("time", "state"), samples.v[:, [row.column for row in states]], about_y
        coords["state"] = list(states.names)
        coords["state_unit"] = "state", [row.unit or "1" for row in states]
    return xr.Dataset(variables, coords=coords, attrs=result.about())


def _add_reactions(data: "xr.Dataset", result: Result) -> None:
    description = result.description
    effects = description.effects.names
    columns = [k for k, row in enumerate(description.reactions) if row.element not in effects]
    rows = [description.reactions[k] for k in columns]
    joints = {name: k for k, name in enumerate(dict.fromkeys(row.element for row in rows))}
    units = {row.component: row.unit for row in rows}
    components = {name: k for k, name in enumerate(units)}
    reaction = np.full((len(result.t), len(joints), len(components)), np.nan)
    for column, row in zip(columns, rows, strict=True):
        place = joints[row.element], components[row.component]
        reaction[:, *place] = result.samples.reaction[:, column]
    data["joint"], data["component"] = _texts(joints), _texts(components)
    data.coords["component_unit"] = "component", _texts(units.values())
    about = {"long_name": "first body on second, in joint axes, in component_unit"}
    data["reaction"] = ("time", "joint", "component"), reaction, about


def _add_effects(data: "xr.Dataset", result: Result) -> None:
    """A variable for each quantity of effects, over time and effect; not a number of others."""
    description = result.description
    effects = {*description.effects.names} - {*description.tracked}
    found: dict[str, dict[str, tuple[int, str]]] = {}  # quantity → label → column and unit
    for column, row in enumerate(description.reactions):
        if row.element in effects:
            quantity = quantity_of(row) or "component"
            part = row.component.removeprefix(quantity).removeprefix(".")
            label = f"{row.element}.{part}" if part else row.element
            found.setdefault(quantity, {})[label] = column, row.unit
    labels = list(dict.fromkeys(label for parts in found.values() for label in parts))
    if labels:
        data["effect"] = _texts(labels)
    for quantity, parts in found.items():
        values = np.full((len(result.t), len(labels)), np.nan)
        for label, (column, _) in parts.items():
            values[:, labels.index(label)] = result.samples.reaction[:, column]
        units = {unit for _, unit in parts.values()}
        if len(units) > 1:
            of_label = (parts[label][1] if label in parts else "" for label in labels)
            data.coords[f"{quantity}_unit"] = "effect", _texts(of_label)
        about = {"units": units.pop()} if len(units) == 1 else {}
        data[quantity] = ("time", "effect"), values, about
