"""A result as an xarray.Dataset."""

from typing import TYPE_CHECKING, Any

import numpy as np

from runtime.results.time_series import TimeSeries

if TYPE_CHECKING:
    import xarray as xr


Variables = dict[str, Any]


def dataset(result: TimeSeries) -> "xr.Dataset":
    """Label the arrays of a result; reactions that a joint does not have are not a number."""
    import xarray as xr

    description = result.description
    variables, coords = _motion(result)
    parts = [_powers_and_energies(result)] if description.has_masses else []
    if description.has_masses:
        parts.append(_reactions(result))
    if result.works:
        work = np.column_stack(list(result.works.values()))
        workers = np.array(list(result.works), dtype=np.str_)
        parts.append(({"work": (("time", "worker"), work, {"units": "J"})}, {"worker": workers}))
    if description.tracked:
        points = np.array(description.tracked, dtype=np.str_)
        paths = np.stack([result.path(name) for name in description.tracked], axis=1)
        path = {"path": (("time", "point", "axis"), paths, {"units": "m"})}
        parts.append((path, {"point": points, "axis": ["x", "y"]}))
    if description.switches:
        parts.append(_modes(result))
    for more_variables, more_coords in parts:
        variables |= more_variables
        coords |= more_coords
    return xr.Dataset(variables, coords=coords, attrs=result.about())


def _motion(result: TimeSeries) -> tuple[Variables, Variables]:
    table, samples, over = result.description.coordinates, result.samples, ("time", "coordinate")

    def units(of: str) -> str:
        return ", ".join(sorted({getattr(row, of) for row in table}))

    variables: Variables = {
        "q": (over, samples.q, {"units": units("unit"), "long_name": "coordinates"}),
        "v": (over, samples.v, {"units": units("velocity_unit"), "long_name": "velocities"}),
        "a": (over, samples.a, {"units": units("acceleration_unit"), "long_name": "accelerations"}),
        "constraint_residual": (
            "time",
            samples.residual[:, 0],
            {"units": "m, rad", "long_name": "largest |Phi|"},
        ),
        "velocity_residual": (
            "time",
            samples.residual[:, 1],
            {"units": "m/s, rad/s", "long_name": "largest |Phi_q v - nu|"},
        ),
    }
    return variables, {
        "time": ("time", samples.t, {"units": "s"}),
        "coordinate": list(table.names),
        "velocity": ("coordinate", [row.velocity for row in table]),
        "unit": ("coordinate", [row.unit for row in table]),
    }


def _reactions(result: TimeSeries) -> tuple[Variables, Variables]:
    description = result.description
    rows = [row for row in description.reactions if row.element not in description.tracked]
    joints = list(dict.fromkeys(row.element for row in rows))
    units = {row.component: row.unit for row in rows}
    components = list(units)
    reaction = np.full((len(result.t), len(joints), len(components)), np.nan)
    for row in rows:
        place = joints.index(row.element), components.index(row.component)
        reaction[:, place[0], place[1]] = result.reaction(row.element, row.component)
    about = {"units": "N, N m", "long_name": "first body on second, in joint axes"}
    return {"reaction": (("time", "joint", "component"), reaction, about)}, {
        "joint": np.array(joints, dtype=np.str_),
        "component": np.array(components, dtype=np.str_),
        "component_unit": ("component", np.array(list(units.values()), dtype=np.str_)),
    }


def _powers_and_energies(result: TimeSeries) -> tuple[Variables, Variables]:
    description, samples = result.description, result.samples
    sources = [index for index, row in enumerate(description.powers) if row.kind != "work"]
    names = [description.powers[index].name for index in sources]
    variables: Variables = {
        "power": (("time", "source"), samples.power[:, sources], {"units": "W"})
    }
    coords: Variables = {"source": np.array(names, dtype=np.str_)}
    if not description.unasked("energy"):
        energy = np.column_stack([samples.energy, samples.energy.sum(axis=1)])
        variables["energy"] = (("time", "part"), energy, {"units": "J"})
        coords["part"] = ["kinetic", "potential", "total"]
    return variables, coords


def _modes(result: TimeSeries) -> tuple[Variables, Variables]:
    switches, over = result.description.switches, ("time", "switch")
    mode = {"long_name": "1: condition holds, 0: not, 2: its function stays at zero"}
    share = {"units": "1", "long_name": "share of the force of mode 1 where mode is 2"}
    variables: Variables = {
        "mode": (over, result.samples.modes, mode),
        "share": (over, result.samples.share, share),
    }
    return variables, {
        "switch": np.array([row.title for row in switches], dtype=np.str_),
        "switch_kind": ("switch", np.array([row.kind for row in switches], dtype=np.str_)),
    }
