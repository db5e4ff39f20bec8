"""Contact: a spring and a damper that act only while a gap is negative."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect, Measure, Pulls, label
from codegen.declare.element_fields import quantity
from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds
from codegen.drawing import shapes
from codegen.elements.forces.scalar_measures import (
    along_scalar,
    distance,
    is_constant,
    same_body,
)
from codegen.elements.registry import element


def gap_between(
    i: Point, j: Point, direction: tuple[sympy.Expr, sympy.Expr] | None, free_length: sympy.Expr
) -> sympy.Expr:
    """The gap g between two points, m.

    Along a direction u fixed in body i it is g = (A_i u)ᵀ (r_j^P - r_i^P) - ℓ0, negative once
    point j has come closer than ℓ0 or gone past; without one it is g = ℓ - ℓ0, as between two
    discs whose radii add up to ℓ0.
    """
    if direction is None:
        return distance(i, j) - free_length
    ux, uy = direction
    size = sympy.sqrt(ux**2 + uy**2)
    ux, uy = ux / size, uy / size
    (x, y), (c, s) = i.body.position, i.body.rotation
    dx, dy = j.x - x, j.y - y  # from the centre: the part of point i along u is constant
    gap: sympy.Expr = (ux * c - uy * s) * dx + (ux * s + uy * c) * dy
    return gap - (ux * i.sx + uy * i.sy + free_length)


def gap_problems(where: str, gap: sympy.Expr, bodies: tuple[Body, ...]) -> list[str]:
    """A gap that never changes or that is no position."""
    if problems := same_body(where, bodies):
        return problems
    if not kinds(gap, Coordinate):
        problems.append(
            f"{where}: the gap {gap} depends on no coordinate and never changes; give two "
            "points of different bodies, or gap= an expression of coordinates."
        )
    return problems + [
        f"{where}: the gap {gap} contains the velocity {v.name}; it is a position."
        for v in kinds(gap, Velocity)
    ]


SIDES = "first", "second"
"""Components of what has two gaps, in their order."""


class GapSprings(Effect):
    """A spring and a damper along each of some gaps g, while g < 0: f = k g + c ġ (Haug 8.4.2).

    The switching is located: g = 0 is an event of a run, and between events every step is smooth.
    The springs have the potential V = k g² / 2 while g < 0; the dampers are forces.
    """

    stiffness: sympy.Expr
    damping: sympy.Expr
    may_pull: bool

    @property
    def gaps(self) -> tuple[sympy.Expr, ...]:
        """The gaps, which only a negative value closes."""
        raise NotImplementedError

    @property
    def gap_unit(self) -> str:
        """Their unit: "m", "rad", or none where it is not known."""
        return "m"

    def potential(self, bodies: tuple[Body, ...]) -> sympy.Expr | None:
        """V of the springs."""
        if not self._conservative or self.stiffness == 0:
            return None
        return sympy.Add(*(_closed(self.stiffness * g**2 / 2, g) for g in self.gaps))

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """The damper along each gap, and a spring that varies."""
        return tuple((g, _closed(f, g)) for g in self.gaps if (f := self._pull(g)) != 0)

    def measures(self, bodies: tuple[Body, ...]) -> tuple[Measure, ...]:
        """Each gap, its rate, the penetration, and the force, positive where it pushes."""
        found: tuple[Measure, ...] = ()
        for side, gap in zip(SIDES if len(self.gaps) > 1 else ("",), self.gaps, strict=True):
            force = -_closed(sympy.Add(*self._push_and_drag(gap)), gap)
            rows = along_scalar(gap, self.gap_unit, force, named="gap")
            rows += (Measure("penetration", "", self.gap_unit, _closed(-gap, gap)),)
            found += tuple(row._replace(component=side) for row in rows)
        return found

    def _pull(self, gap: sympy.Expr) -> sympy.Expr:
        push, drag = self._push_and_drag(gap)
        return drag if self._conservative else push + drag

    def _push_and_drag(self, gap: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
        push = self.stiffness * gap
        drag = self.damping * SPEED
        if not self.may_pull and drag != 0:
            # Where the damper would pull it takes back what the spring pushes, and no more.
            drag = sympy.Piecewise((drag, push + drag < 0), (-push, True))
        return push, drag

    @property
    def _conservative(self) -> bool:
        # A potential may depend on the coordinates of the gap, not on the time.
        return is_constant(self.stiffness) and not any(kinds(g, Time) for g in self.gaps)


def _closed(value: sympy.Expr, gap: sympy.Expr) -> sympy.Expr:
    return sympy.Piecewise((value, gap < 0), (0, True))


@element
class Contact(GapSprings):
    """f = k g + c ġ along the gap g while g < 0, and no force while it is not (Haug 8.4.2).

    The switching is located: g = 0 is an event of a run, and between events every step is smooth.
    The spring has the potential V = k g² / 2 while g < 0; the damper is a force. With damping the
    force jumps where the contact begins, and at its end, where c ġ outweighs k g, it pulls.
    With `may_pull` False it is cut off there: f = min(k g + c ġ, 0). Surfaces that do not stick, a
    tyre on the road or a ball on the ground, need `may_pull` False. A gap that depends on the time
    is a moving wall, whose spring has no potential.
    """

    kind = "contact"
    example = """
        k = model.parameter("k", 1e4, unit="N/m")
        c = model.parameter("c", 20.0, unit="N s/m")
        model.contact("stop", P, Q, stiffness=k, damping=c, free_length=1, direction=(1, 0))
    """
    name: str
    gap: sympy.Expr
    stiffness: sympy.Expr = quantity("N/m", "nonnegative")
    damping: sympy.Expr = quantity("N s/m", "nonnegative")
    on: tuple[Body, ...]
    may_pull: bool = True

    @property
    def gaps(self) -> tuple[sympy.Expr, ...]:
        """The one gap."""
        return (self.gap,)

    def problems(self) -> list[str]:
        """A gap that never changes or that is no position, and a contact that exerts nothing."""
        problems = gap_problems(label(self), self.gap, self.bodies)
        if same_body(label(self), self.bodies):
            return problems
        if self.stiffness == 0 and self.damping == 0:
            problems.append(f"{label(self)}: stiffness and damping are both 0; give one of them.")
        return problems

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """The bodies that touch, and the gap between them."""
        return (shapes.Contact(self.on, gap=self.gap),)
