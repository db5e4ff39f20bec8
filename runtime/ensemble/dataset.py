"""The dataset of an ensemble: rows of runs, not a number behind the instant at which one ended."""

from copy import copy
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from runtime.ensemble.members import FloatArray, Members
from runtime.results.dataset import dataset
from runtime.results.result import Result
from runtime.results.samples import Samples

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
        self.first: Result | None = None  # of the runs, which share its description
        self.samples: list[FloatArray] = []  # of each field of `Samples`, (runs, k, ...)
        self.works: dict[str, FloatArray] = {}

    def refuse(self, run: int, error: Exception) -> None:
        """Note a member whose run could not begin."""
        self.outcomes[run], self.messages[run] = type(error).__name__, str(error)

    def take(self, run: int, result: Result) -> None:
        """Copy a run's variables up to the last of the instants that it reached."""
        self.outcomes[run], self.messages[run] = str(result.outcome), result.message
        self.events[run] = len(result.events)
        if self.first is None:
            self.first, shape = result, (self.members.count, len(self.times))
            rest = [field.shape[1:] for field in result.samples]
            self.samples = [np.full((*shape, *more), np.nan) for more in rest]
            self.works = {name: np.full(shape, np.nan) for name in result.works}
        # the last state of a run that ended early is none of the instants
        at = np.searchsorted(self.times, result.t)
        at = np.minimum(at, len(self.times) - 1)
        kept = self.times[at] == result.t
        for array, field in zip(self.samples, result.samples, strict=True):
            array[run, at[kept]] = field[kept]
        for name, array in self.works.items():
            array[run, at[kept]] = result.works[name][kept]

    def _joined(self, first: Result) -> "xr.Dataset":
        """The variables of all runs one behind the other, as those of a single result."""
        whole, count = copy(first), self.members.count * len(self.times)
        columns = (array.reshape(count, *array.shape[2:]) for array in self.samples)
        whole.samples = Samples(*cast(Any, columns))
        whole.works = {name: array.reshape(count) for name, array in self.works.items()}
        return dataset(whole)

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
        if self.first is not None:
            joined, shape = self._joined(self.first), (self.members.count, len(self.times))
            for label, coord in joined.coords.items():
                if "time" not in coord.dims:
                    coords[str(label)] = coord.variable
            for label, variable in joined.data_vars.items():
                values = variable.values.reshape(*shape, *variable.shape[1:])
                variables[str(label)] = ("run", *variable.dims), values, variable.attrs
        return xr.Dataset(variables, coords=coords)
