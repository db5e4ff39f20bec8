"""An axis as a modeller writes it: two lengths, whose direction counts."""

from typing import Any

import sympy

from codegen.declare.reading import Reader


def read_axis(read: Reader, axis: Any, name: str) -> tuple[sympy.Expr, sympy.Expr]:
    """The components of `axis`, m; what is no pair is noted, and read as (1, 0)."""
    try:
        first, second = axis
    except (TypeError, ValueError):
        read.problems.append(f"axis of '{name}': {axis!r} is no pair; write axis=(1, 0).")
        first, second = 1, 0
    where = f"axis of '{name}'"
    return read.value(first, "m", where), read.value(second, "m", where)
