"""The table of the members of an ensemble: values by name, one a member, checked all at once."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.readers.values import shown
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.table_rows import unknown
from runtime.results.samples import require_memory, sample_bytes

FloatArray = npt.NDArray[np.float64]
Columns = Mapping[str, npt.ArrayLike]
"""Values by name: a number for all members, or an array with one for each, (r,)."""

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


def forbidden_members(mechanism: Mechanism, members: Members) -> npt.NDArray[np.bool_]:
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
