"""Checks of one scene of a sound model, before its equations are derived."""

from collections.abc import Iterator
from itertools import chain, combinations
from typing import TYPE_CHECKING

import sympy

from codegen.check.declaration import LONGEST, known_symbols
from codegen.check.elements import all_problems, effect_problems
from codegen.check.potential_steps import step_problems
from codegen.declare import element as el
from codegen.declare.element import EXERTED, QUANTITIES, label
from codegen.declare.element_fields import ROUNDING, sampled_profile
from codegen.declare.returned_values import effect_expressions, friction_law, own_coordinates
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate, Parameter, Time, Velocity, kinds
from codegen.derive.constraint_terms import constraint_terms
from codegen.derive.effect_terms import available_quantities, effect_measures, effect_terms
from codegen.derive.equations import parts_of
from codegen.derive.parameter_conditions import element_conditions, outline_conditions, profiles_of
from codegen.derive.switching_functions import Named, switches
from codegen.elements.forces.mass_flow import MassFlow
from codegen.model.scene_requests import OF_POINTS, ONE
from codegen.parameter_conditions import profile_problems
from codegen.readers.calls import errors_at
from codegen.readers.values import one_line

if TYPE_CHECKING:
    from codegen.model import Model

_GEOMETRY = ("default", *OF_POINTS, *(word for word in QUANTITIES if word not in EXERTED))
_CONSTANT = {
    el.Sticking: (("coefficient", "kinetic"), ("static coefficient", "static")),
    el.Rigid: (("restitution", "restitution"), ("typical force", "scale")),
    el.OneWay: (("typical torque", "scale"),),
}
"""What of a set-valued force no motion changes: (word, field)."""


def check_scene(model: "Model", scene: Scene) -> list[str]:
    """Problems of one scene of a sound model."""
    where = f"scene '{scene.name}'"
    with errors_at(where):
        check = _SceneCheck(model, scene)
        found = [*check.of_effects(), *(f"{where}: {problem}" for problem in check.problems())]
        if not found:
            steps = step_problems(scene, check.parts, check.numbers)
            found = [f"{where}: {problem}" for problem in steps]
        return [one_line(problem, LONGEST) for problem in found]


class _SceneCheck:
    """What is wrong with what takes part in a scene, and with what is asked of it."""

    def __init__(self, model: "Model", scene: Scene) -> None:
        self.model, self.scene, self.parts = model, scene, parts_of(model, scene)
        self.present = {*scene.bodies, *self.parts.joints, *scene.states}
        given = (*scene.parameters, *((name, 1.0) for name in scene.unknown))
        self.numbers = model.defaults | {Parameter(k, real=True): x for k, x in given}

    def problems(self) -> Iterator[str]:
        """All others, without the name of the scene."""
        yield from self._missing_masses()
        yield from self._missing_flows()
        yield from self._missing_parts()
        self._place_joints()
        yield from self._outputs()
        yield from self._holds()
        yield from self._violated_conditions()
        for name, value in self.scene.parameters:
            if problem := self.model.parameters[name].problem(value):
                yield problem

    def _missing_masses(self) -> Iterator[str]:
        if not self.parts.bodies and self.model.bodies:
            yield (
                "no body takes part, so there is no coordinate to compute; leave one of "
                f"{', '.join(self.model.bodies)} in."
            )
        for body in self.parts.bodies if self.parts.moves else ():
            words = ("mass", "inertia") if body.turns else ("mass",)
            if missing := [word for word in words if getattr(body, word) is None]:
                arguments = ", ".join(f"{word}=..." for word in words)
                yield (
                    f"body '{body.name}' has no {' and no '.join(missing)}; give it in "
                    f"model.{'body' if body.turns else 'particle'}('{body.name}', {arguments}), or "
                    "declare the scene with analysis='kinematics'."
                )

    def _missing_flows(self) -> Iterator[str]:
        """Bodies whose masses vary by what takes no part, or whose flows do not act in whole."""
        flows = [e for e in self.parts.effects.values() if isinstance(e, MassFlow)]
        for body in self.parts.bodies if self.parts.moves else ():
            where = f"the mass of body '{body.name}' varies"
            owners = {q.owner for e in chain(*body.laws) for q in kinds(e, Coordinate)}
            if absent := sorted(owners - self.present):
                yield f"{where} by '{absent[0]}', which takes no part; leave the body out, too."
            shares = sympy.Add(*(one.share for one in flows if one.point.body is body))
            if body.laws and sympy.nsimplify(sympy.simplify(shares), tolerance=ROUNDING) != 1:
                yield (
                    f"{where}, and the shares of its mass flows that act add up to {shares}, not "
                    "to 1; declare model.mass_flow(...) where the matter comes or goes, and name "
                    "it among the effects."
                )

    def _missing_parts(self) -> Iterator[str]:
        """Elements and values that need what takes no part."""
        scene, kind = self.scene, self.model.kind
        for name in (*scene.effects, *scene.drivers):
            for owner in self._needed(name):
                if owner not in self.present | self.model.noted:
                    yield (
                        f"{kind(name)} '{name}' needs {kind(owner)} '{owner}', which takes no "
                        f"part; leave '{name}' out, or take '{owner}' in."
                    )
        for name, _ in (*scene.start, *scene.guess):
            owner = name.rpartition(".")[0] or name  # a state is its own
            if owner not in self.present | self.model.noted:
                yield f"{name} has a start value, but its {kind(owner)} takes no part."
        for name in scene.counted:
            if (owner := name.partition(".")[0]) not in self.present:
                yield (
                    f"something asks for {name}, but joint '{owner}' takes no part; take it in, or "
                    "leave out what asks for it."
                )
        for name, _ in scene.guess:
            if name in scene.states:
                yield f"guess names '{name}', but a state is not searched for; give it in start=."

    def _needed(self, name: str) -> list[str]:
        """The bodies, and joints with coordinates, that an effect or driver acts on or looks at."""
        element = self.parts.drivers.get(name) or self.parts.effects[name]
        needed = [body.name for body in element.bodies if not body.fixed]
        if isinstance(element, el.Effect):
            if law := friction_law(element):
                needed.append(law.joint)
            for expression in effect_expressions(element, self.parts.bodies):
                symbols = kinds(expression, Coordinate, Velocity)
                needed += [s.name.rpartition("_")[0] for s in symbols]
        return list(dict.fromkeys(needed))

    def _place_joints(self) -> None:
        """Ask joints with coordinates of their own where they are; ModelError where one fails."""
        for joint in self.parts.joints.values():
            with errors_at(label(joint)):
                if own_coordinates(joint):
                    self.model.place_of(joint, dict((*self.scene.guess, *self.scene.start)))

    def of_effects(self) -> Iterator[str]:
        """What effects return for the bodies of a scene, where these are not all."""
        scene, parts = self.scene, self.parts
        if scene.bodies != tuple(self.model.bodies):
            symbols = known_symbols(self.model)
            for name, effect in parts.effects.items():
                if name not in scene.states:  # whose rate no body changes
                    with errors_at(label(effect)):
                        yield from effect_problems(self.model, effect, parts.bodies, symbols)

    def _violated_conditions(self) -> Iterator[str]:
        """Conditions and shapes that the scene's values of parameters break."""
        for one in outline_conditions(self.parts.bodies):
            yield from one.condition.problems(one.element, self.numbers)
        for element in self.parts.acting:
            with errors_at(label(element)):
                for one in element_conditions(element, self.parts.bodies):
                    yield from one.condition.problems(one.element, self.numbers)
                drivers = self.parts.drivers.values()
                profiles = profiles_of(element, self.scene, drivers, self.numbers)
                shapes = [one.shape.subs(self.numbers).as_immutable() for one in profiles]
                rows = [one.row for one in profiles]
                yield from profile_problems(rows, [*map(sampled_profile, shapes)])

    def _outputs(self) -> Iterator[str]:
        """Outputs that need elements which the scene leaves out, and how to get them."""
        model, scene = self.model, self.scene
        acting = (*self.parts.joints, *scene.drivers, *scene.effects)
        leave = "or leave the output out."
        for word in scene.outputs or ():
            if not self.parts.moves and not word.startswith(_GEOMETRY):
                yield (
                    f"the output '{word}' needs masses and forces, which a kinematic scene leaves "
                    f"out; declare it with analysis='dynamics', {leave}"
                )
                continue
            if scene.analysis == "equilibrium" and word.startswith(("power", "work", "accel")):
                yield (
                    f"the output '{word}' needs a motion, which a scene for equilibrium leaves "
                    f"out; declare it with analysis='dynamics', {leave}"
                )
            match = ONE.match(word)
            if match is None:
                continue
            group, name = match.groups()
            if name in acting:
                if reason := self._missing_output(group, name):
                    yield f"there is no output '{word}', as {reason}"
                continue
            kind, advice = model.kind(name), ""
            if group in OF_POINTS:  # the point's body takes no part, or the scene leaves it out
                (body,) = model.effects[name].bodies
                if body.name not in scene.bodies:
                    kind, name = model.kind(body.name), body.name
                else:
                    kind = "point"
            else:
                others = f"{kind}s" if kind in ("effect", "driver") else "bodies and joints"
                advice = f" among its {others}"
            yield (
                f"the output '{word}' needs {kind} '{name}', which the scene leaves out; "
                f"take '{name}' in{advice}, {leave}"
            )

    def _missing_output(self, group: str, name: str) -> str | None:
        """Why an element that acts has no such reaction, power or work."""
        parts = self.parts
        if name not in self.scene.effects:
            if group == "global_reaction":
                statement, _ = constraint_terms((parts.joints | parts.drivers)[name])
                if isinstance(statement.reaction, el.WrenchReaction):
                    return f"reactions in space are in global axes; ask for 'reaction({name})'."
                plane = isinstance(statement.reaction, el.JointReaction)
                return None if plane else f"'{name}' has no force in a plane; leave it out."
            if group in QUANTITIES:
                return f"'{name}' is no effect; ask for 'reaction({name})'."
            element = (parts.joints | parts.drivers)[name]
            moving = name in parts.drivers or any(nu != 0 for nu in constraint_terms(element)[1].nu)
            idle = group in ("power", "work") and not moving
            return f"{label(element)} does no work; leave it out." if idle else None
        effect = parts.effects[name]
        terms = effect_terms(effect, parts.bodies)
        if group in QUANTITIES:
            known = available_quantities(terms, effect_measures(effect, terms, parts.bodies))
            if group in known:
                return None
            words = " or ".join(f"'{q}({name})'" for q in QUANTITIES if q in known)
            advice = f"ask for {words}" if words else "leave it out"
            return f"{label(effect)} has no {group}; {advice}."
        working = bool(terms.loads or terms.pulls or terms.friction or terms.flux)
        if group in ("work", "power") and not (working or terms.potential is not None):
            return f"'{name}' exerts nothing; leave it out."
        if group.endswith("reaction") and not (terms.reported or terms.friction):
            return f"{label(effect)} is no joint; ask for 'force({name})'."
        return None

    def _holds(self) -> Iterator[str]:
        """What of frictions, rigid contacts and freewheels varies in a run, or is shared."""
        acting = self.parts.effects if self.parts.moves else {}
        named = [(name, effect_terms(e, self.parts.bodies)) for name, e in acting.items()]
        holds = [(label(acting[name]), terms.hold) for name, terms in named if terms.hold]
        for where, hold in holds:
            for word, field in _CONSTANT[type(hold)]:
                value = getattr(hold, field)
                if value is not None and kinds(value, Coordinate, Velocity, Time):
                    advice = ", or creep=" if isinstance(hold, el.Sticking) else ""
                    yield (
                        f"{where}: the {word} {value} varies in a run; give a number or "
                        f"parameters{advice}."
                    )
            if isinstance(hold, el.Rigid):
                yield from all_problems(where, [hold.gap], may_switch=False)
        if holds:
            yield from _shared(named)


def _shared(named: list[Named]) -> Iterator[str]:
    """Switching surfaces of two effects whose forces one share α cannot determine."""
    every = [(name, switch) for name, terms in named for switch in switches([(name, terms)])]
    for (first, one), (second, other) in combinations(every, 2):
        if other.g not in (one.g, -one.g):
            continue
        both, same_kind = f"'{first}' and '{second}'", one.kind == other.kind
        if "clutch" in (one.kind, other.kind):
            if same_kind and one.g == other.g:
                yield (
                    f"{both} are freewheels of one slip {one.g}, whose torques no motion "
                    "distinguishes; leave one of them out."
                )
        elif same_kind and one.kind == "contact":
            yield (
                f"{both} are contacts at the same gap {one.g}, whose reactions no motion "
                "distinguishes; leave one of them out."
            )
        elif "contact" not in (one.kind, other.kind):
            apart = (one.ratio or sympy.S.One) - (other.ratio or sympy.S.One)
            # but for the rounding of their numbers
            if apart != 0 and not (apart.is_number and abs(apart) < ROUNDING):
                holder = first if one.ratio is not None else second
                yield (
                    f"{both} both change where {one.g} = 0, and '{holder}' has a static "
                    "coefficient, which applies to both; leave static= out, or give both frictions "
                    "the same coefficients."
                )
