"""Attributes of a sweep's store: what they say, checked, for a store may come from anywhere."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from codegen.readers.values import shown
from runtime.sweeps.column_names import DONE, LAST, MESSAGE, OUTCOME, name_problems
from runtime.sweeps.design import MOST_RUNS

FORMAT = 3  # of the attributes below, and of the marks
ATTRIBUTES = "linkwright_sweep"


class Layout(NamedTuple):
    """Runs of a sweep, in blocks."""

    runs: int
    block: int  # runs of a block; the last one may have fewer

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return -(-self.runs // self.block)

    def runs_of(self, block: int) -> range:
        """The runs of a block."""
        return range(block * self.block, min((block + 1) * self.block, self.runs))


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_names(value: object) -> bool:
    return isinstance(value, list) and all(map(_is_text, value))


def _is_count(value: object) -> bool:
    return type(value) is int and 1 <= value <= MOST_RUNS


def _is_mapping(value: object) -> bool:
    return isinstance(value, dict)


_KINDS: dict[str, Callable[[object], bool]] = {
    "identity": _is_text,
    "digest": _is_text,
    "facts": _is_mapping,
    "design": _is_mapping,
    "quantities": _is_names,
    "series": _is_names,
    "runs": _is_count,
    "block": _is_count,
    "seconds": lambda x: isinstance(x, int | float) and 0.0 <= x < math.inf,
}
_FACTS: dict[str, Callable[[object], bool]] = {
    "model": _is_text,
    "generated module": _is_text,
    "companions": _is_mapping,
    "analysis": _is_text,
    "start values": _is_names,
    "quantities": _is_mapping,
    "series": _is_names,
    "instants": _is_count,
    "options": _is_mapping,
    **dict.fromkeys(("parameters", "guess", "start"), _is_mapping),
    **dict.fromkeys(("t_start", "t_end"), lambda x: type(x) in (int, float)),
}
_DESIGN: dict[str, Callable[[object], bool]] = {
    "kind": _is_text,
    "names": _is_names,
    "factors": _is_mapping,
    "axes": lambda x: isinstance(x, dict) and all(map(_is_count, x.values())),
}


def require_attributes(about: Mapping[str, Any]) -> None:
    """Refuse attributes that no sweep has written.

    Raises
    ------
    ValueError
        With the first one that is wrong.
    """
    for part, kinds in (("", _KINDS), ("facts", _FACTS), ("design", _DESIGN)):
        values = about[part] if part else about
        for name, fits in kinds.items():
            if name not in values or not fits(values[name]):
                where = f"{part}, {name}" if part else name
                raise ValueError(f"{where} is {shown(values.get(name))}")
    runs, axes = about["runs"], about["design"]["axes"]
    names = about["design"]["names"]
    combinations = 1
    for count in axes.values():
        combinations *= count
    if axes and (combinations != runs or {*axes} != {*names}):
        raise ValueError(f"the grid has {combinations} points of {[*axes]}, for {runs} runs")
    for problem in name_problems([*names, *about["quantities"], *about["series"]]):
        raise ValueError(problem)


def lengths(about: Mapping[str, Any]) -> dict[str, int]:
    """Column → number of its rows."""
    layout = Layout(about["runs"], about["block"])
    names = [*about["design"]["names"], *about["quantities"], *about["series"]]
    found = dict.fromkeys([*names, OUTCOME, MESSAGE, LAST], layout.runs)
    return {**found, DONE: layout.blocks}
