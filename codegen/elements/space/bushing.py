"""Bushings in space: springs and dampers along and about three axes, coupled as one likes."""

from itertools import combinations

import sympy

from codegen.declare.body import Bodies
from codegen.declare.element import Effect, Measure, Measures, Pulls, label
from codegen.declare.element_fields import Conditions, quantity, sign_conditions
from codegen.declare.rotation_entries import RotationVectorEntry
from codegen.declare.space_body import SpacePoint
from codegen.declare.symbols import SPEED
from codegen.drawing.shapes import Shapes
from codegen.drawing.space_shapes import SpaceJoint
from codegen.elements.registry import element
from codegen.elements.scalar_measures import is_constant, same_body

ALONG = ("x", "y", "z", "rx", "ry", "rz")
EXERTED = ("fx", "fy", "fz", "tx", "ty", "tz")
TIMES = {"stiffness": "", "damping": " s"}
"""What stands between the units of the force and of the displacement of an entry."""


def entry_unit(row: int, column: int, time: str) -> str:
    """The unit of an entry of K, or of C with its time."""
    if (row < 3) is not (column < 3):
        return f"N{time}"
    return f"N{time}/m" if row < 3 else f"N m{time}/rad"


@element(space=True)
class BushingInSpace(Effect):
    """An elastic joint, such as a rubber bushing: springs and dampers along and about three axes.

    f = K z + F0 + C ż along the displacements z = (s, θ) of body j against body i: they have the
    virtual work -fᵀ δz.

    B are the axes of the bushing in body i. s = Bᵀ A_iᵀ d are the components of d, and Bᵀ θ those
    of the rotation vector by which body j has turned against body i since the drawing: its length
    is the angle χ, its direction the axis. This is exact for all angles below half a turn, large or
    small: a turn about one axis, to which K couples no other, has the torque k χ. K and C are
    symmetric, 6 × 6. The springs have the potential V = zᵀ K z / 2 + F0ᵀ z; the torque on the
    bodies is that which follows from it, also where the axis of rotation changes, so that springs
    neither bring nor take energy. The dampers take żᵀ C ż.

    A result has z, ż and -f: the force on body j at its point along the axes in body i, and the
    torques along θ. These are the components of the torque where the axis of rotation is fixed, and
    differ from them by parts θ × τ / 2 and smaller ones where it is not. At χ = 180° θ changes its
    sign, which no event locates: a bushing is for less.
    """

    kind = "bushing in space"
    name: str
    i: SpacePoint
    j: SpacePoint
    axes: sympy.ImmutableMatrix  # B
    drawn: tuple[sympy.Expr, ...]  # Euler parameters of body i in body j, at the drawing
    stiffness: sympy.ImmutableMatrix
    damping: sympy.ImmutableMatrix
    preload: tuple[sympy.Expr, ...] = quantity(("N",) * 3 + ("N m",) * 3)

    @property
    def displacements(self) -> sympy.Matrix:
        """s, m, and Bᵀ θ, rad."""
        i, j = self.i.body, self.j.body
        away = sympy.Matrix(self.j.position) - sympy.Matrix(i.position)
        s = i.A.T * away - sympy.Matrix(self.i.place)  # from the centre: point i is fixed
        theta = [RotationVectorEntry(k, *i.p, *j.p, *self.drawn) for k in range(3)]
        return sympy.Matrix([*(self.axes.T * s), *(self.axes.T * sympy.Matrix(theta))])

    @property
    def elastic(self) -> sympy.Matrix:
        """K z + F0."""
        return self.stiffness * self.displacements + sympy.Matrix(self.preload)

    @property
    def conservative(self) -> bool:
        """Whether the springs have a potential."""
        return is_constant(*self.stiffness, *self.preload)

    def potential(self, bodies: Bodies) -> sympy.Expr | None:
        """V."""
        z, k, f = self.displacements, self.stiffness.todok(), sympy.Matrix(self.preload)
        energy = z.dot(f) + sympy.Add(*(z[a] * z[b] * (x / 2) for (a, b), x in k.items()))
        return energy if self.conservative and energy != 0 else None

    def pulls(self, bodies: Bodies) -> Pulls:
        """The forces of springs that vary, and of dampers.

        2 C_ab ż_a ż_b = C_ab ((ż_a + ż_b)² - ż_a² - ż_b²): what couples two displacements acts
        along their sum.
        """
        z, c = self.displacements, self.damping
        found = [] if self.conservative else [*zip(z, self.elastic, strict=True)]
        found += [(z[a], (2 * c[a, a] - sympy.Add(*c[a, :])) * SPEED) for a in range(6)]
        pairs = combinations(range(6), 2)
        found += [(z[a] + z[b], c[a, b] * SPEED) for a, b in pairs]
        return tuple((s, f) for s, f in found if f != 0)

    def measures(self, bodies: Bodies) -> Measures:
        """z, ż, and -f."""
        z, c, elastic = self.displacements, self.damping, self.elastic
        found: Measures = ()
        for k, axis in enumerate(ALONG):
            unit, word, exerted = ("m", "force", "N") if k < 3 else ("rad", "torque", "N m")
            alone = not any(c[k, a] for a in range(6) if a != k)
            along, drag = (z[k], c[k, k] * SPEED) if alone else (z.dot(c[k, :]), SPEED)
            found += (
                Measure("deflection", axis, unit, z[k]),
                Measure("rate", axis, f"{unit}/s", SPEED, z[k]),
                Measure(word, EXERTED[k], exerted, -elastic[k] - drag, along),
            )
        return found

    def problems(self) -> list[str]:
        """A body against itself, dampers that vary and couple, and a bushing that does nothing."""
        problems, c = same_body(label(self), self.bodies), self.damping
        if not any((*self.stiffness, *c, *self.preload)):
            problems.append(f"{label(self)}: stiffness and damping are all 0; give at least one.")
        if not c.is_diagonal() and not is_constant(*c):
            problems.append(
                f"{label(self)}: its damping varies and couples displacements; give a matrix of "
                "numbers and parameters, or six expressions."
            )
        return problems

    def conditions(self) -> Conditions:
        """Springs and dampers that resist."""
        return sign_conditions(
            *(
                (f"{word} along {axis}", getattr(self, word)[k, k], entry_unit(k, k, time))
                for word, time in TIMES.items()
                for k, axis in enumerate(ALONG)
            )
        )

    def shapes(self) -> Shapes:
        """A block of rubber."""
        return (SpaceJoint(self.i, self.j, "clamp"),)
