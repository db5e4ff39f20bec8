"""The dataset of an ensemble: rows of runs, not a number behind the instant at which one ended."""

from copy import copy
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from runtime.core.outcomes import Outcome
from runtime.dynamics.output_quantities import leave_out_unknown
from runtime.ensemble.members import FloatArray, Members
from runtime.ensemble.preparation import Preparation
from runtime.results.dataset import Labels, labels_of
from runtime.results.result import Result
from runtime.results.samples import Samples

if TYPE_CHECKING:
    import xarray as xr

BoolArray = npt.NDArray[np.bool_]

NOT_RUN = "not run"
"""The outcome of a member that an interruption left out."""


class Rows:
    """The variables of the runs so far, over run, time and their own dimensions."""

    def __init__(self, members: Members, times: FloatArray) -> None:
        self.members, self.times, count = members, times, members.count
        self.outcomes, self.messages = [NOT_RUN] * count, [""] * count
        # What the compiled loop says of its members: see `member_arrays.Results`.
        self.status, self.steps, self.events, self.logged = np.zeros((4, count), np.int64)
        self.unresolved = np.zeros((0, 0, 0))
        self.placed = np.zeros(count, np.bool_)  # whether a member's row is that of its run there
        self.first: Result | None = None  # of the runs, which share its labels
        self.labels = Labels([], {})
        self.arrays: dict[str, FloatArray] = {}  # of each variable, (runs, k, ...)

    def refuse(self, run: int, error: Exception) -> None:
        """Note a member whose run could not begin."""
        self.outcomes[run], self.messages[run] = type(error).__name__, str(error)

    def _open(self, result: Result) -> None:
        """Make room for the variables of all runs, which have the form of this one."""
        count = self.members.count
        self.labels = labels_of(result)
        for row in self.labels.variables:
            rest = row.values(result).shape[1:]
            self.arrays[row.name] = np.empty((count, len(self.times), *rest))
        self.unresolved = np.zeros((count, result.samples.modes.shape[1], 4))
        self.first = result

    def take(self, run: int, result: Result) -> None:
        """Copy a run's variables up to the last of the instants that it reached."""
        if self.first is None:
            self._open(result)
        # the last state of a run that ended early is none of the instants
        at = np.searchsorted(self.times, result.t)
        at = np.minimum(at, len(self.times) - 1)
        kept = self.times[at] == result.t
        for row in self.labels.variables:
            array = self.arrays[row.name]
            array[run] = np.nan
            array[run, at[kept]] = row.values(result)[kept]
        self.events[run] = len(result.events)
        self.outcomes[run], self.messages[run] = str(result.outcome), result.message

    def place(self, first: int, done: BoolArray, samples: Samples) -> None:
        """Copy the variables of the members from `first` on that are `done`, (b,).

        `samples` are those of a block, (b, k, ...), of which the first rows are these members.
        """
        assert self.first is not None
        whole, count, last = copy(self.first), len(done), first + len(done)
        columns = (
            array[:count].reshape(count * len(self.times), *array.shape[2:]) for array in samples
        )
        whole.samples = Samples(*cast(Any, columns))
        leave_out_unknown(whole.description, whole.samples)
        for row in self.labels.variables:
            values = row.values(whole)
            values = values.reshape(count, len(self.times), *values.shape[1:])
            array = self.arrays[row.name][first:last]
            if done.all():
                array[:] = values
            else:
                array[done] = values[done]
        self.placed[first:last] = done

    def complete(self, made: Preparation | None) -> None:
        """Say how the runs of the compiled loop ended; members without a run are no numbers."""
        for run in np.flatnonzero(self.placed).tolist():
            assert made is not None
            start, count = self.members.start_of(run), int(self.logged[run])
            self.outcomes[run] = str(Outcome.OK)
            self.messages[run] = made.message(
                int(self.steps[run]), start, self.unresolved[run], count
            )
        without = np.array([said not in Outcome.__members__ for said in self.outcomes])
        self.events[without] = 0
        for array in self.arrays.values():
            array[without] = np.nan

    def dataset(self) -> "xr.Dataset":
        """All rows with their outcomes, messages and the values that were given."""
        import xarray as xr

        variables: dict[str, Any] = {
            "outcome": ("run", np.array(self.outcomes, dtype=np.str_)),
            "message": ("run", np.array(self.messages, dtype=np.str_)),
            "event_count": ("run", self.events, {"units": "1"}),
        }
        for name, column in self.members.parameters.items():
            variables[f"parameter_{name}"] = "run", column
        for name, column in self.members.starts.items():
            variables[f"start_{name}"] = "run", column
        for row in self.labels.variables:
            variables[row.name] = ("run", *row.dims), self.arrays[row.name], row.about
        coords: dict[str, Any] = {
            "run": np.arange(self.members.count), "time": ("time", self.times, {"units": "s"})
        }  # fmt: skip
        return xr.Dataset(variables, coords=coords | self.labels.coords)
