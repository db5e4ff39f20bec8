"""What limits the motion of a joint: stops, and the clearance of a bearing."""

from typing import Any

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.elements.forces.clearance_joint import ClearanceJoint
from codegen.elements.forces.joint_coordinate import JOINTS, joint_coordinate
from codegen.elements.forces.rigid_contact import RigidContact
from codegen.elements.forces.scalar_measures import unit_of
from codegen.elements.forces.stop import Stop, limit_conditions, stop_problems
from codegen.model.base import Declarations, Place
from codegen.readers.values import shown


class Limits(Declarations):
    """Stops and clearances of a declaration."""

    def stop(
        self, name: str, of: Constraint | Any, lower: Any = None, upper: Any = None, *,
        stiffness: Any = None, damping: Any = None, restitution: Any = None,
        typical_force: Any = None,
    ) -> Effect:  # fmt: skip
        """Stops limit the coordinate of a joint: by a spring and a damper each, or rigid.

        Parameters
        ----------
        of
            A revolute joint, whose coordinate s is φ_j - φ_i, rad; a translational or
            revolute-translational joint, whose s is the travel of point j from point i along the
            axis, m; or s itself, an expression of coordinates and parameters.
        lower, upper
            The limits of s, of which one may be left out.
        stiffness, damping
            k and c of f = k (s - s_limit) + c ṡ beyond a limit, N/m and N s/m along a travel,
            N m/rad and N m s/rad about an angle; f never holds s back.
        restitution
            Instead of stiffness and damping: e of stops that do not yield, from 0 to 1. They are a
            rigid contact, whose gap with both limits is (s - lower) (upper - s)/(upper - lower).
        typical_force
            Of rigid stops: a force of the size of their reactions, N or N m; None: the weight of
            the bodies of the scene, in N.
        """
        where = f"stop '{name}'"
        s, unit, bodies = self._limited(where, of)
        low, high = (
            self._optional(limit, unit, f"{word} limit of {where}")
            for word, limit in (("lower", lower), ("upper", upper))
        )
        force = "N m" if unit == "rad" else "N"
        if restitution is None:
            if stiffness is None:
                self._note(
                    f"{where} has neither stiffness= nor restitution=; give stiffness= for one "
                    "that yields, or restitution= for one that is rigid."
                )
            if typical_force is not None:
                self._note(f"{where}: typical_force= is a rigid stop's; leave it out.")
            per = f"/{unit}" if unit else ""
            k = self._value(1 if stiffness is None else stiffness, unit and force + per,
                            f"stiffness of {where}", "positive")  # fmt: skip
            rate = "N m s/rad" if unit == "rad" else "N s/m"
            c = self._value(0 if damping is None else damping, unit and rate, f"damping of {where}")
            return self._declare(Stop(name, s, low, high, k, c, bodies, unit))
        if stiffness is not None or damping is not None:
            self._note(
                f"{where} has both restitution= and stiffness= or damping=; give restitution= for "
                "a rigid stop, or the others for one that yields."
            )
        limits = (c for c in limit_conditions(low, high) if c.known)
        for problem in (
            *stop_problems(where, s, low, high),
            *(problem for c in limits for problem in c.problems(where, {})),
        ):
            self._note(problem)
        e = self._value(restitution, "", f"restitution of {where}", "nonnegative")
        scale = self._optional(typical_force, force, f"typical force of {where}", "positive")
        gap = _gap_of_both(s, low, high)
        left = (*(() if low is None else (s - low,)), *(() if high is None else (high - s,)))
        return self._declare(RigidContact(name, gap, e, bodies, scale, unit, left))

    def clearance_joint(
        self, name: str, bearing: Place, journal: Place, clearance: Any, stiffness: Any, *,
        exponent: Any = 1.5, damping: Any = 0, coefficient: Any = 0, creep: Any = None,
        radius: Any = 0,
    ) -> Effect:  # fmt: skip
        """A revolute joint with clearance: a journal is free in its bearing until it touches it.

        Parameters
        ----------
        bearing, journal
            The centres of both, points of two bodies; a body means its centre of mass.
        clearance
            c, the radius of the bearing less that of the journal, m.
        stiffness, exponent
            K in N/mⁿ and n of the force K δⁿ at the depth δ; n = 1.5 is Hertz' law.
        damping
            χ in s/m of the factor 1 + χ δ̇; 3 (1 - ε²)/(4 v) for a restitution ε at an impact of
            speed v (Lankarani and Nikravesh).
        coefficient, creep
            μ of the friction, and the speed in m/s below which it creeps.
        radius
            The journal's radius, m, the arm of the friction.
        """
        where = f"clearance joint '{name}'"
        ends = self._pair(name, bearing, journal)
        n = self._value(exponent, "", f"exponent of {where}")
        unit = f"N/m^{float(n):g}" if n.is_number and n.is_real else ""
        return self._declare(
            ClearanceJoint(
                name,
                *ends,
                self._value(clearance, "m", f"clearance of {where}", "positive"),
                self._value(stiffness, unit, f"stiffness of {where}", "positive"),
                n,
                self._value(damping, "s/m", f"damping of {where}", "nonnegative"),
                self._value(coefficient, "", f"coefficient of {where}", "nonnegative"),
                self._optional(creep, "m/s", f"creep speed of {where}", "positive"),
                self._value(radius, "m", f"radius of {where}", "nonnegative"),
            )
        )

    def _limited(self, where: str, of: Any) -> tuple[sympy.Expr, str, tuple[Body, ...]]:
        """The coordinate that a stop limits, its unit, and the bodies that it is of."""
        given: object = of
        if isinstance(given, JOINTS):
            if self.joints.get(given.name) is not given:
                self._note(f"{where}: joint '{given.name}' is not of this model; give one that is.")
            angles = [body.angle for body in given.bodies]
            if given.kind == "revolute" and any(angle is None for angle in angles):
                self._note(
                    f"{where}: a body of joint '{given.name}' counts no angle; limit an expression "
                    "of its coordinates."
                )
                return sympy.S.One, "rad", given.bodies
            s, unit = joint_coordinate(given)
            return s, unit, given.bodies
        if isinstance(given, Constraint | str):
            name = shown(given.name if isinstance(given, Constraint) else given)
            self._note(
                f"{where}: {name} is no joint with a coordinate; give a revolute, a translational "
                "or a revolute-translational joint itself, or an expression of coordinates."
            )
            return sympy.S.One, "", ()
        s = self._value(of, "", f"coordinate of {where}")
        return s, unit_of(s), self._bodies_in(s)


def _gap_of_both(s: sympy.Expr, lower: sympy.Expr | None, upper: sympy.Expr | None) -> sympy.Expr:
    """A gap that closes at each limit with the slope ±1, smooth in between."""
    if lower is None:
        return s if upper is None else upper - s
    if upper is None:
        return s - lower
    return (s - lower) * (upper - s) / (upper - lower)
