"""Checks of one scene of a sound model, before its equations are derived."""

from collections.abc import Iterator
from itertools import combinations

import sympy

from codegen.check.declaration import LONGEST, known_symbols
from codegen.check.elements import all_problems, effect_problems
from codegen.check.potential_steps import step_problems
from codegen.declare import element as el
from codegen.declare.element import EXERTED, QUANTITIES, label
from codegen.declare.element_conditions import ROUNDING, profile_problems
from codegen.declare.returned_kinds import name_errors
from codegen.declare.returned_values import (
    closed_curves,
    effect_expressions,
    friction_law,
    own_coordinates,
)
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate, Parameter, Time, Velocity, alpha, kinds
from codegen.derive.constraint_terms import constraint_terms
from codegen.derive.effect_terms import available_quantities, effect_measures, effect_terms
from codegen.derive.equations import acting_elements, active_joints
from codegen.derive.parameter_conditions import element_conditions
from codegen.derive.switching_functions import Named, switches
from codegen.model import Model
from codegen.model.scene_requests import ONE
from codegen.readers.calls import errors_at
from codegen.readers.values import one_line

_GEOMETRY = ("point", *(word for word in QUANTITIES if word not in EXERTED))
_CONSTANT = {
    el.Sticking: (("coefficient", "kinetic"), ("static coefficient", "static")),
    el.Rigid: (("restitution", "restitution"), ("typical force", "scale")),
    el.OneWay: (("typical torque", "scale"),),
}
"""What of a set-valued force no motion changes: (word, field)."""


def check_scene(model: Model, scene: Scene) -> list[str]:
    """Problems of one scene of a sound model."""
    with errors_at(f"scene '{scene.name}'"):
        return [one_line(p, LONGEST) for p in _scene_problems(model, scene)]


def _scene_problems(model: Model, scene: Scene) -> list[str]:
    where = f"scene '{scene.name}'"
    joints = active_joints(model, scene)
    owners = {*scene.bodies, *joints, *scene.states}
    problems = []
    if not scene.bodies:
        problems.append(
            f"{where}: no body takes part, so there is no coordinate to compute; leave one of "
            f"{', '.join(model.bodies)} in."
        )
    if scene.analysis != "kinematics":
        for body in (model.bodies[name] for name in scene.bodies):
            words = ("mass", "inertia") if body.turns else ("mass",)
            if missing := [word for word in words if getattr(body, word) is None]:
                arguments = ", ".join(f"{word}=..." for word in words)
                problems.append(
                    f"{where}: body '{body.name}' has no {' and no '.join(missing)}; give it in "
                    f"model.{'body' if body.turns else 'particle'}('{body.name}', {arguments}), or "
                    "declare the scene with analysis='kinematics'."
                )
    for kind, names in (("effect", scene.effects), ("driver", scene.drivers)):
        for name in names:
            problems += [
                f"{where}: {kind} '{name}' needs {model.kind(owner)} '{owner}', which takes no "
                f"part; leave '{name}' out, or take '{owner}' in."
                for owner in _needed(model, scene, name)
                if owner not in owners
            ]
    for name, _ in (*scene.start, *scene.guess):
        owner = name.rpartition(".")[0] or name  # a state is its own
        if owner not in owners:
            problems.append(
                f"{where}: {name} has a start value, but its {model.kind(owner)} takes no part."
            )
    problems += [
        f"{where}: guess names '{name}', but a state is not searched for; give it in start=."
        for name, _ in scene.guess
        if name in scene.states
    ]
    problems += _problems_in_scene(model, scene, joints)
    problems += [*_output_problems(model, scene), *_contact_problems(model, scene)]
    problems += _violated_conditions(model, scene)
    values = (model.parameters[name].problem(value) for name, value in scene.parameters)
    problems += [f"{where}: {problem}" for problem in values if problem]
    return problems or list(step_problems(model, scene))


def _problems_in_scene(
    model: Model, scene: Scene, joints: dict[str, el.Constraint]
) -> Iterator[str]:
    """What elements return for the bodies and values of a scene, where these are other ones."""
    known = (*scene.guess, *scene.start)
    for joint in joints.values():
        with name_errors(joint):
            if own_coordinates(joint):
                model.place_of(joint, known)  # ModelError where it fails
    if scene.bodies != tuple(model.bodies):
        symbols = known_symbols(model)
        bodies = tuple(model.bodies[name] for name in scene.bodies)
        for name, effect in model.acting(scene).items():
            if name in scene.states:  # whose rate no body changes
                continue
            with name_errors(effect):
                yield from effect_problems(model, effect, bodies, symbols)


def _violated_conditions(model: Model, scene: Scene) -> Iterator[str]:
    """Conditions and shapes that the scene's values of parameters break."""
    numbers = model.defaults | {Parameter(k, real=True): value for k, value in scene.parameters}
    bodies = tuple(model.bodies[name] for name in scene.bodies)
    for element in acting_elements(model, scene):
        where = f"scene '{scene.name}': "
        with name_errors(element):
            for one in element_conditions(element, bodies):
                yield from one.condition.problems(where + one.element, numbers)
            for where_it_is, curve, convex in closed_curves(element) if scene.parameters else ():
                shape = curve.at(alpha).subs(numbers)
                yield from (
                    f"{where}{where_it_is}: {problem}"
                    for problem in profile_problems(shape, closed=True, convex=convex)
                )


def _needed(model: Model, scene: Scene, name: str) -> list[str]:
    """The bodies, and joints with coordinates, that an effect or driver acts on or looks at."""
    element: el.Constraint | el.Effect = model.drivers.get(name) or model.acting(scene)[name]
    needed = [body.name for body in element.bodies if not body.fixed]
    if isinstance(element, el.Effect):
        if law := friction_law(element):
            needed.append(law.joint)
        bodies = tuple(model.bodies[b] for b in scene.bodies)
        for expression in effect_expressions(element, bodies):
            needed += [s.name.rpartition("_")[0] for s in kinds(expression, Coordinate, Velocity)]
    return list(dict.fromkeys(needed))


def _output_problems(model: Model, scene: Scene) -> Iterator[str]:
    """Outputs that need elements which the scene leaves out, and how to get them."""
    where = f"scene '{scene.name}'"
    acting = (*active_joints(model, scene), *scene.drivers, *scene.effects)
    leave = "or leave the output out."
    for word in scene.outputs or ():
        if scene.analysis == "kinematics" and not word.startswith(_GEOMETRY):
            yield (
                f"{where}: the output '{word}' needs masses and forces, which a kinematic scene "
                f"leaves out; declare it with analysis='dynamics', {leave}"
            )
            continue
        if scene.analysis == "equilibrium" and word.startswith(("power", "work")):
            yield (
                f"{where}: the output '{word}' needs a motion, which a scene for equilibrium "
                f"leaves out; declare it with analysis='dynamics', {leave}"
            )
        match = ONE.match(word)
        if match is None:
            continue
        group, name = match.groups()
        if name in acting:
            if reason := _missing_output(model, scene, group, name):
                yield f"{where}: there is no output '{word}', as {reason}"
            continue
        if group == "point":  # the point's body takes no part, or the scene leaves out the point
            (body,) = model.effects[name].bodies
            gone = name if body.name in scene.bodies else body.name
            kind, advice = "point" if gone == name else model.kind(gone), f"take '{gone}' in"
        else:
            gone, kind = name, model.kind(name)
            others = f"{kind}s" if kind in ("effect", "driver") else "bodies and joints"
            advice = f"take '{gone}' in among its {others}"
        yield (
            f"{where}: the output '{word}' needs {kind} '{gone}', which the scene leaves out; "
            f"{advice}, {leave}"
        )


def _missing_output(model: Model, scene: Scene, group: str, name: str) -> str | None:
    """Why an element that acts has no such reaction, power or work."""
    if name not in scene.effects:
        if group in QUANTITIES:
            return f"'{name}' is no effect; ask for 'reaction({name})'."
        element = model.joints.get(name) or model.drivers[name]
        moving = name in scene.drivers or any(nu != 0 for nu in constraint_terms(element)[1].nu)
        idle = group in ("power", "work") and not moving
        return f"{label(element)} does no work; leave it out." if idle else None
    effect, bodies = model.acting(scene)[name], tuple(model.bodies[b] for b in scene.bodies)
    terms = effect_terms(effect, bodies)
    if group in QUANTITIES:
        measures = effect_measures(effect, terms, bodies)
        if group in (known := available_quantities(terms, measures)):
            return None
        words = " or ".join(f"'{q}({name})'" for q in QUANTITIES if q in known)
        return f"{label(effect)} has no {group}; {f'ask for {words}' if words else 'leave it out'}."
    working = bool(terms.loads or terms.pulls or terms.friction)
    if group in ("work", "power") and not (working or terms.potential is not None):
        return f"'{name}' exerts nothing; leave it out."
    if group == "reaction" and not (terms.reported or terms.friction):
        return f"{label(effect)} is no joint; ask for 'force({name})'."
    return None


def _contact_problems(model: Model, scene: Scene) -> Iterator[str]:
    """Sticking frictions, rigid contacts and freewheels: what varies in a run, and is shared."""
    bodies = tuple(model.bodies[name] for name in scene.bodies)
    acting = {} if scene.analysis == "kinematics" else model.acting(scene)
    named = [(name, effect_terms(effect, bodies)) for name, effect in acting.items()]
    holds = [(name, terms.hold) for name, terms in named if terms.hold]
    for name, hold in holds:
        where = f"scene '{scene.name}': {label(acting[name])}"
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
        yield from _shared(scene, named)


def _shared(scene: Scene, named: list[Named]) -> Iterator[str]:
    """Switching surfaces of two effects whose forces one share α cannot determine."""
    every = [(name, switch) for name, terms in named for switch in switches([(name, terms)])]
    for (first, one), (second, other) in combinations(every, 2):
        if other.g not in (one.g, -one.g):
            continue
        if "clutch" in (one.kind, other.kind):
            if one.kind == other.kind and one.g == other.g:
                yield (
                    f"scene '{scene.name}': '{first}' and '{second}' are freewheels of one slip "
                    f"{one.g}, whose torques no motion distinguishes; leave one of them out."
                )
            continue
        where = f"scene '{scene.name}': '{first}' and '{second}'"
        if one.kind == other.kind == "contact":
            yield (
                f"{where} are contacts at the same gap {one.g}, whose reactions no motion "
                "distinguishes; leave one of them out."
            )
        elif "contact" not in (one.kind, other.kind) and not _equal(one.ratio, other.ratio):
            holder = first if one.ratio is not None else second
            yield (
                f"{where} both change where {one.g} = 0, and '{holder}' has a static coefficient, "
                "which applies to both; leave static= out, or give both frictions the same "
                "coefficients."
            )


def _equal(one: sympy.Expr | None, other: sympy.Expr | None) -> bool:
    """Whether two ratios are the same, but for the rounding of their numbers."""
    difference = (sympy.S.One if one is None else one) - (sympy.S.One if other is None else other)
    return bool(difference == 0 or (difference.is_number and abs(difference) < ROUNDING))
