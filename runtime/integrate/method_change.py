"""The change of method in a run, between two steps."""

from typing import TYPE_CHECKING, Any

import numpy as np

from runtime.core.workspace import PARTITION
from runtime.integrate.method import Method, find_method
from runtime.integrate.wiring import METHOD_SLOTS, function_table

if TYPE_CHECKING:
    from runtime.integrate.run import _Run

_MOST_PATIENCE = 1024  # safety: times the first, before a method is changed


def fill_method(r: Any, method: Method) -> None:
    """Write the numbers of a method into a run's record."""
    r["order"], r["last"] = method.order, method.last
    r["stage_calls"], r["dense_calls"] = method.stage_calls, method.dense_calls
    r["dense_rows"], r["foresight"] = method.dense_rows, method.foresight
    r["exponent"], r["beta"] = 1.0 / (method.error_order + 1), method.beta
    r["safety"], r["shrink"], r["grow"] = method.safety, method.shrink, method.grow


def change_method(run: "_Run") -> None:
    """Go on with the method that suits: the state and its derivative are all that it needs.

    Each change doubles the number of steps that have to speak for the next one.
    """
    from runtime.integrate.implicit.stiffness_switching import (
        successor,  # most runs need none of its functions
    )

    r = run.r
    free = run.rows[PARTITION, 0] == 0.0
    freedoms = int(np.count_nonzero(free)) if run.m else run.n
    name = successor(run.methods[-1][1], freedoms, run.options.rtol)
    run.methods.append((float(r["t"]), name))
    r["patience"] = min(2 * r["patience"], _MOST_PATIENCE)
    adopt(run, name)


def adopt(run: "_Run", name: str) -> None:
    """Take the next steps with the method `name`, for which nothing is to be remembered."""
    r, method = run.r, find_method(name)
    fill_method(r, method)
    run.crossings.follow(method)
    run.table[METHOD_SLOTS] = function_table(name)
    run.wiring.arrays["method_integers"][:] = 0
    method.restart(run.table, r["t"], r["h"])
