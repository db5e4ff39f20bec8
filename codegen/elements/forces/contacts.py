"""Contacts along a gap, by a spring and a damper or rigid, and the stops of a joint."""

import sympy

from codegen.declare.body import Bodies, Point
from codegen.declare.element import Effect, Measure, Measures, Pulls, Reported, Rigid, label
from codegen.declare.element_fields import Condition, Conditions, hold_conditions, quantity
from codegen.declare.symbols import SPEED, Coordinate, Time, Velocity, kinds, side
from codegen.drawing import shapes
from codegen.elements.forces.springs import Along, Springs
from codegen.elements.registry import element
from codegen.elements.scalar_measures import (
    WORDS,
    along_scalar,
    distance,
    force_unit,
    is_constant,
    same_body,
)
from codegen.tables.piecewise_function import closed


def gap_between(
    i: Point, j: Point, direction: tuple[sympy.Expr, ...] | None, free_length: sympy.Expr
) -> sympy.Expr:
    """The gap g between two points, m, in the plane or in space.

    Along a direction u fixed in body i it is g = (A_i u)ᵀ (r_j^P - r_i^P) - ℓ0, negative once
    point j has come closer than ℓ0 or gone past; without one it is g = ℓ - ℓ0, as between two
    discs or spheres whose radii add up to ℓ0.
    """
    if direction is None:
        return distance(i, j) - free_length
    size = sympy.sqrt(sympy.Add(*(u**2 for u in direction)))
    unit = [u / size for u in direction]
    tip = type(i)(i.body, *unit).position
    rows = zip(i.body.position, tip, j.position, strict=True)
    # From the centre: the part of point i along u is constant.
    gap = sympy.Add(*((end - r) * (other - r) for r, end, other in rows))
    return gap - sympy.Add(*(u * s for u, s in zip(unit, i.place, strict=True)), free_length)


def gap_problems(where: str, gap: sympy.Expr, bodies: Bodies) -> list[str]:
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


def kink_problems(where: str, gaps: tuple[sympy.Expr, ...]) -> list[str]:
    """Gaps with kinks in coordinates, at which the rate jumps that says when a damper lets go."""
    pieces = sympy.Abs, sympy.Max, sympy.Min, sympy.sign, sympy.Heaviside, sympy.Piecewise
    found = sorted({str(f) for g in gaps for f in g.atoms(*pieces) if kinds(f, Coordinate)})
    return [
        f"{where}: the damper lets go where the spring's force and its own, which is that of the "
        f"gap's rate, add up to 0, and {piece} makes that rate one of pieces in coordinates; write "
        "the gap as one smooth function, or give no damping, or in a contact may_pull=True."
        for piece in found[:1]
    ]


SIDES = "first", "second"
"""Components of what has two gaps, in their order."""


class GapSprings(Springs):
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

    @property
    def conservative(self) -> bool:
        """Whether the springs are constant, and the gaps no functions of the time."""
        return is_constant(self.stiffness) and not any(kinds(g, Time) for g in self.gaps)

    @property
    def along(self) -> list[Along]:
        """The gaps; where a damper must not pull, it takes back what the spring pushes."""
        rows: list[Along] = []
        for gap in self.gaps:
            push, drag = self.stiffness * gap, self.damping * SPEED
            if not self.may_pull and drag != 0:
                drag = sympy.Piecewise((drag, push + drag < 0), (-push, True))
            rows.append((gap, self.stiffness * gap**2 / 2, push, drag))
        return rows

    def acting(self, value: sympy.Expr, scalar: sympy.Expr) -> sympy.Expr:
        """The value while the gap is closed."""
        return sympy.Piecewise((value, scalar < 0), (0, True))

    def measures(self, bodies: Bodies) -> Measures:
        """Each gap, its rate, the penetration, and the force, positive where it pushes."""
        found: Measures = ()
        sides = SIDES if len(self.gaps) > 1 else ("",)
        for which, (gap, _, push, drag) in zip(sides, self.along, strict=True):
            force = -self.acting(push + drag, gap)
            rows = along_scalar(gap, self.gap_unit, force, named="gap")
            rows += (Measure("penetration", "", self.gap_unit, self.acting(-gap, gap)),)
            found += tuple(row._replace(component=which) for row in rows)
        return found


@element
class Contact(GapSprings):
    """Two bodies touch and push each other elastically while the gap between them is closed.

    f = k g + c ġ along the gap g while g < 0, and no force otherwise (Haug 8.4.2).

    The switching is located: g = 0 is an event of a run, and between events every step is smooth.
    The spring has the potential V = k g² / 2 while g < 0; the damper is a force. With damping the
    force jumps where the contact begins; near its end c ġ exceeds -k g, and the force pulls.
    `may_pull=False` cuts this off: f = min(k g + c ġ, 0). Surfaces that do not stick, a tyre on the
    road or a ball on the ground, need `may_pull=False`. A gap that depends on the time is a moving
    wall, whose spring has no potential.
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
    on: Bodies
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
        if self.damping != 0 and not self.may_pull:
            problems += kink_problems(label(self), self.gaps)
        return problems

    def shapes(self) -> shapes.Shapes:
        """The bodies that touch, and the gap between them."""
        return (shapes.Contact(self.on, gap=self.gap),)


@element
class Stop(GapSprings):
    """Limit stops: a spring and a damper keep a coordinate between two limits.

    f = k (s - s_limit) + c ṡ where a coordinate s is below its lower or above its upper limit.

    s is the angle of a revolute joint, the travel of a sliding one, or any expression of
    coordinates; k and c are along s. A stop never holds s back: a damper that would do so is cut
    off. Contact and its end are events of a run. The springs have the potential k (s - s_limit)²/2.
    With two limits, a result has the components "first" (lower limit) and "second" (upper limit).
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
    on: Bodies
    may_pull = False

    @property
    def gaps(self) -> tuple[sympy.Expr, ...]:
        """What is left before each stop."""
        below = () if self.lower is None else (closed(self.scalar - self.lower),)
        return below if self.upper is None else (*below, closed(self.upper - self.scalar))

    @property
    def gap_of_both(self) -> sympy.Expr:
        """A gap that closes at each limit with the slope ±1, smooth in between."""
        if self.lower is None or self.upper is None:
            return self.gaps[0] if self.gaps else self.scalar
        return sympy.Mul(*self.gaps) / closed(self.upper - self.lower)

    @property
    def gap_unit(self) -> str:
        """That of the coordinate."""
        return self.unit

    def problems(self) -> list[str]:
        """No limit at all, or one of what is no position."""
        where, s, problems = label(self), self.scalar, []
        if not self.gaps:
            problems.append(f"{where} has no limit; give lower=, upper= or both.")
        if not kinds(s, Coordinate):
            problems.append(
                f"{where}: {s} depends on no coordinate and never reaches a limit; give a joint, "
                "or an expression of coordinates."
            )
        if self.damping != 0:
            problems += kink_problems(where, self.gaps)
        return problems + [
            f"{where}: {s} contains the velocity {v.name}; a stop limits a position."
            for v in kinds(s, Velocity)
        ]

    def conditions(self) -> Conditions:
        """The upper stop above the lower one."""
        if self.lower is None or self.upper is None:
            return ()
        text = "the upper limit {1:g} is not above the lower one, {2:g}; exchange them."
        numbers = self.upper - self.lower, self.upper, self.lower
        return (Condition(text, numbers, open=True),)

    def shapes(self) -> shapes.Shapes:
        """The bodies that touch at each limit; an angle has no place where it stops."""
        if not self.unit:
            return (shapes.Contact(self.on),)
        forces = SIDES if len(self.gaps) > 1 else (WORDS[self.unit][1],)
        return tuple(
            shapes.Contact(self.on, gap=gap, force=force, is_stop=True)
            for force, gap in zip(forces, self.gaps, strict=True)
        )


# formula: m/s²; with the masses the typical force of a contact, unless one is declared
GRAVITY = 9.81


@element
class RigidContact(Effect):
    """Two rigid bodies touch, or one meets a stop: they strike, rebound, rest and part.

    g ≥ 0, F ≥ 0, F g = 0: a reaction F acts only while the gap g is closed.

    F acts along the gap as the force of a contact does, Q = F g_q, and keeps the gap closed, g̈ =
    0; where F would have to pull, the bodies part. A gap that closes with the speed ġ⁻ < 0 is an
    impact: velocities jump by M⁻¹ g_qᵀ times an impulse, so that ġ⁺ = -e ġ⁻ (Newton's law of
    restitution), while the joints hold.

    In mode 1 the gap is open and nothing acts. In mode 0 the kernels exert the reaction F0, a
    typical force. Accelerations are linear in the reaction, so that a run finds, and reports, the
    multiple of F0 that keeps the gap closed.

    The gap must be smooth. A gap that depends on the time is a moving wall, which does work. e lies
    between 0, no rebound, and 1, no loss of energy.
    """

    kind = "rigid contact"
    example = """
        e = model.parameter("e", 0.5)
        model.contact("stop", P, Q, restitution=e, free_length=1, direction=(1, 0))
    """
    name: str
    gap: sympy.Expr
    restitution: sympy.Expr = quantity(binds="nonnegative")
    on: Bodies
    unit: str = "m"  # of the gap: "m", "rad", or none where it is not known
    limits: tuple[sympy.Expr, ...] = ()  # of a stop: what is left before each of its limits
    typical_force: sympy.Expr | None = quantity(force_unit, binds="positive", default=None)

    def pulls(self, bodies: Bodies) -> Pulls:
        """The reaction F0, where the gap is not open: it pushes."""
        return ((self.gap, -side(self.name) * self._scale(bodies)),)

    def hold(self, bodies: Bodies) -> Rigid:
        """The gap stays closed until the reaction would pull."""
        return Rigid(self.gap, self.restitution, self._scale(bodies))

    def reported(self, bodies: Bodies) -> Reported:
        """The reaction, positive: it pushes."""
        _, exerted, unit = WORDS[self.unit]
        return ((exerted, unit, side(self.name) * self._scale(bodies)),)

    def measures(self, bodies: Bodies) -> Measures:
        """The gap and its rate; the force is reported."""
        gap, rate, _ = along_scalar(self.gap, self.unit, sympy.S.Zero, named="gap")
        return gap, rate

    def problems(self) -> list[str]:
        """A gap that is none, and numbers that no impact has."""
        where = label(self)
        problems = gap_problems(where, self.gap, self.bodies)
        scale = sympy.S.One if self.typical_force is None else self.typical_force
        for condition in hold_conditions(Rigid(self.gap, self.restitution, scale)):
            problems += condition.problems(where, {}) if condition.known else ()
        return problems

    def _scale(self, bodies: Bodies) -> sympy.Expr:
        if self.typical_force is not None:
            return self.typical_force
        masses = [b.mass for b in bodies if b.mass is not None and is_constant(b.mass)]
        return sympy.Float(GRAVITY) * (sympy.Add(*masses) if masses else sympy.S.One)

    def shapes(self) -> shapes.Shapes:
        """The bodies that touch, and the gap between them, or those of a stop."""
        if not self.unit:
            return (shapes.Contact(self.on),)
        force, is_stop, gaps = WORDS[self.unit][1], bool(self.limits), self.limits or (self.gap,)
        return tuple(shapes.Contact(self.on, None, gap, force, is_stop) for gap in gaps)
