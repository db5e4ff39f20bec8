"""Effects between bodies that touch or rub: contacts, friction, stops, clearances."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import sympy
from sympy.core.relational import Relational

from codegen.declare.body import Bodies
from codegen.declare.element import Constraint, Effect, label
from codegen.declare.symbols import Coordinate, Time, Velocity, kinds, rate
from codegen.elements.forces.clearance_joint import ClearanceJoint
from codegen.elements.forces.contacts import Contact, RigidContact, Stop, gap_between
from codegen.elements.forces.friction import DryFriction, JointFriction
from codegen.elements.joints.guides import Guide, RollingDisc
from codegen.elements.joints.points import Revolute
from codegen.elements.scalar_measures import unit_of
from codegen.model.base import Declarations, Ends, Pair, Place, declares
from codegen.readers.values import shown
from codegen.tables.piecewise_function import closed

FrictionLaw = Literal["sticking", "regularised"]


class Contacts(Declarations):
    """Contacts, friction, stops and clearances of a declaration."""

    def contact(
        self, name: str, i: Place | None = None, j: Place | None = None, *, stiffness: Any = None,
        damping: Any = None, free_length: Any = 0, direction: Sequence[Any] | None = None,
        gap: Any = None, may_pull: bool = True, restitution: Any = None, typical_force: Any = None,
        fidelity: Literal["penalty", "rigid"] | None = None,
    ) -> Effect:  # fmt: skip
        """A contact that acts while a gap is closed, by spring and damper (Haug 8.4.2) or rigidly.

        Parameters
        ----------
        i, j
            Points of two bodies (a body means its centre of mass), from which the gap follows:
            along `direction`, g = (A_i u)ᵀ (r_j^P - r_i^P) - ℓ0; without a direction, g = ℓ - ℓ0.
        stiffness, damping
            k in N/m and c in N s/m of f = k g + c ġ, which acts while g < 0.
        free_length
            ℓ0 in m.
        direction
            u in the frame of body `i`, of any length; in space three numbers.
        gap
            Instead of points: g itself, in m, an expression of coordinates, parameters and t.
        may_pull
            False sets the force to zero where the damper would hold the bodies together; tyres,
            balls and all other surfaces that do not stick need this. True is the plain law k g + c
            ġ.
        restitution
            Instead of stiffness and damping: e of a rigid contact, from 0 to 1.
        typical_force
            For a rigid contact: the typical size of its reactions, N; None: the weight of the
            bodies of the scene.
        fidelity
            ``"penalty"`` or ``"rigid"``: which of the two is the default, if the contact has both
            `stiffness` (perhaps with `damping`) and `restitution`.
        """
        where = f"contact '{name}'"
        gap, bodies = self._gap(name, i, j, free_length, direction, gap)
        pulling = self._read.flag(may_pull, f"{where}: may_pull", True)
        soft = stiffness is not None or damping is not None
        has_both = fidelity is not None and soft and restitution is not None
        if not has_both:
            stiffness = self._one_law(
                where, stiffness, damping, restitution, typical_force,
                ", or all with fidelity='rigid' or 'penalty' to let scenes choose",
            )  # fmt: skip
        made: dict[str, Effect] = {}
        if restitution is None or has_both:
            made["penalty"] = self._element(
                Contact, name=name, gap=gap, stiffness=stiffness,
                damping=0 if damping is None else damping, on=bodies, may_pull=pulling,
            )  # fmt: skip
        if restitution is not None:
            if not pulling and not has_both:
                self._note(f"{where}: a rigid contact never pulls; leave may_pull out.")
            made["rigid"] = self._element(
                RigidContact, where=where, name=name, gap=gap, restitution=restitution, on=bodies,
                typical_force=typical_force,
            )  # fmt: skip
        needs = {"penalty": "stiffness=", "rigid": "restitution="}
        return self._declare_forms(where, fidelity, next(iter(made)), made, needs)

    def stop(
        self, name: str, of: Constraint | Any, lower: Any = None, upper: Any = None, *,
        stiffness: Any = None, damping: Any = None, restitution: Any = None,
        typical_force: Any = None,
    ) -> Effect:  # fmt: skip
        """Stops limit the coordinate of a joint: springs with dampers, or rigid stops.

        Parameters
        ----------
        of
            A revolute joint, whose coordinate s is φ_j - φ_i, rad; a translational or
            revolute-translational joint, whose s is the travel of point j from point i along the
            axis, m; in space a joint with an angle or a slide; or s itself, an expression of
            coordinates and parameters.
        lower, upper
            The limits of s, of which one may be left out.
        stiffness, damping
            k and c of f = k (s - s_limit) + c ṡ beyond a limit, N/m and N s/m along a travel,
            N m/rad and N m s/rad about an angle; f never holds s back.
        restitution
            Instead of stiffness and damping: e of stops that do not yield, from 0 to 1. They are a
            rigid contact, whose gap with both limits is (s - lower) (upper - s)/(upper - lower).
        typical_force
            For rigid stops: the typical size of their reactions, N or N m; None: the weight of the
            bodies of the scene, in N.
        """
        where = f"stop '{name}'"
        told = len(self.problems)
        s, unit, bodies = self._limited(where, of)
        is_known = len(self.problems) == told  # no stand-in
        words: dict[str, Any] = {"name": name, "unit": unit, "on": bodies}
        stiffness = self._one_law(where, stiffness, damping, restitution, typical_force)
        yielding: Stop = self._element(
            Stop, scalar=s, lower=lower, upper=upper,
            stiffness=1 if stiffness is None else stiffness,
            damping=0 if damping is None else damping, **words,
        )  # fmt: skip
        if restitution is None:
            return self._declare(yielding)
        for problem in yielding.problems() if is_known else ():
            self._note(problem)
        self._note_violated(where, *yielding.conditions())
        rigid: RigidContact = self._element(
            RigidContact, where=where, gap=yielding.gap_of_both, restitution=restitution,
            typical_force=typical_force, limits=yielding.gaps, **words,
        )  # fmt: skip
        return self._declare(rigid)

    @declares(ClearanceJoint, i="bearing", j="journal")
    def clearance_joint(
        self, name: str, bearing: Place, journal: Place, clearance: Any, stiffness: Any, *,
        exponent: Any = 1.5, damping: Any = 0, coefficient: Any = 0, creep: Any = None,
        radius: Any = 0,
    ) -> Effect:  # fmt: skip
        """A revolute joint with clearance: its journal is free until it touches the bearing.

        Parameters
        ----------
        bearing, journal
            The centres of both, points of two bodies; a body means its centre of mass.
        clearance
            c, the radius of the bearing minus the radius of the journal, m.
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

    def friction(
        self, name: str, joint: Constraint, coefficient: Any = None, creep: Any = None,
        radius: Any = None, length: Any = None, static: Any = None,
        fidelity: FrictionLaw | None = None, arm: Any = None,
    ) -> Effect:  # fmt: skip
        """Coulomb friction in a joint, from the joint's reaction.

        Parameters
        ----------
        joint
            A revolute, translational or revolute-translational joint, a point follower, a cam with
            a follower, or a rolling disc.
        coefficient
            μ; a rolling disc has `arm` instead.
        creep
            The speed below which the joint creeps, in m/s, or in rad/s for a revolute joint and a
            rolling disc; the law is then regularised at rest. Without it the joint sticks.
        radius
            The radius of a revolute joint's pin, m.
        length
            The length of a translational joint's bearing, m: the moment then presses on both ends.
        static
            μ_s of a joint that sticks, at least μ; None: μ. Of a rolling disc the arm at rest, m.
        fidelity
            ``"sticking"`` or ``"regularised"``: the fidelity in scenes that do not choose one. With
            it, a declaration may give the numbers of both. Without it, a friction with a creep
            speed is regularised, and one without a creep speed sticks.
        arm
            f_R of a rolling disc, its coefficient of rolling friction, m.
        """
        given: object = joint
        if isinstance(given, RollingDisc):
            if arm is None or coefficient is not None:
                self._note(
                    f"friction '{name}': {label(joint)} needs arm=, its coefficient of rolling "
                    "friction in m, and no coefficient=."
                )
            coefficient = 0 if arm is None else arm
        elif arm is not None:
            self._note(f"friction '{name}': arm= is a rolling disc's; leave it out.")
        law: JointFriction = self._element(
            JointFriction, name=name, joint=joint, coefficient=coefficient, creep=creep,
            radius=radius, length=length, static=static,
        )  # fmt: skip
        self._note_foreign(name, given)
        return self._friction_law(law, fidelity)

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
            The speed in m/s below which the surfaces creep, for a law that is regularised at rest.
        fidelity
            ``"sticking"`` or ``"regularised"``: the fidelity in scenes that do not choose one. With
            it, a declaration may give the numbers of both. Without it, a friction with a creep
            speed is regularised, and one without a creep speed sticks.
        """
        where = f"dry friction '{name}'"
        if slip is not None:
            if i is not None or j is not None:
                self._note(f"{where} has both slip= and points; give one of them.")
            if axis is not None:
                self._note(f"{where} has both slip= and axis=; the axis is that of two points.")
            slip = closed(self._value(slip, "m/s", f"slip of {where}"))
            bodies = self._bodies_in(slip)
        else:
            missing = f"{where} has no slip; give two points, or slip= a velocity."
            ends, bodies = self._surfaces(name, i, j, missing)
            along = self._direction(where, "axis", (1, 0) if axis is None else axis)
            along = along or (sympy.S.One, sympy.S.Zero)
            if moving := kinds(sympy.Tuple(*along), Coordinate, Velocity, Time):
                self._note(
                    f"{where}: the axis {along} depends on {moving[0].name}, and one that turns by "
                    "itself slides on nothing; give an axis fixed in body i, or slip= a velocity."
                )
            slip = rate(closed(gap_between(*ends, along, sympy.S.Zero)))
        law: DryFriction = self._element(
            DryFriction, name=name, slip=slip, normal=normal, coefficient=coefficient, on=bodies,
            static=static, creep=creep,
        )  # fmt: skip
        pieces = sympy.Piecewise((0, law.normal < 0), (1, True))  # the condition as in a force
        for condition in pieces.atoms(Relational):
            words = f"{name} ceases to press / {name} presses"
            self._read.labels.setdefault(condition, words)
        return self._friction_law(law, fidelity)

    def _one_law(
        self, where: str, stiffness: Any, damping: Any, restitution: Any, typical_force: Any,
        otherwise: str = "",
    ) -> Any:  # fmt: skip
        """The stiffness; notes numbers of no law, or of one that yields and one that is rigid."""
        word = where.partition(" ")[0]
        if restitution is not None:
            if stiffness is not None or damping is not None:
                self._note(
                    f"{where} has both restitution= and stiffness= or damping=; give restitution= "
                    f"for a rigid {word}, or the others for one that yields{otherwise}."
                )
            return stiffness
        if typical_force is not None:
            self._note(f"{where}: typical_force= is a rigid {word}'s; leave it out.")
        if stiffness is None:
            self._note(
                f"{where} has neither stiffness= nor restitution=; give stiffness= for one "
                "that yields, or restitution= for one that is rigid."
            )
        return 1 if stiffness is None else stiffness

    def _declare_forms(
        self, where: str, word: Any, otherwise: str, made: Mapping[str, Effect],
        needs: Mapping[str, str],
    ) -> Effect:  # fmt: skip
        """Declare an effect in the fidelities `made`, `word` the default; others lack a number."""
        forms: dict[str, Effect | str] = {
            form: made.get(form) or f"needs {number} in its declaration."
            for form, number in needs.items()
        }
        if word is not None:
            before = len(self.problems)
            word = self._read.choice(word, tuple(forms), f"{where}, fidelity")
            if len(self.problems) == before and word not in made:
                self._note(f"{where}: the fidelity '{word}' {forms[word]}")
        chosen = made[word if word in made else otherwise]
        if self._declare(chosen) is self.effects.get(chosen.name):
            self.fidelities[chosen.name] = forms
        return chosen

    def _note_foreign(self, name: str, joint: Any) -> None:
        """Note the joint of a friction that is not of this model."""
        if isinstance(joint, Constraint) and self.joints.get(joint.name) is not joint:
            self._note(
                f"friction '{name}': joint {shown(joint.name)} is not declared in '{self.name}'; "
                "give one that is."
            )

    def _friction_law(self, law: DryFriction | JointFriction, fidelity: str | None) -> Effect:
        """Declare a friction in each fidelity that it has the numbers for."""
        creeps = law.creep is not None
        if law.static is not None:
            self._bind(law.coefficient, "positive")
        if fidelity is None and creeps and law.static is not None:
            return self._declare(law)  # two laws at once, as its check says
        made: dict[str, Effect] = {"sticking": replace(law, creep=None)}
        if creeps:
            made["regularised"] = replace(law, static=None)
        needs = {"sticking": "a joint that only turns or only slides", "regularised": "creep="}
        if getattr(law, "spins_and_slides", False) and creeps:
            del made["sticking"]
        otherwise = "regularised" if creeps else "sticking"
        return self._declare_forms(label(law), fidelity, otherwise, made, needs)

    def _direction(self, where: str, word: str, vector: Any) -> tuple[sympy.Expr, ...] | None:
        """As many components as there are axes, not all of them zero."""
        axes = ("",) * (3 if self.in_space else 2)
        along = self._read.vector(vector, axes, f"{word} of {where}", word)
        if all(u == 0 for u in along):
            self._note(f"{where}: the {word} {along} points nowhere; give another.")
            return None
        return along

    def _surfaces(self, name: str, i: Any, j: Any, missing: str) -> tuple[Ends, Bodies]:
        """Two points and their bodies; one that is missing is noted, and the ground."""
        if i is None or j is None:
            self._note(missing)
        one, other = (self._point(name, self.ground if end is None else end) for end in (i, j))
        return (one, other), (one.body, other.body)

    def _gap(
        self, name: str, i: Any, j: Any, free_length: Any, direction: Any, gap: Any
    ) -> tuple[sympy.Expr, Bodies]:
        """g of a contact, and the bodies that it is between."""
        where = f"contact '{name}'"
        if gap is not None:
            if i is not None or j is not None or direction is not None:
                self._note(f"{where} has both gap= and points; give one of them.")
            g = self._value(gap, "m", f"gap of {where}")
            free = self._value(free_length, "m", f"free length of {where}")
            return closed(g - free), self._bodies_in(g)
        missing = f"{where} has no gap; give two points, or gap= an expression."
        ends, bodies = self._surfaces(name, i, j, missing)
        along = None if direction is None else self._direction(where, "direction", direction)
        free = self._value(free_length, "m", f"free length of {where}")
        return closed(gap_between(*ends, along, free)), bodies

    def _limited(self, where: str, of: Any) -> tuple[sympy.Expr, str, Bodies]:
        """The coordinate that a stop limits, its unit, and the bodies that it is of."""
        letters: tuple[str, ...] = getattr(of, "countable", ())  # of a joint in space
        if len(letters) == 1 and self.joints.get(of.name) is of:
            of = getattr(of, letters[0])
        given: object = of
        if isinstance(given, Revolute | Guide):
            if self.joints.get(given.name) is not given:
                self._note(f"{where}: joint '{given.name}' is not of this model; give one that is.")
            angles = [body.angle for body in given.bodies]
            if given.kind == "revolute" and any(angle is None for angle in angles):
                self._note(
                    f"{where}: a body of joint '{given.name}' counts no angle; limit an expression "
                    "of its coordinates."
                )
                return sympy.S.One, "rad", given.bodies
            unit = "rad" if isinstance(given, Revolute) else "m"
            return given.rubbing().slip, unit, given.bodies
        if isinstance(given, Constraint | str):
            name = shown(given.name if isinstance(given, Constraint) else given)
            one = "one coordinate" if self.in_space else "a coordinate"
            more = " or a translational" if self.in_space else ", a translational or a "
            more += "" if self.in_space else "revolute-translational"
            give = f"a revolute{more} joint itself"
            if len(letters) > 1:
                give = " or ".join(f"{of.name}.{letter}" for letter in letters)
            self._note(
                f"{where}: {name} is no joint with {one}; give {give}, or an expression of "
                "coordinates."
            )
            return sympy.S.One, "", ()
        s = self._value(of, "", f"coordinate of {where}")
        return s, unit_of(s), self._bodies_in(s)
