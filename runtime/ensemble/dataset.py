"""The dataset of an ensemble: rows of runs, not a number behind the instant at which one ended."""

from typing import TYPE_CHECKING, Any

import numpy as np

from runtime.ensemble.members import FloatArray, Members
from runtime.results.result import Result

if TYPE_CHECKING:
    import xarray as xr

NOT_RUN = "not run"
"""The outcome of a member that an interruption left out."""


class Rows:
    """The variables of the runs so far, over run, time and their own dimensions."""

    def __init__(self, members: Members, times: FloatArray) -> None:
        self.members, self.times = members, times
        self.outcomes = [NOT_RUN] * members.count
        self.messages = [""] * members.count
        self.events = np.zeros(members.count, np.int64)
        self.arrays: dict[str, FloatArray] = {}
        self.template: xr.Dataset | None = None

    def refuse(self, run: int, error: Exception) -> None:
        """Note a member whose run could not begin."""
        self.outcomes[run], self.messages[run] = type(error).__name__, str(error)

    def take(self, run: int, result: Result) -> None:
        """Copy a run's variables up to the last of the instants that it reached."""
        self.outcomes[run], self.messages[run] = str(result.outcome), result.message
        self.events[run] = len(result.events)
        data = result.data
        if self.template is None:
            self.template = data
            for name, variable in data.data_vars.items():
                if variable.dims[:1] == ("time",):
                    shape = self.members.count, len(self.times), *variable.shape[1:]
                    self.arrays[str(name)] = np.full(shape, np.nan)
        # the last state of a run that ended early is none of the instants
        at = np.searchsorted(self.times, result.t)
        at = np.minimum(at, len(self.times) - 1)
        kept = self.times[at] == result.t
        for name, array in self.arrays.items():
            array[run, at[kept]] = data[name].values[kept]

    def dataset(self) -> "xr.Dataset":
        """All rows with their outcomes, messages and the values that were given."""
        import xarray as xr

        variables: dict[str, Any] = {
            "outcome": ("run", np.array(self.outcomes, dtype=np.str_)),
            "message": ("run", np.array(self.messages, dtype=np.str_)),
            "event_count": ("run", self.events, {"units": "1"}),
        }
        coords: dict[str, Any] = {
            "run": np.arange(self.members.count), "time": ("time", self.times, {"units": "s"})
        }  # fmt: skip
        for name, column in self.members.parameters.items():
            variables[f"parameter_{name}"] = "run", column
        for name, column in self.members.starts.items():
            variables[f"start_{name}"] = "run", column
        if self.template is not None:
            for name, coord in self.template.coords.items():
                if "time" not in coord.dims:
                    coords[str(name)] = coord.variable
            for name, array in self.arrays.items():
                like = self.template[name]
                variables[name] = ("run", *like.dims), array, like.attrs
        return xr.Dataset(variables, coords=coords)
