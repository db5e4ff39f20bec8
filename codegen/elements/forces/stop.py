"""Stops: springs with dampers that limit a coordinate."""

import sympy

from codegen.declare.body import Body
from codegen.declare.element import label
from codegen.declare.element_conditions import Condition
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.drawing import shapes
from codegen.elements.forces.scalar_measures import force_unit
from codegen.elements.forces.spring_damper_contact import SIDES, GapSprings
from codegen.elements.registry import element


@element
class Stop(GapSprings):
    """f = k (s - s_limit) + c ṡ where a coordinate s is below its lower or above its upper limit.

    s is the angle of a revolute joint, the travel of a sliding one, or any expression of
    coordinates; k and c are along s. A stop never holds s back: where its damper would, it is cut
    off. Contact and its end are events of a run. The springs have the potential k (s - s_limit)²/2.
    """

    kind = "stop"
    example = """
        k = model.parameter("k", 500.0, unit="N m/rad")
        pin = model.revolute("pin", P, Q)
        model.stop("limit", pin, lower=-pi / 3, upper=pi / 2, stiffness=k)
    """
    name: str
    scalar: sympy.Expr
    unit: str
    lower: sympy.Expr | None = quantity(lambda of: of.unit)
    upper: sympy.Expr | None = quantity(lambda of: of.unit)
    stiffness: sympy.Expr = quantity(
        lambda of: of.unit and f"{force_unit(of)}/{of.unit}", "positive", binds="positive",
        advice=", or restitution= for a stop that does not yield",
    )  # fmt: skip
    damping: sympy.Expr = quantity(
        lambda of: of.unit and f"{force_unit(of)} s/{of.unit}", "nonnegative"
    )
    on: tuple[Body, ...]
    may_pull = False

    @property
    def gaps(self) -> tuple[sympy.Expr, ...]:
        """What is left before each stop."""
        below = () if self.lower is None else (self.scalar - self.lower,)
        return below if self.upper is None else (*below, self.upper - self.scalar)

    @property
    def gap_unit(self) -> str:
        """That of the coordinate."""
        return self.unit

    def problems(self) -> list[str]:
        """No limit at all, or one of what is no position."""
        return stop_problems(label(self), self.scalar, self.lower, self.upper)

    def conditions(self) -> tuple[Condition, ...]:
        """The upper stop above the lower one."""
        return limit_conditions(self.lower, self.upper)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The bodies that touch at each limit; an angle has no place where it stops."""
        if self.unit != "m":
            return (shapes.Contact(self.on),)
        forces = SIDES if len(self.gaps) > 1 else ("force",)  # components of the force in N
        return tuple(
            shapes.Contact(self.on, gap=gap, force=force, is_stop=True)
            for force, gap in zip(forces, self.gaps, strict=True)
        )


def stop_problems(
    where: str, scalar: sympy.Expr, lower: sympy.Expr | None, upper: sympy.Expr | None
) -> list[str]:
    """No limit at all, or a limit of what is no position."""
    problems = []
    if lower is None and upper is None:
        problems.append(f"{where} has no limit; give lower=, upper= or both.")
    if not kinds(scalar, Coordinate):
        problems.append(
            f"{where}: {scalar} depends on no coordinate and never reaches a limit; give a joint, "
            "or an expression of coordinates."
        )
    return problems + [
        f"{where}: {scalar} contains the velocity {v.name}; a stop limits a position."
        for v in kinds(scalar, Velocity)
    ]


def limit_conditions(lower: sympy.Expr | None, upper: sympy.Expr | None) -> tuple[Condition, ...]:
    """An upper limit above the lower one."""
    if lower is None or upper is None:
        return ()
    text = "the upper limit {1:g} is not above the lower one, {2:g}; exchange them."
    return (Condition(text, (upper - lower, upper, lower), open=True),)
