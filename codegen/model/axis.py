"""An axis as a modeller writes it: two lengths, whose direction counts."""

from typing import Any

import sympy

from codegen.declare.value_reader import Reader


def read_axis(read: Reader, axis: Any, name: str) -> tuple[sympy.Expr, sympy.Expr]:
    """The components of `axis`, m; what is no pair is noted, and read as (1, 0)."""
    return read.pair(axis, "m", f"axis of '{name}'", "axis=(1, 0)")
