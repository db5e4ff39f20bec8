"""A result as an xarray.Dataset."""

from typing import TYPE_CHECKING, Any

import numpy as np

from runtime.results.time_series import TimeSeries

if TYPE_CHECKING:
    import xarray as xr


def dataset(result: TimeSeries) -> "xr.Dataset":
    """Label the arrays of a result; reactions that a joint does not have are NaN."""
    import xarray as xr

    told, samples = result.description, result.samples
    over = ("time", "coordinate")
    units = sorted({row.unit for row in told.coordinates})

    def per(suffix: str) -> str:
        return ", ".join(f"{unit}{suffix}" for unit in units)

    variables: dict[str, Any] = {
        "q": (over, samples.q, {"units": per(""), "long_name": "coordinates"}),
        "v": (over, samples.v, {"units": per("/s"), "long_name": "velocities"}),
        "a": (over, samples.a, {"units": per("/s^2"), "long_name": "accelerations"}),
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
    coords: dict[str, Any] = {
        "time": ("time", samples.t, {"units": "s"}),
        "coordinate": list(told.coordinates.names),
        "velocity": ("coordinate", [row.velocity for row in told.coordinates]),
        "unit": ("coordinate", [row.unit for row in told.coordinates]),
    }
    if told.has_masses:
        forces = [row for row in told.reactions if row.element not in told.tracked]
        joints = list(dict.fromkeys(row.element for row in forces))
        components = list(dict.fromkeys(row.component for row in forces))
        reaction = np.full((len(samples.t), len(joints), len(components)), np.nan)
        for row in forces:
            place = joints.index(row.element), components.index(row.component)
            reaction[:, place[0], place[1]] = result.reaction(row.element, row.component)
        unit_of = {row.component: row.unit for row in forces}
        sources = [index for index, row in enumerate(told.powers) if row.kind != "work"]
        powers = [told.powers[index].name for index in sources]
        coords |= {
            "joint": np.array(joints, dtype=np.str_),
            "component": np.array(components, dtype=np.str_),
            "component_unit": (
                "component",
                np.array([unit_of[name] for name in components], dtype=np.str_),
            ),
            "part": ["kinetic", "potential", "total"],
            "source": np.array(powers, dtype=np.str_),
        }
        energy = np.column_stack([samples.energy, samples.energy.sum(axis=1)])
        if told.unasked("energy"):
            del coords["part"]
        else:
            variables["energy"] = (("time", "part"), energy, {"units": "J"})
        variables |= {
            "reaction": (
                ("time", "joint", "component"),
                reaction,
                {"units": "N, N m", "long_name": "first body on second, in joint axes"},
            ),
            "power": (("time", "source"), samples.power[:, sources], {"units": "W"}),
        }
    if result.works:
        coords["worker"] = np.array(list(result.works), dtype=np.str_)
        work = np.column_stack(list(result.works.values()))
        variables["work"] = (("time", "worker"), work, {"units": "J"})
    if told.tracked:
        coords |= {"point": np.array(told.tracked, dtype=np.str_), "axis": ["x", "y"]}
        paths = np.stack([result.path(name) for name in told.tracked], axis=1)
        variables["path"] = (("time", "point", "axis"), paths, {"units": "m"})
    if told.switches:
        coords |= {
            "switch": np.array([row.title for row in told.switches], dtype=np.str_),
            "switch_kind": ("switch", np.array([row.kind for row in told.switches], dtype=np.str_)),
        }
        variables |= {
            "mode": (
                ("time", "switch"),
                samples.modes,
                {"long_name": "1: condition holds, 0: not, 2: its function stays at zero"},
            ),
            "share": (
                ("time", "switch"),
                samples.share,
                {"units": "1", "long_name": "share of the force of mode 1 where mode is 2"},
            ),
        }
    return xr.Dataset(variables, coords=coords, attrs=result.about())
