"""States beside those of bodies, and conditions that a run watches.

A state y is the rate of a coordinate of its own, its integral, with the mass 1 and no constraint
but laws of masses: y's rate is a force on it. So every method, both formulations, exact
derivatives, events and results take it as they take a velocity. It has no place, weight or energy.

Where a watched condition begins to hold, something changes for good: a run ends, a value is
sampled, or a joint that acts for a part of a run is released or engages.
"""

from dataclasses import dataclass
from typing import Any, Literal

import sympy

from codegen.declare.body import Bodies, Loads
from codegen.declare.element import Effect
from codegen.declare.symbols import Coordinate, Velocity, own_coordinate

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


STATE, SAMPLED = "state", "sampled value"  # kinds of what determines a state


@dataclass(frozen=True)
class Clock:
    """The instants of samples, k every, s, k = 0, 1, 2 …, and the time until one acts, s."""

    every: sympy.Expr
    delay: sympy.Expr


@dataclass(frozen=True, eq=False)
class Trigger:
    """What is 1 where a condition holds that renews a value once it begins to, and the value."""

    indicator: sympy.Expr
    sample: sympy.Expr


@dataclass(frozen=True, eq=False)
class State:
    """A variable of first order, ẏ = rate, or one that keeps its value between samples.

    Attributes
    ----------
    name
        The modeller's name, an identifier.
    unit
        SI unit of y.
    start
        Its value at the start of a run.
    nominal
        Its typical size, which absolute tolerances are relative to, in `unit`.
    rate
        ẏ, in `unit` per second; 0 between samples.
    clock, sample
        When the value is renewed, and by which expression; None for a state of first order, and
        an expression for a value that a run brings.
    triggers
        The conditions that renew it, of a latch.
    given
        Whether its rate, clock or triggers are declared.
    """

    name: str
    unit: str
    start: float
    nominal: float
    rate: sympy.Expr = sympy.S.Zero
    clock: Clock | None = None
    sample: sympy.Expr | None = None
    triggers: tuple[Trigger, ...] = ()
    given: bool = False
    integral = own_coordinate("integral", "The integral of y, the coordinate whose rate y is.")

    @property
    def symbol(self) -> Velocity:
        """y in expressions."""
        return self.integral.rate

    @property
    def effect(self) -> "StateRate":
        """What changes it, as an effect on its integral."""
        return StateRate(self.name, self)

    @property
    def expressions(self) -> tuple[sympy.Expr, ...]:
        """All that determines it."""
        clock = (self.clock.every, self.clock.delay) if self.clock else ()
        renewed = (e for trigger in self.triggers for e in (trigger.indicator, trigger.sample))
        return tuple(e for e in (self.rate, self.sample, *clock, *renewed) if e is not None)

    @property
    def conditions(self) -> tuple[WatchedCondition, ...]:
        """The conditions that renew it, as effects."""
        return tuple(
            WatchedCondition(self.name, trigger.indicator, "sample", self.name)
            for trigger in self.triggers
        )


@dataclass(frozen=True, eq=False)
class StateRate(Effect):
    """The rate of a state as a force on its integral, which does no work."""

    kind = STATE
    name: str
    state: State

    def forces(self, bodies: Bodies) -> Loads:
        """ẏ on the integral of y."""
        return {self.state.integral: self.state.rate}


def states_in(*values: Any) -> frozenset[str]:
    """Names of the states in expressions, also of those whose integrals are."""
    symbols = (s for e in values for s in e.free_symbols if isinstance(s, Coordinate | Velocity))
    places = (s.coordinate if isinstance(s, Velocity) else s for s in symbols)
    return frozenset(q.owner for q in places if q.letter == "integral")
