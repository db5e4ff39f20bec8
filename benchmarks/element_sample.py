"""An element as it is measured: how it is declared, and its hand-written twins."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

RHS = "acceleration_rhs"

Declare = Callable[[Any, Any, Any], Any]
"""A model and two points, in the plane or in space."""


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
    space
        Whether the model is one in space.
    """

    kind: str
    label: str
    declare: Declare
    twins: dict[str, Any]
    space: bool = False


def joint(kind: str, declare: Declare, jacobian: Any, rhs: Any, label: str = "") -> Sample:
    return Sample(kind, label or kind, declare, {"jacobian": jacobian, RHS: rhs})


def force(kind: str, declare: Declare, twin: Any, label: str = "") -> Sample:
    return Sample(kind, label or kind, declare, {"applied_forces": twin})
