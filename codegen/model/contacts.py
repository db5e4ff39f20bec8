"""The effects between surfaces: contact, and friction in joints and on belts."""

from typing import Any

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Constraint, Effect
from codegen.elements.forces.along import rate
from codegen.elements.forces.contact import Contact, gap_between
from codegen.elements.forces.dry_friction import DryFriction
from codegen.elements.forces.friction import JointFriction
from codegen.elements.forces.rigid_contact import RigidContact
from codegen.model.base import Declarations


class Contacts(Declarations):
    """What bodies do to each other where they touch."""

    def contact(
        self,
        name: str,
        i: Point | Body | None = None,
        j: Point | Body | None = None,
        *,
        stiffness: Any = None,
        damping: Any = None,
        free_length: Any = 0,
        direction: tuple[Any, Any] | None = None,
        gap: Any = None,
        may_pull: bool = True,
        restitution: Any = None,
        typical_force: Any = None,
    ) -> Effect:
        """A contact while a gap is closed: by a spring and damper (Haug 8.4.2), or rigid.

        Parameters
        ----------
        i, j
            Points of two bodies (a body means its centre of mass), between which the gap is: along
            `direction`, g = (A_i u)ᵀ (r_j^P - r_i^P) - ℓ0; without one, g = ℓ - ℓ0.
        stiffness, damping
            k in N/m and c in N s/m of f = k g + c ġ, which acts while g < 0.
        free_length
            ℓ0 in m.
        direction
            u in the frame of body `i`, of any length.
        gap
            Instead of points: g itself, in m, an expression of coordinates, parameters and t.
        may_pull
            False cuts the damper off where it would hold the bodies together.
        restitution
            Instead of stiffness and damping: e of a rigid contact, from 0 to 1.
        typical_force
            Of a rigid contact: a force of the size of its reactions, N; None: the weight of the
            bodies of the scene.
        """
        where = f"contact '{name}'"
        g, bodies = self._gap(name, i, j, free_length, direction, gap)
        soft = stiffness is not None or damping is not None
        if restitution is None:
            if stiffness is None:
                self._note(
                    f"{where} has neither stiffness= nor restitution=; give stiffness= for one "
                    "that yields, or restitution= for one that is rigid."
                )
                stiffness = 1
            if typical_force is not None:
                self._note(f"{where}: typical_force= is a rigid contact's; leave it out.")
            stiff = self._read.value(stiffness, "N/m", f"stiffness of {where}")
            damp = self._read.value(
                0 if damping is None else damping, "N s/m", f"damping of {where}"
            )
            return self._effect(Contact(name, g, stiff, damp, bodies, bool(may_pull)))
        if soft:
            self._note(
                f"{where} has both restitution= and stiffness= or damping=; give restitution= for "
                "a rigid contact, or the others for one that yields."
            )
        if not may_pull:
            self._note(f"{where}: a rigid contact never pulls; leave may_pull out.")
        e = self._ruled(self._read.value(restitution, "", f"restitution of {where}"), "nonnegative")
        scale = None
        if typical_force is not None:
            read = self._read.value(typical_force, "N", f"typical force of {where}")
            scale = self._ruled(read, "positive")
        return self._effect(RigidContact(name, g, e, bodies, scale))

    def friction(
        self,
        name: str,
        joint: Constraint,
        coefficient: Any,
        creep: Any = None,
        radius: Any = None,
        length: Any = None,
        static: Any = None,
    ) -> Effect:
        """Coulomb friction in a joint, from the joint's own reaction.

        Parameters
        ----------
        joint
            A revolute, translational or revolute-translational joint.
        coefficient
            μ.
        creep
            For a law made smooth at rest: the speed, in m/s or, in a revolute joint, rad/s, below
            which the joint creeps. Without it the joint sticks.
        radius
            Of a revolute joint's pin, m.
        length
            Of a translational joint's bearing, m: its moment then presses at both ends.
        static
            μ_s of a joint that sticks, at least μ; None: μ.
        """
        where = f"friction '{name}'"
        pin = getattr(joint, "kind", "") == "revolute"
        mu, rest, speed = self._coefficients(
            where, coefficient, static, creep, "rad/s" if pin else "m/s"
        )
        pin_radius, bearing = (
            None
            if size is None
            else self._ruled(self._read.value(size, "m", f"{word} of {where}"), "positive")
            for size, word in ((radius, "radius"), (length, "length"))
        )
        return self._effect(JointFriction(name, joint, mu, speed, pin_radius, bearing, rest))

    def dry_friction(
        self,
        name: str,
        i: Point | Body | None = None,
        j: Point | Body | None = None,
        *,
        coefficient: Any,
        normal: Any,
        axis: tuple[Any, Any] = (1, 0),
        slip: Any = None,
        static: Any = None,
        creep: Any = None,
    ) -> Effect:
        """Coulomb friction under a normal force that is known: a block on a belt, a brake.

        Parameters
        ----------
        i, j
            Points of two bodies (a body means its centre of mass): the point of `j` slides along
            `axis` of body `i`, ṡ = d/dt (A_i u)ᵀ (r_j^P - r_i^P).
        coefficient
            μ.
        normal
            N in newton, an expression of coordinates, velocities, t and parameters.
        axis
            u in the frame of body `i`, of any length.
        slip
            Instead of points: ṡ itself, in m/s, linear in velocities: ``block.vx - speed``.
        static
            μ_s of a friction that sticks, at least μ; None: μ.
        creep
            For a law made smooth at rest: the speed in m/s below which it creeps.
        """
        where = f"dry friction '{name}'"
        mu, rest, speed = self._coefficients(where, coefficient, static, creep, "m/s")
        load = self._ruled(self._read.value(normal, "N", f"normal of {where}"), "nonnegative")
        if slip is not None:
            if i is not None or j is not None:
                self._note(f"{where} has both slip= and points; give one of them.")
            s = self._read.value(slip, "m/s", f"slip of {where}")
            bodies = self._bodies_in(s)
        else:
            if i is None or j is None:
                self._note(f"{where} has no slip; give two points, or slip= a velocity.")
            ends = self._pair(name, *(self.ground if end is None else end for end in (i, j)))
            along = self._direction(where, "axis", axis) or (sympy.S.One, sympy.S.Zero)
            s = rate(gap_between(*ends, along, sympy.S.Zero))
            bodies = (ends[0].body, ends[1].body)
        return self._effect(DryFriction(name, s, load, mu, bodies, rest, speed))

    def _coefficients(
        self, where: str, coefficient: Any, static: Any, creep: Any, unit: str
    ) -> tuple[sympy.Expr, sympy.Expr | None, sympy.Expr | None]:
        """μ, μ_s and the creep speed."""
        mu = self._read.value(coefficient, "", f"coefficient of {where}")
        self._ruled(mu, "nonnegative" if static is None else "positive")
        rest, speed = (
            None if value is None else self._ruled(self._read.value(value, u, word), "positive")
            for value, u, word in (
                (static, "", f"static coefficient of {where}"),
                (creep, unit, f"creep speed of {where}"),
            )
        )
        return mu, rest, speed

    def _direction(self, where: str, word: str, given: Any) -> tuple[sympy.Expr, sympy.Expr] | None:
        """Two components that are not both zero."""
        ux, uy = self._read.pair(given, "", f"{word} of {where}")
        if ux == 0 and uy == 0:
            self._note(f"{where}: the {word} (0, 0) points nowhere; give another.")
            return None
        return ux, uy

    def _gap(
        self, name: str, i: Any, j: Any, free_length: Any, direction: Any, gap: Any
    ) -> tuple[sympy.Expr, tuple[Body, ...]]:
        """g of a contact, and the bodies that it is between."""
        where = f"contact '{name}'"
        if gap is not None:
            if i is not None or j is not None or direction is not None:
                self._note(f"{where} has both gap= and points; give one of them.")
            g = self._read.value(gap, "m", f"gap of {where}")
            free = self._read.value(free_length, "m", f"free length of {where}")
            return g - free, self._bodies_in(g)
        if i is None or j is None:
            self._note(f"{where} has no gap; give two points, or gap= an expression.")
        ends = self._pair(name, *(self.ground if end is None else end for end in (i, j)))
        along = None if direction is None else self._direction(where, "direction", direction)
        free = self._read.value(free_length, "m", f"free length of {where}")
        return gap_between(*ends, along, free), (ends[0].body, ends[1].body)
