"""The effects between surfaces: contact, and friction in joints and on belts."""

from dataclasses import replace
from typing import Any, Literal

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.declare.symbols import Coordinate, SignRule, Time, Velocity, kinds, rate
from codegen.elements.forces.given_load_friction import DryFriction
from codegen.elements.forces.joint_friction import JointFriction
from codegen.elements.forces.rigid_contact import RigidContact
from codegen.elements.forces.spring_damper_contact import Contact, gap_between
from codegen.model.base import Declarations, Ends, Pair, Place
from codegen.readers.values import shown

FrictionLaw = Literal["sticking", "regularised"]


class Contacts(Declarations):
    """Contacts and friction of a declaration."""

    def contact(
        self, name: str, i: Place | None = None, j: Place | None = None, *, stiffness: Any = None,
        damping: Any = None, free_length: Any = 0, direction: Pair | None = None, gap: Any = None,
        may_pull: bool = True, restitution: Any = None, typical_force: Any = None,
        fidelity: Literal["penalty", "rigid"] | None = None,
    ) -> Effect:  # fmt: skip
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
            False cuts the damper off where it would hold the bodies together, which tyres, balls
            and all other surfaces that do not stick need; True is the plain law k g + c ġ.
        restitution
            Instead of stiffness and damping: e of a rigid contact, from 0 to 1.
        typical_force
            Of a rigid contact: a force of the size of its reactions, N; None: the weight of the
            bodies of the scene.
        fidelity
            ``"penalty"`` or ``"rigid"``, of a contact with the numbers of both: the fidelity in a
            scene that does not say.
        """
        where = f"contact '{name}'"
        g, bodies = self._gap(name, i, j, free_length, direction, gap)
        soft = stiffness is not None or damping is not None
        pulling = self._read.flag(may_pull, f"{where}: may_pull", True)
        both = self._law_word(fidelity, ("penalty", "rigid"), f"{where}, fidelity")
        forms: dict[str, Effect | str] = {
            "penalty": "needs stiffness= in its declaration.",
            "rigid": "needs restitution= in its declaration.",
        }
        if restitution is None or (both and soft):
            if stiffness is None:
                self._note(
                    f"{where} has neither stiffness= nor restitution=; give stiffness= for one "
                    "that yields, or restitution= for one that is rigid."
                )
                stiffness = 1
            if typical_force is not None and restitution is None:
                self._note(f"{where}: typical_force= is a rigid contact's; leave it out.")
            k = self._value(stiffness, "N/m", f"stiffness of {where}")
            c = self._value(0 if damping is None else damping, "N s/m", f"damping of {where}")
            forms["penalty"] = Contact(name, g, k, c, bodies, pulling)
        if restitution is not None:
            if soft and not both:
                self._note(
                    f"{where} has both restitution= and stiffness= or damping=; give restitution= "
                    "for a rigid contact, or the others for one that yields, or all with "
                    "fidelity='rigid' or 'penalty' to let scenes choose."
                )
            if not pulling and not (both and soft):
                self._note(f"{where}: a rigid contact never pulls; leave may_pull out.")
            e = self._value(restitution, "", f"restitution of {where}", "nonnegative")
            scale = self._optional(typical_force, "N", f"typical force of {where}", "positive")
            forms["rigid"] = RigidContact(name, g, e, bodies, scale)
        return self._chosen_form(
            where, both or ("rigid" if restitution is not None else "penalty"), forms
        )

    def friction(
        self, name: str, joint: Constraint, coefficient: Any, creep: Any = None, radius: Any = None,
        length: Any = None, static: Any = None, fidelity: FrictionLaw | None = None,
    ) -> Effect:  # fmt: skip
        """Coulomb friction in a joint, from the joint's reaction.

        Parameters
        ----------
        joint
            A revolute, translational or revolute-translational joint.
        coefficient
            μ.
        creep
            Of a law that is regularised at rest: the speed, in m/s or, in a revolute joint, rad/s,
            below which the joint creeps. Without it the joint sticks.
        radius
            Of a revolute joint's pin, m.
        length
            Of a translational joint's bearing, m: its moment then presses at both ends.
        static
            μ_s of a joint that sticks, at least μ; None: μ.
        fidelity
            ``"sticking"`` or ``"regularised"``: the fidelity in a scene that does not say.
            Without it a friction with a creep speed is regularised, and one without sticks; with it
            a declaration may give the numbers of both.
        """
        where = f"friction '{name}'"
        given: object = joint
        unit = "rad/s" if isinstance(given, Constraint) and given.kind == "revolute" else "m/s"
        mu, mu_s, speed = self._coefficients(where, coefficient, static, creep, unit)
        pin, bearing = (
            self._optional(size, "m", f"{word} of {where}", "positive")
            for size, word in ((radius, "radius"), (length, "length"))
        )
        if isinstance(given, Constraint) and self.joints.get(joint.name) is not joint:
            what = shown(joint.name)
            self._note(f"{where}: joint {what} is not declared in '{self.name}'; give one that is.")
        law = JointFriction(name, joint, mu, speed, pin, bearing, mu_s)
        return self._friction_law(where, law, fidelity)

    def dry_friction(
        self, name: str, i: Place | None = None, j: Place | None = None, *, coefficient: Any,
        normal: Any, axis: Pair | None = None, slip: Any = None, static: Any = None,
        creep: Any = None, fidelity: FrictionLaw | None = None,
    ) -> Effect:  # fmt: skip
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
            u in the frame of body `i`, of any length; None: (1, 0).
        slip
            Instead of points and axis: ṡ itself, in m/s, linear in velocities, as
            ``block.vx - speed``.
        static
            μ_s of a friction that sticks, at least μ; None: μ.
        creep
            Of a law that is regularised at rest: the speed in m/s below which it creeps.
        fidelity
            ``"sticking"`` or ``"regularised"``: the fidelity in a scene that does not say.
            Without it a friction with a creep speed is regularised, and one without sticks; with it
            a declaration may give the numbers of both.
        """
        where = f"dry friction '{name}'"
        mu, mu_s, speed = self._coefficients(where, coefficient, static, creep, "m/s")
        load = self._value(normal, "N", f"normal of {where}", "nonnegative")
        if slip is not None:
            if i is not None or j is not None:
                self._note(f"{where} has both slip= and points; give one of them.")
            if axis is not None:
                self._note(f"{where} has both slip= and axis=; the axis is that of two points.")
            s = self._value(slip, "m/s", f"slip of {where}")
            bodies = self._bodies_in(s)
        else:
            missing = f"{where} has no slip; give two points, or slip= a velocity."
            ends, bodies = self._surfaces(name, i, j, missing)
            along = self._direction(where, "axis", (1, 0) if axis is None else axis) or (
                sympy.S.One,
                sympy.S.Zero,
            )
            if moving := kinds(sympy.Tuple(*along), Coordinate, Velocity, Time):
                self._note(
                    f"{where}: the axis {along} depends on {moving[0].name}, and one that turns by "
                    "itself slides on nothing; give an axis fixed in body i, or slip= a velocity."
                )
            s = rate(gap_between(*ends, along, sympy.S.Zero))
        law = DryFriction(name, s, load, mu, bodies, mu_s, speed)
        return self._friction_law(where, law, fidelity)

    def _law_word(self, word: Any, allowed: tuple[str, ...], where: str) -> str:
        """One of the words; the empty text for None, and for what is none of them."""
        if word is None:
            return ""
        chosen = self._read.choice(word, allowed, where)
        return chosen if isinstance(word, str) and word in allowed else ""

    def _chosen_form(self, where: str, word: str, forms: dict[str, Effect | str]) -> Effect:
        """Declare an effect of several fidelities, of which `word` is the default."""
        chosen = forms[word]
        if isinstance(chosen, str):
            self._note(f"{where}: the fidelity '{word}' {chosen}")
            chosen = next(form for form in forms.values() if not isinstance(form, str))
        if self._declare(chosen) is self.effects.get(chosen.name):
            self.fidelities[chosen.name] = forms
        return chosen

    def _friction_law(
        self, where: str, law: JointFriction | DryFriction, fidelity: str | None
    ) -> Effect:
        """Declare a friction in each fidelity that it has the numbers for."""
        chosen = self._law_word(fidelity, ("sticking", "regularised"), f"{where}, fidelity")
        creeps = law.creep is not None
        if not chosen and creeps and law.static is not None:
            return self._declare(law)  # two laws at once, as its check says
        forms: dict[str, Effect | str] = {
            "sticking": replace(law, creep=None),
            "regularised": "needs creep= in its declaration.",
        }
        if creeps:
            forms["regularised"] = replace(law, static=None)
        return self._chosen_form(where, chosen or ("regularised" if creeps else "sticking"), forms)

    def _coefficients(
        self, where: str, coefficient: Any, static: Any, creep: Any, unit: str
    ) -> tuple[sympy.Expr, sympy.Expr | None, sympy.Expr | None]:
        """μ, μ_s and the creep speed."""
        sign: SignRule = "nonnegative" if static is None else "positive"
        return (
            self._value(coefficient, "", f"coefficient of {where}", sign),
            self._optional(static, "", f"static coefficient of {where}", "positive"),
            self._optional(creep, unit, f"creep speed of {where}", "positive"),
        )

    def _direction(
        self, where: str, word: str, vector: Any
    ) -> tuple[sympy.Expr, sympy.Expr] | None:
        """Two components that are not both zero."""
        ux, uy = self._read.pair(vector, "", f"{word} of {where}")
        if ux == 0 and uy == 0:
            self._note(f"{where}: the {word} (0, 0) points nowhere; give another.")
            return None
        return ux, uy

    def _surfaces(self, name: str, i: Any, j: Any, missing: str) -> tuple[Ends, tuple[Body, ...]]:
        """Two points and their bodies; one that is missing is noted, and the ground."""
        if i is None or j is None:
            self._note(missing)
        ends = self._pair(name, *(self.ground if end is None else end for end in (i, j)))
        return ends, tuple(end.body for end in ends)

    def _gap(
        self, name: str, i: Any, j: Any, free_length: Any, direction: Any, gap: Any
    ) -> tuple[sympy.Expr, tuple[Body, ...]]:
        """g of a contact, and the bodies that it is between."""
        where = f"contact '{name}'"
        if gap is not None:
            if i is not None or j is not None or direction is not None:
                self._note(f"{where} has both gap= and points; give one of them.")
            g = self._value(gap, "m", f"gap of {where}")
            return g - self._value(free_length, "m", f"free length of {where}"), self._bodies_in(g)
        missing = f"{where} has no gap; give two points, or gap= an expression."
        ends, bodies = self._surfaces(name, i, j, missing)
        along = None if direction is None else self._direction(where, "direction", direction)
        free = self._value(free_length, "m", f"free length of {where}")
        return gap_between(*ends, along, free), bodies
