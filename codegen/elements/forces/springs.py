"""Springs, dampers and actuators between points and between bodies (Haug 6.1), and bushings."""

from typing import ClassVar

import sympy

from codegen.declare.body import Bodies, Body, Point
from codegen.declare.element import Effect, Measure, Measures, Pulls, label
from codegen.declare.element_fields import Conditions, quantity, sign_conditions
from codegen.declare.space_body import SpacePoint
from codegen.declare.symbols import SPEED, rate
from codegen.drawing import shapes
from codegen.elements import scalar_measures as measures
from codegen.elements.registry import element

OTHER = ", and write other characteristics with {}="


Along = tuple[sympy.Expr, sympy.Expr, sympy.Expr, sympy.Expr]
"""A scalar s, V and f of the spring along it, and f of the rest, with `SPEED` for ṡ."""


class Springs(Effect):
    """Springs and dampers along scalars; the springs have a potential where nothing varies."""

    @property
    def along(self) -> list[Along]:
        """The scalars, and what acts along each."""
        raise NotImplementedError

    @property
    def conservative(self) -> bool:
        """Whether the springs have a potential."""
        raise NotImplementedError

    def acting(self, value: sympy.Expr, scalar: sympy.Expr) -> sympy.Expr:
        """What acts, of a value along a scalar."""
        return value

    def potential(self, bodies: Bodies) -> sympy.Expr | None:
        """V of the springs."""
        energy = sympy.Add(*(self.acting(v, s) for s, v, *_ in self.along))
        return energy if self.conservative and energy != 0 else None

    def pulls(self, bodies: Bodies) -> Pulls:
        """The forces of dampers and actuators, and of springs that vary."""
        varies = not self.conservative
        forces = ((s, rest + elastic if varies else rest) for s, _, elastic, rest in self.along)
        return tuple((s, self.acting(f, s)) for s, f in forces if f != 0)


class SpringDamper(Springs):
    """f = F0 + k (s - s0) + c ṡ + F along a scalar s; V exists where k, s0 and F0 are constant."""

    unit: ClassVar[str] = "m"
    """Of s."""
    stiffness: sympy.Expr
    damping: sympy.Expr
    actuator: sympy.Expr
    law: sympy.Expr | None
    preload: sympy.Expr

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """s and s0."""
        raise NotImplementedError

    @property
    def along(self) -> list[Along]:
        """s."""
        (s, free), k, preload = self.scalar, self.stiffness, self.preload
        energy = k * (s - free) ** 2 / 2 + preload * (s - free)
        return [(s, energy, k * (s - free) + preload, self.damping * SPEED + self._active)]

    @property
    def conservative(self) -> bool:
        """Whether k, s0 and F0 are constant."""
        return measures.is_constant(self.stiffness, self.scalar[1], self.preload)

    @property
    def present(self) -> tuple[bool, bool, bool]:
        """Whether it has an elastic part, a damper and an actuator."""
        elastic = self.stiffness != 0 or self.preload != 0
        return elastic, self.damping != 0, self._active != 0

    @property
    def exerts(self) -> sympy.Expr:
        """f, of coordinates and velocities."""
        ((s, _, elastic, rest),) = self.along
        return (elastic + rest).xreplace({SPEED: rate(s)})

    def measures(self, bodies: Bodies) -> Measures:
        """s, its rate, s - s0, and f."""
        ((s, _, elastic, rest),) = self.along
        found = measures.along_scalar(s, self.unit, elastic + rest)
        return (*found, Measure("deflection", "", self.unit, s - self.scalar[1]))

    def problems(self) -> list[str]:
        """A law that exerts nothing."""
        if any(self.present):
            return []
        word = "force" if self.unit == "m" else "torque"
        advice = f"give it a stiffness, a damping, a preload, an actuator or a {word}."
        return [f"{label(self)} does nothing; {advice}"]

    @property
    def _active(self) -> sympy.Expr:
        """F, of the actuator and of a law of the modeller's own."""
        return self.actuator if self.law is None else self.actuator + self.law


@element
class Spring(measures.SpanMeasures, SpringDamper):
    """A spring, a damper or an actuator between two points, or all three in parallel.

    f = k (ℓ - ℓ0) + F0 + c ℓ̇ + F along the line of two points, N, positive in tension.

    F0 is the preload, the force at the length ℓ0: the spring is free of force at ℓ0 - F0/k.
    The elastic part has the potential V = k (ℓ - ℓ0)² / 2 + F0 (ℓ - ℓ0), which equilibrium and the
    balance of energy use; the damper and the actuator are forces, whose power counts as work. If k,
    ℓ0 or F0 varies in a run, the elastic part is such a force too and has no potential.

    At ℓ = 0 the line has no direction. A run that starts there ends as not finite. In a run that
    passes straight through, the force reverses in an instant, which no event locates. Only a spring
    with ℓ0 = 0, without damper and actuator, is smooth there; for a passage along a known line,
    write a contact or a potential along it.
    """

    kind = "spring"
    example = """
        k = model.parameter("k", 200.0, unit="N/m")
        l0 = model.parameter("l_0", 0.8, unit="m")
        c = model.parameter("c", 3.0, unit="N s/m")
        model.spring("strut", P, Q, stiffness=k, free_length=l0, damping=c)
    """
    name: str
    i: Point
    j: Point
    stiffness: sympy.Expr = quantity("N/m", "nonnegative", advice=OTHER.format("force"))
    free_length: sympy.Expr | None = quantity("m", "nonnegative", advice=OTHER.format("force"))
    damping: sympy.Expr = quantity("N s/m", "nonnegative", advice=OTHER.format("force"))
    actuator: sympy.Expr = quantity("N")
    law: sympy.Expr | None = quantity(
        "N", default=None, function_of=measures.distance_and_rate, is_law=True
    )
    preload: sympy.Expr = quantity("N", default=sympy.S.Zero)

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """ℓ and ℓ0."""
        return self.length, sympy.S.Zero if self.free_length is None else self.free_length

    def problems(self) -> list[str]:
        """Two points that keep their distance, a spring without a free length."""
        problems = measures.line_problems(self, self.i, self.j)
        if self.free_length is None and self.present[0]:
            has = "stiffness" if self.stiffness != 0 else "preload"
            problems.append(
                f"{label(self)} has a {has} but no free length; give free_length= in m."
            )
        return problems + super().problems()

    def shapes(self) -> shapes.Shapes:
        """A spring, damper and actuator, those that there are."""
        exerts = self.exerts if isinstance(self.i, SpacePoint) else None
        return (shapes.Spring(self.i, self.j, *self.present, exerts=exerts),)


@element
class TorsionSpring(measures.TurnMeasures, SpringDamper):
    """A torsion spring, a rotary damper or both between two bodies.

    n = k (θ - θ0) + N0 + c θ̇ + N with θ = φ_j - φ_i; n acts on body i, -n on body j.

    N0 is the preload, the torque at the angle θ0. The elastic part has the potential
    V = k (θ - θ0)² / 2 + N0 (θ - θ0); the damper and the actuator are forces. If k, θ0 or N0 varies
    in a run, the elastic part is a force too and has no potential.
    """

    kind = "torsion spring"
    example = """
        k = model.parameter("k", 30.0, unit="N m/rad")
        c = model.parameter("c", 0.4, unit="N m s/rad")
        model.torsion_spring("coil", i, j, stiffness=k, free_angle=pi / 6, damping=c)
    """
    unit = "rad"
    name: str
    i: Body
    j: Body
    stiffness: sympy.Expr = quantity("N m/rad", "nonnegative", advice=OTHER.format("torque"))
    free_angle: sympy.Expr = quantity("rad")
    damping: sympy.Expr = quantity("N m s/rad", "nonnegative", advice=OTHER.format("torque"))
    actuator: sympy.Expr = quantity("N m")
    law: sympy.Expr | None = quantity(
        "N m", default=None, function_of=measures.angle_and_rate, is_law=True
    )
    preload: sympy.Expr = quantity("N m", default=sympy.S.Zero)

    @property
    def scalar(self) -> tuple[sympy.Expr, sympy.Expr]:
        """θ and θ0."""
        return self.angle, self.free_angle

    def problems(self) -> list[str]:
        """A body against itself, and a law that exerts nothing."""
        return super().problems() + SpringDamper.problems(self)

    def shapes(self) -> shapes.Shapes:
        """A torsion spring, damper and actuator, those that there are."""
        return (shapes.SpiralSpring(self.i, self.j, *self.present),)


Triple = tuple[sympy.Expr, sympy.Expr, sympy.Expr]
AXES = (("x", "N/m", "N s/m"), ("y", "N/m", "N s/m"), ("phi", "N m/rad", "N m s/rad"))


@element
class Bushing(Springs):
    """An elastic joint, such as a rubber bushing: springs and dampers in x, y and angle.

    Forces -k s - c ṡ along the displacements s = (A_iᵀ d, φ_j - φ_i - θ0), d = r_j^P - r_i^P.

    The springs have the potential V = Σ k s² / 2; the dampers are forces. The axes turn with body
    i, so a displaced bushing exerts a moment on body i, since s contains φ_i.
    """

    kind = "bushing"
    example = """
        kx, ky = (model.parameter(k, 90.0, unit="N/m") for k in ("k_x", "k_y"))
        cx, cy = (model.parameter(c, 3.0, unit="N s/m") for c in ("c_x", "c_y"))
        model.bushing("rubber", P, Q, stiffness=(kx, ky, 5.0), damping=(cx, cy, 0.2))
    """
    name: str
    i: Point
    j: Point
    stiffness: Triple = quantity(tuple(row[1] for row in AXES))
    damping: Triple = quantity(tuple(row[2] for row in AXES))
    free_angle: sympy.Expr = quantity("rad")

    @property
    def displacements(self) -> Triple:
        """Along x' and y' of body i, m, and about the normal, rad."""
        (x, y), (c, s) = self.i.body.position, self.i.body.rotation
        dx, dy = self.j.x - x, self.j.y - y  # from the centre: point i is fixed in its axes
        angle = measures.relative_angle(self.i.body, self.j.body) - self.free_angle
        return c * dx + s * dy - self.i.sx, c * dy - s * dx - self.i.sy, angle

    @property
    def along(self) -> list[Along]:
        """The displacements."""
        rows = zip(self.stiffness, self.damping, self.displacements, strict=True)
        return [(s, k * s**2 / 2, k * s, c * SPEED) for k, c, s in rows]

    @property
    def conservative(self) -> bool:
        """Whether the springs and the angle at rest are constant."""
        return measures.is_constant(*self.stiffness, self.free_angle)

    def measures(self, bodies: Bodies) -> Measures:
        """The displacements, their rates, and the force and torque on body j."""
        found: Measures = ()
        for (axis, *_), (s, _, elastic, drag) in zip(AXES, self.along, strict=True):
            force, unit = -elastic - drag, "rad" if axis == "phi" else "m"
            found += (
                Measure("deflection", axis, unit, s),
                Measure("rate", axis, f"{unit}/s", SPEED, s),
                Measure("torque", "", "N m", force, s)
                if axis == "phi"
                else Measure("force", f"f{axis}", "N", force, s),
            )
        return found

    def problems(self) -> list[str]:
        """A body against itself, and one that does nothing."""
        problems = measures.angle_problems(self, *self.bodies)
        problems += measures.same_body(label(self), self.bodies)
        if not any((*self.stiffness, *self.damping)):
            problems.append(f"{label(self)}: stiffness and damping are all 0; give at least one.")
        return problems

    def conditions(self) -> Conditions:
        """Springs and dampers that resist."""
        rows = zip(AXES, self.stiffness, self.damping, strict=True)
        return sign_conditions(
            *(
                (f"{word} along {axis}", value, unit)
                for (axis, *units), *values in rows
                for word, value, unit in zip(("stiffness", "damping"), values, units, strict=True)
            )
        )

    def shapes(self) -> shapes.Shapes:
        """A pin of rubber: a spring from point to point, and the axes of its force on body j."""
        i, j = self.i.body, self.j.body
        axes = shapes.Reaction(i, j, self.j.x, self.j.y, *i.rotation)
        return shapes.Spring(self.i, self.j), axes
