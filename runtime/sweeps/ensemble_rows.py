"""Members of an ensemble, checked all at once, and their rows of one dataset."""

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.readers.values import shown
from runtime.core.outcomes import Outcome
from runtime.dynamics.output_quantities import leave_out_unknown
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.table_rows import unknown
from runtime.results.dataset import Labels, labels_of
from runtime.results.result import Result
from runtime.results.samples import Samples, require_memory, sample_bytes

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
Columns = Mapping[str, npt.ArrayLike]
"""Values by name: a number for all members, or an array with one for each, (r,)."""
NOT_RUN = "not run"
"""The outcome of a member that an interruption left out."""
_MEGABYTE = 1e6  # formula: bytes of a megabyte


@dataclass(frozen=True)
class Members:
    """Values of r members by name, (r,) each: parameters in their units, starts in SI units."""

    count: int
    parameters: dict[str, FloatArray]
    starts: dict[str, FloatArray]

    def parameters_of(self, run: int) -> dict[str, float]:
        """The parameters of one member, by name."""
        return {name: float(column[run]) for name, column in self.parameters.items()}

    def start_of(self, run: int) -> dict[str, float]:
        """The start values of one member, by name."""
        return {name: float(column[run]) for name, column in self.starts.items()}


def read_members(
    mechanism: Mechanism, parameters: Columns | None, starts: Columns | None
) -> Members:
    """The members; raises InputError with every name, shape, length and value that misfits."""
    description = mechanism.description
    coordinates = description.coordinates
    tables = (
        ("parameters", "parameter", parameters, description.parameters.names),
        ("starts", "coordinate or velocity", starts,
         (*coordinates.names, *(row.velocity for row in coordinates))),
    )  # fmt: skip
    problems, found, lengths = list[str](), list[dict[str, FloatArray]](), dict[str, int]()
    for argument, kind, given, names in tables:
        columns = dict[str, FloatArray]()
        found.append(columns)
        whole: Any = given
        if whole is not None and not isinstance(whole, Mapping):
            problems.append(f"{argument} is {shown(given)}; it must be arrays by name.")
            continue
        for name, values in (given or {}).items():
            if name not in names:
                problems.append(f"{argument}: {unknown(kind, name, names)}")
                continue
            label = f"{argument}[{name!r}]"
            column, problem = _column(label, values)
            if problem:
                problems.append(problem)
            elif column.ndim:
                lengths[label] = len(column)
            columns[name] = column
    problems += _disagreement(lengths)
    if not lengths and not problems:
        problems.append(
            "no array says how many members there are: give at least one parameter or start value "
            "as an array, one value a member."
        )
    if problems:
        raise InputError([f"{mechanism.title}: ensemble: {problem}" for problem in problems])
    count = next(iter(lengths.values()))
    of_parameters, of_starts = (
        {name: np.broadcast_to(column, (count,)) for name, column in columns.items()}
        for columns in found
    )
    return Members(count, of_parameters, of_starts)


def forbidden_members(mechanism: Mechanism, members: Members) -> BoolArray:
    """Whether a parameter of a member has a sign that it must not have, (r,)."""
    forbidden = np.zeros(members.count, np.bool_)
    for name, column in members.parameters.items():
        sign = mechanism.description.parameters[name].sign
        if sign:
            forbidden |= column <= 0.0 if sign == "positive" else column < 0.0
    return forbidden


def _column(label: str, values: npt.ArrayLike) -> tuple[FloatArray, str]:
    """A number or one dimension of finite ones, and what is wrong with it."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        return np.zeros(0), f"{label} is {shown(values)}; it must be numbers."
    if array.ndim > 1 or array.size == 0:
        shape = f"{label} has the shape {array.shape}"
        return np.zeros(0), f"{shape}; it must be a number, or one number a member, (runs,)."
    column = array.astype(np.float64)
    wrong = np.flatnonzero(~np.isfinite(np.atleast_1d(column)))
    if len(wrong):
        value = np.atleast_1d(column)[wrong[0]]
        return column, (
            f"{label} is {value:g} in member {wrong[0]}, and not finite in {len(wrong)} of "
            f"{column.size}; give finite numbers."
        )
    return column, ""


def _disagreement(lengths: Mapping[str, int]) -> Iterable[str]:
    """What to say of arrays that do not have one length."""
    if len({*lengths.values()}) > 1:
        named = ", ".join(f"{label} has {length}" for label, length in lengths.items())
        yield f"the arrays disagree on the number of members: {named}. Give them one length."


def require_room(mechanism: Mechanism, count: int, instants: int, max_bytes: int) -> None:
    """Refuse a dataset larger than `max_bytes` or than the free memory, before anything is run."""
    needed = count * instants * sample_bytes(mechanism.description)
    what, title = f"{count} runs of {instants} instants", f"{mechanism.title}: ensemble"
    if needed > max_bytes:
        raise InputError(
            f"{title}: {what} take {needed / _MEGABYTE:.0f} MB, and max_bytes permits "
            f"{max_bytes / _MEGABYTE:.0f} MB. Take fewer instants or runs, or raise max_bytes."
        )
    require_memory(title, what, needed, "Take fewer instants or runs.")


class Rows:
    """The variables of the runs so far, over run, time and their own dimensions."""

    def __init__(self, members: Members, times: FloatArray) -> None:
        self.members, self.times, count = members, times, members.count
        self.outcomes, self.messages = [NOT_RUN] * count, [""] * count
        # What the compiled loop says of its members: see `ensemble_arrays.Results`.
        self.status, self.steps, self.events, self.logged = np.zeros((4, count), np.int64)
        self.unresolved = np.zeros((0, 0, 0))
        self.placed = np.zeros(count, np.bool_)  # whether a member's row is that of its run there
        self.first: Result | None = None  # of the runs, which share its labels
        self.labels = Labels([], {})
        self.arrays: dict[str, FloatArray] = {}  # of each variable, (runs, k, ...)

    def take(self, run: int, result: Result) -> None:
        """Copy a run's variables up to the last of the instants that it reached."""
        if self.first is None:  # make room for the variables of all runs, which have its form
            count, self.first, self.labels = self.members.count, result, labels_of(result)
            for row in self.labels.variables:
                rest = row.values(result).shape[1:]
                self.arrays[row.name] = np.empty((count, len(self.times), *rest))
            self.unresolved = np.zeros((count, result.samples.modes.shape[1], 4))
        # the last state of a run that ended early is none of the instants
        at = np.minimum(np.searchsorted(self.times, result.t), len(self.times) - 1)
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
        chosen: Any = slice(None) if done.all() else done
        for row in self.labels.variables:
            values = row.values(whole)
            values = values.reshape(count, len(self.times), *values.shape[1:])
            self.arrays[row.name][first:last][chosen] = values[chosen]
        self.placed[first:last] = done

    def leave_out_failures(self) -> None:
        """Make members without a run no numbers, and without events."""
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
        for kind, columns in (
            ("parameter", self.members.parameters),
            ("start", self.members.starts),
        ):
            variables |= {f"{kind}_{name}": ("run", column) for name, column in columns.items()}
        for row in self.labels.variables:
            variables[row.name] = ("run", *row.dims), self.arrays[row.name], row.about
        coords: dict[str, Any] = {
            "run": np.arange(self.members.count), "time": ("time", self.times, {"units": "s"})
        }  # fmt: skip
        return xr.Dataset(variables, coords=coords | self.labels.coords)
