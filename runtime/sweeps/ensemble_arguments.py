"""The arguments of an ensemble, and the values of its members."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.readers.quantities import each_in_unit
from codegen.readers.values import KindError, shown
from runtime.core.arrays import Vector
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.table_rows import unknown
from runtime.processors import available_cores
from runtime.validation.arguments import check, instants_of_motion, refuse_integration, uniform
from runtime.validation.scene_support import refuse_states, require_motion

Columns = Mapping[str, npt.ArrayLike]
"""Values by name: one for all members, or an array with one for each, (r,)."""
DRIVEN = ("kinematics", "inverse_dynamics")
"""The analyses of motions that drivers prescribe."""
_OF_SIMULATIONS = ("method", "rtol", "atol", "max_step", "max_steps")


@dataclass(frozen=True)
class Members:
    """Values of r members by name, (r,) each, in SI units."""

    count: int
    parameters: dict[str, Vector]
    starts: dict[str, Vector]
    guesses: dict[str, Vector]

    def of(self, run: int) -> dict[str, dict[str, float] | None]:
        """The words of an analysis that are one member's own; None where it has no values."""
        words = {"parameters": self.parameters, "start": self.starts, "guess": self.guesses}
        return {
            word: {name: float(column[run]) for name, column in columns.items()} or None
            for word, columns in words.items()
        }


def read_ensemble(mechanism: Mechanism, given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of `Machine.ensemble`, by name, as those of `run_ensemble` and its bar."""
    require_motion(mechanism, "ensemble")
    analysis = check(mechanism, {"analysis": given["analysis"]})["analysis"]
    columns = {name: given[name] for name in ("parameters", "starts", "guesses")}
    plain = {name: value for name, value in given.items() if name not in {*columns, "t_end"}}
    if analysis == "simulate":
        words = check(mechanism, plain | {"t_end": given["t_end"]})
        last, times = words.pop("t_end"), words.pop("t_eval")
        if isinstance(times, str):
            raise InputError('ensemble: t_eval = "steps" differs between runs; give instants.')
        if times is None or isinstance(times, int):
            times = uniform(words["t_start"], last, times)
    elif analysis in DRIVEN:
        refuse_states(mechanism, analysis)
        words = check(mechanism, plain)
        times = instants_of_motion(given["t_end"], words.pop("t_eval"), words["t_start"], analysis)
        last = float(times[-1])
        refuse_integration(
            f"{mechanism.title}: ensemble", analysis,
            (name for name in _OF_SIMULATIONS if words[name] is not None),
        )  # fmt: skip
    else:
        raise InputError(
            f"{mechanism.title}: ensemble: {analysis} is no motion; take simulate, "
            f"{' or '.join(DRIVEN)}. A sweep takes {analysis} as well."
        )
    words["threads"] = words["threads"] or available_cores()
    words = {name: value for name, value in words.items() if value is not None}
    return {**words, "t_end": last, "times": times, "columns": columns}


def read_members(
    mechanism: Mechanism, parameters: Columns | None, starts: Columns | None,
    guesses: Columns | None = None,
) -> Members:  # fmt: skip
    """The members; raises InputError with every name, shape, length and value that misfits."""
    description = mechanism.description
    states = (*description.coordinates.names, *(row.velocity for row in description.coordinates))
    problems, lengths = list[str](), dict[str, int]()
    found = dict[str, Vector](), dict[str, Vector](), dict[str, Vector]()
    units = dict.fromkeys(description.spins, "rad/s")
    units |= {name: row.unit for name in states if (row := description.series.get(name))}
    units |= {row.name: row.unit for row in description.parameters}
    tables: tuple[tuple[str, str, Any, tuple[str, ...]], ...] = (
        ("parameters", "parameter", parameters, description.parameters.names),
        ("starts", "coordinate or velocity", starts, (*states, *description.spins)),
        ("guesses", "coordinate or velocity", guesses, states),
    )
    for columns, (argument, kind, given, names) in zip(found, tables, strict=True):
        if given is not None and not hasattr(given, "keys"):  # which a DataFrame has, too
            problems.append(f"{argument} is {shown(given)}; it must be arrays by name.")
            continue
        for name, values in dict(() if given is None else given).items():
            label = f"{argument}[{name!r}]"
            try:
                if name not in names:
                    raise KindError(unknown(kind, name, names))
                columns[name] = column = _column(values, units.get(name, ""))
                lengths |= {label: len(column)} if column.ndim else {}
            except KindError as misfit:
                problems.append(f"{label}: {misfit}")
    problems += [
        f"{name} is given in starts and in guesses: starts sets a value, guesses only begins a "
        "search with it. Leave one of them out."
        for name in found[1].keys() & found[2].keys()
    ]
    if len({*lengths.values()}) > 1:
        named = ", ".join(f"{label} has {length}" for label, length in lengths.items())
        problems.append(
            f"the arrays disagree on the number of members: {named}. Give them one length."
        )
    if not lengths and not problems:
        problems.append(
            "no array says how many members there are: give at least one parameter, start value or "
            "guess as an array, one value a member."
        )
    if problems:
        raise InputError([f"{mechanism.title}: ensemble: {problem}" for problem in problems])
    count = next(iter(lengths.values()))
    whole = ({k: np.broadcast_to(x, (count,)) for k, x in columns.items()} for columns in found)
    return Members(count, *whole)


def _column(values: npt.ArrayLike, unit: str) -> Vector:
    """A number in a unit or one dimension of finite ones; KindError says what is wrong with it."""
    values = each_in_unit(values, unit)
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        raise KindError(f"{shown(values)}; it must be numbers.")
    if array.ndim > 1 or array.size == 0:
        raise KindError(
            f"the shape is {array.shape}; it must be a number, or one number a member, (runs,)."
        )
    column = array.astype(np.float64)
    wrong = np.flatnonzero(~np.isfinite(column))
    if len(wrong):
        raise KindError(
            f"{column.flat[wrong[0]]:g} in member {wrong[0]}, and not finite in {len(wrong)} of "
            f"{column.size}; give finite numbers."
        )
    return column
