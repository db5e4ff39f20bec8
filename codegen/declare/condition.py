"""Conditions that a run watches: where one begins to hold, something changes for good."""

from dataclasses import dataclass
from typing import Literal

import sympy

from codegen.declare.element import Effect

Action = Literal["until", "sample", "release", "engage"]
WATCHED = "condition"  # kind of a condition that is watched


@dataclass(frozen=True, eq=False)
class WatchedCondition(Effect):
    """A condition as an effect that exerts nothing: it brings switching functions.

    Attributes
    ----------
    name
        The modeller's name of what it does.
    indicator
        1 where it holds, else 0, by pieces of t, q, q̇, states and parameters.
    action
        What follows where it begins to hold: the run ends, a value is sampled, a joint is released
        or engaged.
    target, scene
        Name of the value or joint; of the scene in which a run goes on with other joints.
    """

    kind = WATCHED
    name: str
    indicator: sympy.Expr
    action: Action
    target: str = ""
    scene: str = ""
