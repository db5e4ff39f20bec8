"""Checks of a model and a scene before their equations are derived.

Each finding is a sentence that names the element, shows the numbers and says what to do. All of
them are reported together.
"""

from collections.abc import Iterator
from itertools import chain

import sympy

from codegen.check.elements import body_problems, effect_problems, element_problems, unknown
from codegen.check.potential_steps import step_problems
from codegen.check.requested_outputs import output_problems
from codegen.check.set_valued_forces import contact_problems
from codegen.declare import element as el
from codegen.declare.cam_profile_checks import profile_problems
from codegen.declare.returned_kinds import name_errors
from codegen.declare.returned_terms import effect_expressions, friction_law
from codegen.declare.returned_values import closed_curves, own_coordinates
from codegen.declare.scene import Scene
from codegen.declare.symbols import Coordinate, Parameter, Velocity, alpha, kinds, t
from codegen.derive.equations import acting_elements, active_joints
from codegen.derive.parameter_conditions import element_conditions
from codegen.errors import ModelError
from codegen.model import Model
from codegen.readers.failures import errors_at
from codegen.readers.values import one_line

LONGEST = 2000  # layout: characters of a sentence


def check_model(model: Model) -> list[str]:
    """Problems of the declaration, whatever the scene."""
    problems = [*model.problems]
    if not model.bodies:
        problems.append(f"model '{model.name}' has no body; declare one with model.body(...).")
    known = _known_symbols(model)
    masses = {name: [*body_problems(model, b, known)] for name, b in model.bodies.items()}
    sound = tuple(body for name, body in model.bodies.items() if not masses[name])
    for name, element in _all_elements(model):
        if name in model.noted:
            continue
        try:
            with name_errors(element):
                if element.name != name:
                    problems.append(f"{el.label(element)} was declared as '{name}'; keep its name.")
                problems += element_problems(model, element, sound, known)
        except ModelError as error:
            problems += error.problems
    problems += chain.from_iterable(masses.values())
    problems += [
        f"state '{name}' has no rate; give rate=, or model.state_equation({name}, ...)."
        for name, state in model.states.items()
        if not state.given
    ]
    problems += filter(None, (p.problem(p.value) for p in model.parameters.values()))
    problems += _collisions(model)
    problems += _lost_symbols(model, known, problems)
    return list(dict.fromkeys(one_line(p, LONGEST) for p in problems))


def _lost_symbols(
    model: Model, known: frozenset[sympy.Symbol], problems: list[str]
) -> Iterator[str]:
    """Unknown symbols of values that have no share in the equations, such as 0 times a place."""
    for where, symbols in model.symbols:
        for symbol in sorted(symbols - known, key=str):
            sentence = unknown(model, where, symbol)
            end, named = sentence.removeprefix(where), f"'{symbol}'"
            if not any(p.endswith(end) or (p.startswith(where) and named in p) for p in problems):
                yield sentence


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
    problems += [*output_problems(model, scene), *contact_problems(model, scene)]
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
        symbols = _known_symbols(model)
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


def _all_elements(model: Model) -> Iterator[tuple[str, el.Constraint | el.Effect]]:
    """Joints, drivers, and effects in every fidelity that their declaration has the numbers for."""
    yield from (*model.joints.items(), *model.drivers.items())
    yield from model.effects.items()
    for name, forms in model.fidelities.items():
        for form in forms.values():
            if not isinstance(form, str) and form is not model.effects[name]:
                yield name, form


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


def _known_symbols(model: Model) -> frozenset[sympy.Symbol]:
    """Parameters, the time, and the coordinates and velocities of bodies and joints."""
    coordinates = [q for body in model.bodies.values() for q in body.coordinates]
    coordinates += [q for joint in model.joints.values() for q in own_coordinates(joint)]
    moving = (symbol for q in coordinates for symbol in (q, q.rate))
    return frozenset((*model.defaults, t, *moving, *(s.symbol for s in model.states.values())))


def _collisions(model: Model) -> Iterator[str]:
    """Two things that would have one name in the generated text."""
    owners: dict[str, str] = {"t": "the time"}
    declared = [("body", body.name, body.coordinates) for body in model.bodies.values()]
    declared += [("joint", joint.name, own_coordinates(joint)) for joint in model.joints.values()]
    declared += [("state", name, (s.integral,)) for name, s in model.states.items()]
    for kind, owner, coordinates in declared:
        for symbol in (s for q in coordinates for s in (q, q.rate)):
            owners[symbol.name] = f"a coordinate or velocity of {kind} '{owner}'"
    for name in model.parameters:
        if name in owners:
            yield f"parameter '{name}' has the name of {owners[name]}; rename it."
