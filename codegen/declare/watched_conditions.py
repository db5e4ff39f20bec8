"""Conditions that a run watches: where one begins to hold, something changes for good.

A run ends, a value is sampled, or a joint that acts for a part of a run is released or engages.
"""

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


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint that comes and goes.

    Attributes
    ----------
    joint
        Its name.
    acts_first
        Whether it acts at the start of a run.
    released, engaged
        1 where the condition holds under which it stops or begins to act, else 0; None: never.
    """

    joint: str
    acts_first: bool
    released: sympy.Expr | None
    engaged: sympy.Expr | None

    def watched(self, acts: bool, scene: str) -> WatchedCondition | None:
        """What a run watches while the joint acts, or not; `scene` is the one that follows."""
        indicator = self.released if acts else self.engaged
        if indicator is None:
            return None
        action: Action = "release" if acts else "engage"
        return WatchedCondition(self.joint, indicator, action, self.joint, scene)
