"""Python literals laid out as a formatter would."""

import json
from collections.abc import Iterable, Sequence
from typing import Any

WIDTH = 100


def assignment(name: str, value: Any) -> list[str]:
    """``NAME = literal``, on one line if it fits, else one element a line."""
    line = f"{name} = {literal(value)}"
    if len(line) <= WIDTH:
        return [line]
    if all(isinstance(item, int) for item in value):
        return [f"{name} = (", "    # fmt: off", *_rows(value), "    # fmt: on", ")"]
    return [f"{name} = (", *(line for item in value for line in _row(item)), ")"]


def literal(value: Any) -> str:
    """A number, text, or tuple of them."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Sequence):
        inside = ", ".join(literal(item) for item in value)
        return f"({inside},)" if len(value) == 1 else f"({inside})"
    return repr(value)


def _row(item: Any) -> list[str]:
    line = f"    {literal(item)},"
    if len(line) <= WIDTH or isinstance(item, str):
        return [line]
    return ["    (", *(f"        {literal(part)}," for part in item), "    ),"]


def _rows(numbers: Iterable[int]) -> list[str]:
    rows, line = [], "   "
    for number in numbers:
        if len(line) + len(str(number)) + 2 > WIDTH:
            rows.append(line)
            line = "   "
        line += f" {number},"
    return [*rows, line]
