"""An element as it is measured: how it is declared, and its hand-written twins."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from codegen import Model
from codegen.declare.body import Point

RHS = "acceleration_rhs"

Declare = Callable[[Model, Point, Point], Any]


@dataclass(frozen=True)
class Sample:
    """An element as it is measured.

    Attributes
    ----------
    kind
        The kind under which the library knows it.
    label
        What the table calls it.
    declare
        Adds it to a model between two points.
    twins
        Generated kernel → hand-written one.
    """

    kind: str
    label: str
    declare: Declare
    twins: dict[str, Any]


def joint(kind: str, declare: Declare, jacobian: Any, rhs: Any, label: str = "") -> Sample:
    return Sample(kind, label or kind, declare, {"jacobian": jacobian, RHS: rhs})


def force(kind: str, declare: Declare, twin: Any, label: str = "") -> Sample:
    return Sample(kind, label or kind, declare, {"applied_forces": twin})
