"""Joints that act for a part of a run: where they are released, and where they engage."""

from dataclasses import dataclass

import sympy

from codegen.declare.condition import Action, WatchedCondition


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
