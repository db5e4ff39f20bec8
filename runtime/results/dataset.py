"""A result as an xarray.Dataset."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from runtime.results.result import Result

if TYPE_CHECKING:
    import xarray as xr


Variables = dict[str, Any]


def dataset(result: Result) -> "xr.Dataset":
    """Label the arrays of a result; reactions that a joint does not have are not a number."""
    import xarray as xr

    description = result.description
    variables, coords = _motion(result)
    parts = []
    if description.has_masses:
        parts += [_powers_and_energies(result), _reactions(result)]
    if result.works:
        work = np.column_stack(list(result.works.values()))
        parts.append((
            {"work": (("time", "worker"), work, {"units": "J"})},
            {"worker": _texts(result.works)},
        ))
    if description.tracked:
        paths = np.stack([result.path(name) for name in description.tracked], axis=1)
        parts.append((
            {"path": (("time", "point", "axis"), paths, {"units": "m"})},
            {"point": _texts(description.tracked), "axis": ["x", "y"]},
        ))
    if description.switches:
        parts.append(_modes(result))
    for more_variables, more_coords in parts:
        variables |= more_variables
        coords |= more_coords
    return xr.Dataset(variables, coords=coords, attrs=result.about())


def _texts(values: Iterable[str]) -> npt.NDArray[np.str_]:
    """Labels, of type text also where there are none."""
    return np.array(list(values), dtype=np.str_)


def _motion(result: Result) -> tuple[Variables, Variables]:
    table, samples, over = result.description.coordinates, result.samples, ("time", "coordinate")

    def units(of: str) -> str:
        return ", ".join(sorted({getattr(row, of) for row in table}))

    positions = {"units": "m, rad", "long_name": "largest |Phi|"}
    velocities = {"units": "m/s, rad/s", "long_name": "largest |Phi_q v - nu|"}
    variables: Variables = {
        "q": (over, samples.q, {"units": units("unit"), "long_name": "coordinates"}),
        "v": (over, samples.v, {"units": units("velocity_unit"), "long_name": "velocities"}),
        "a": (over, samples.a, {"units": units("acceleration_unit"), "long_name": "accelerations"}),
        "constraint_residual": ("time", samples.residual[:, 0], positions),
        "velocity_residual": ("time", samples.residual[:, 1], velocities),
    }
    return variables, {
        "time": ("time", samples.t, {"units": "s"}),
        "coordinate": list(table.names),
        "velocity": ("coordinate", [row.velocity for row in table]),
        "unit": ("coordinate", [row.unit for row in table]),
    }


def _reactions(result: Result) -> tuple[Variables, Variables]:
    description = result.description
    rows = [row for row in description.reactions if row.element not in description.tracked]
    joints = list(dict.fromkeys(row.element for row in rows))
    units = {row.component: row.unit for row in rows}
    components = list(units)
    reaction = np.full((len(result.t), len(joints), len(components)), np.nan)
    for row in rows:
        joint, component = joints.index(row.element), components.index(row.component)
        reaction[:, joint, component] = result.reaction(row.element, row.component)
    about = {"units": "N, N m", "long_name": "first body on second, in joint axes"}
    return {"reaction": (("time", "joint", "component"), reaction, about)}, {
        "joint": _texts(joints),
        "component": _texts(components),
        "component_unit": ("component", _texts(units.values())),
    }


def _powers_and_energies(result: Result) -> tuple[Variables, Variables]:
    description, samples = result.description, result.samples
    sources = [index for index, row in enumerate(description.powers) if row.kind != "work"]
    power = (("time", "source"), samples.power[:, sources], {"units": "W"})
    variables: Variables = {"power": power}
    coords: Variables = {"source": _texts(description.powers[index].name for index in sources)}
    if not description.leaves_out("energy"):
        energy = np.column_stack([samples.energy, samples.energy.sum(axis=1)])
        variables["energy"] = (("time", "part"), energy, {"units": "J"})
        coords["part"] = ["kinetic", "potential", "total"]
    return variables, coords


def _modes(result: Result) -> tuple[Variables, Variables]:
    switches, over = result.description.switches, ("time", "switch")
    mode = {"long_name": "1: condition holds, 0: not, 2: its function stays at zero"}
    share = {"units": "1", "long_name": "share of the force of mode 1 where mode is 2"}
    variables: Variables = {
        "mode": (over, result.samples.modes, mode),
        "share": (over, result.samples.share, share),
    }
    return variables, {
        "switch": _texts(row.title for row in switches),
        "switch_kind": ("switch", _texts(row.kind for row in switches)),
    }
