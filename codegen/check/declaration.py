"""Checks of a model and a scene before their equations are derived.

Each finding is a sentence that names the element, shows the numbers and says what to do. All of
them are reported together.
"""

from collections.abc import Iterable, Iterator
from itertools import chain

import sympy

from codegen.check.contact_and_stiction_declaration import contact_problems
from codegen.check.expressions import all_problems, constraint_problems
from codegen.check.potential_steps import step_problems
from codegen.check.requested_outputs import output_problems
from codegen.declare import element as el
from codegen.declare.answers import (
    WORDS,
    bodies_of,
    check_body,
    coordinates_of,
    forces_of,
    friction_law,
    optional_answers,
    own_coordinates,
    potential_of,
    problems_of,
    statement_of,
)
from codegen.declare.body import Body
from codegen.declare.cam_profile_checks import profile_problems
from codegen.declare.expression_rules import expression_problem, unreadable
from codegen.declare.name_rules_and_hints import nearest
from codegen.declare.plain_expression import plain_expression
from codegen.declare.scene import Scene
from codegen.declare.symbols import (
    SPEED,
    Coordinate,
    Given,
    Parameter,
    Velocity,
    alpha,
    kinds,
    side,
    t,
)
from codegen.derive.conditions_on_parameters import closed_curves, element_conditions
from codegen.derive.equations import acting_elements, active_joints
from codegen.errors import FAILURES, LinkwrightError, ModelError
from codegen.model import Model
from codegen.plain_values import one_line, shown

LONGEST = 2000  # layout: characters of a sentence


def check_model(model: Model) -> list[str]:
    """Problems of the declaration, whatever the scene."""
    problems = [*Model.problems.fget(model)]  # type: ignore[attr-defined]  # as noted, whatever a subclass says
    if not model.bodies:
        problems.append(f"model '{model.name}' has no body; declare one with model.body(...).")
    masses = {name: list(_body_problems(model, body)) for name, body in model.bodies.items()}
    sound = tuple(body for name, body in model.bodies.items() if not masses[name])
    known = _known_symbols(model)
    elements: list[el.Constraint | el.Effect] = [*model.joints.values(), *model.drivers.values()]
    for element in (*elements, *_all_effects(model)):
        if element.name in model.noted:
            continue
        try:
            problems += _element_problems(model, element, sound, known)
        except ModelError as error:
            problems += error.problems
        except FAILURES as error:  # of an expression too deep, of SymPy
            problems.append(f"{el.label(element)}: {unreadable(error)}")
    problems += chain.from_iterable(masses.values())
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
            sentence = _unknown(model, where, symbol)
            end, named = sentence.removeprefix(where), f"'{symbol}'"
            if not any(p.endswith(end) or (p.startswith(where) and named in p) for p in problems):
                yield sentence


def _element_problems(
    model: Model, element: el.Constraint | el.Effect, sound: tuple[Body, ...],
    known: frozenset[sympy.Symbol],
) -> Iterator[str]:  # fmt: skip
    """Problems of one element, as it says them and as its answers show."""
    yield from _words_and_bodies(model, element)
    faults = problems_of(element)
    yield from faults
    if faults:
        return
    if isinstance(element, el.Constraint):
        yield from _statement_problems(model, element, known)
        return
    for speed in kinds(potential_of(element, sound) or sympy.S.Zero, Velocity):
        yield (
            f"{el.label(element)}: its potential contains the velocity {speed.name}; answer a "
            "force that depends on a velocity by forces()."
        )
    terms = _effect_expressions(element, sound)
    yield from _unknown_symbols(model, element, terms, known)
    yield from all_problems(el.label(element), terms, may_switch=True)


def check_scene(model: Model, scene: Scene) -> list[str]:
    """Problems of one scene of a sound model."""
    try:
        return [one_line(p, LONGEST) for p in _scene_problems(model, scene)]
    except LinkwrightError:
        raise
    except FAILURES as error:
        raise ModelError(f"scene '{scene.name}': {unreadable(error)}") from error


def _scene_problems(model: Model, scene: Scene) -> list[str]:
    where = f"scene '{scene.name}'"
    joints = active_joints(model, scene)
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
                if owner not in (*scene.bodies, *joints)
            ]
    for name, _ in (*scene.start, *scene.guess):
        owner = name.rpartition(".")[0]
        if owner not in (*scene.bodies, *joints):
            problems.append(
                f"{where}: {name} has a start value, but its {model.kind(owner)} takes no part."
            )
    problems += [*output_problems(model, scene), *contact_problems(model, scene)]
    problems += _broken_conditions(model, scene)
    values = (model.parameters[name].problem(value) for name, value in scene.parameters)
    problems += [f"{where}: {problem}" for problem in values if problem]
    return problems or list(step_problems(model, scene))


def _broken_conditions(model: Model, scene: Scene) -> Iterator[str]:
    """Conditions and shapes that the scene's values of parameters break."""
    numbers = model.defaults | {Parameter(k, real=True): value for k, value in scene.parameters}
    bodies = tuple(model.bodies[name] for name in scene.bodies)
    for element in acting_elements(model, scene):
        where = f"scene '{scene.name}': "
        for one in element_conditions(element, bodies):
            yield from one.condition.problems(where + one.element, numbers)
        for where_it_is, curve, convex in closed_curves(element) if scene.parameters else ():
            shape = curve.at(alpha).subs(numbers)
            yield from (
                f"{where}{where_it_is}: {problem}"
                for problem in profile_problems(shape, closed=True, convex=convex)
            )


def _all_effects(model: Model) -> list[el.Effect]:
    """The effects in every fidelity that their declaration has the numbers for."""
    forms = ((name, form) for name, of in model.fidelities.items() for form in of.values())
    others = [f for name, f in forms if not isinstance(f, str) and f is not model.effects[name]]
    return [*model.effects.values(), *others]


def _words_and_bodies(model: Model, element: el.Element) -> Iterator[str]:
    """Check the text of an element's kind, and whose its bodies are."""
    where, bodies = el.label(element), bodies_of(element)
    kind: object = element.kind
    if not isinstance(kind, str) or not WORDS.fullmatch(kind):
        reason = f"its kind {shown(kind)} must be a few words of ASCII letters"
        yield f"element {shown(element.name)}: {reason}."
    for body in bodies:
        if body.model is not model.token:
            advice = f"use a body of '{model.name}'."
            yield f"{where}: body '{body.name}' belongs to another model; {advice}"
        elif not body.fixed and model.bodies.get(body.name) is not body:
            yield f"{where}: body '{body.name}' is not declared in '{model.name}'."
    if isinstance(element, el.Constraint) and len(bodies) == 2 and bodies[0] is bodies[1]:
        yield f"{where} connects body '{bodies[0].name}' with itself; give two different bodies."


def _statement_problems(
    model: Model, constraint: el.Constraint, known: frozenset[sympy.Symbol]
) -> Iterator[str]:
    """Check the form of a statement, its texts in the generated module, and its expressions."""
    where, statement = el.label(constraint), statement_of(constraint)
    axes: tuple[sympy.Expr, ...] = ()
    if isinstance(reaction := statement.reaction, el.JointReaction):
        arm = reaction.on.A * reaction.on.s if reaction.arm is None else reaction.arm
        direction, arm = (tuple(map(plain_expression, v)) for v in (reaction.direction, arm))
        size = sympy.Add(*(c**2 for c in direction))
        if len(direction) != 2 or (size.is_number and abs(float(size) - 1) > 1e-9):
            yield (
                f"{where}: the direction of its reaction is {direction}; give two components of a "
                "unit vector in global axes."
            )
        if len(arm) != 2:
            yield f"{where}: the arm of its reaction is {arm}; give two components, in m."
        axes = (*direction, *arm)
    expressions = (*statement.phi, *statement.bindings.values(), *axes)
    yield from _unknown_symbols(model, constraint, expressions, known)
    yield from constraint_problems(constraint)
    yield from _orientations(constraint)


def _orientations(constraint: el.Constraint) -> Iterator[str]:
    """Joints that would turn a particle, or ask for an angle that a body has not."""
    statement = statement_of(constraint)
    phi = sympy.Tuple(*statement.phi)
    for frame in (el.I, el.J):
        centred = phi.xreplace(dict.fromkeys(frame.s, sympy.S.Zero))
        if not centred.has(frame.phi):
            continue
        at = statement.bindings.get(frame.x)
        body = next((b for b in bodies_of(constraint) if at == b.position[0]), None)
        if body and body.angle is None and phi.xreplace(statement.bindings).has(frame.phi):
            letters = ", ".join(q.letter for q in body.coordinates)
            yield (
                f"{el.label(constraint)} asks for the angle of '{body.name}', which "
                f"is oriented by {letters} and counts none; use joints that ask for points and "
                "axes, such as revolute, point-on-line or distance, or model.constraint(...)."
            )
        if body and not body.turns:
            yield (
                f"{el.label(constraint)} holds an angle of '{body.name}', which is "
                "a particle and has none; use a joint that leaves it free to turn, or a body."
            )


def _needed(model: Model, scene: Scene, name: str) -> list[str]:
    """The bodies, and joints with coordinates, that an effect or driver acts on or looks at."""
    element: el.Constraint | el.Effect = model.drivers.get(name) or model.acting(scene)[name]
    needed = [body.name for body in bodies_of(element) if not body.fixed]
    if isinstance(element, el.Effect):
        if law := friction_law(element):
            needed.append(law.joint)
        bodies = tuple(model.bodies[b] for b in scene.bodies)
        for expression in _effect_expressions(element, bodies):
            needed += [s.name.rpartition("_")[0] for s in kinds(expression, Coordinate, Velocity)]
    return list(dict.fromkeys(needed))


def _effect_expressions(effect: el.Effect, bodies: tuple[Body, ...]) -> list[sympy.Basic]:
    forces, potential = forces_of(effect, bodies), potential_of(effect, bodies)
    expressions: list[sympy.Basic | None] = [*forces, *forces.values(), potential]
    law, hold, pulls, reported = optional_answers(effect, bodies)
    expressions += chain.from_iterable(pulls)
    expressions += [value for _, _, value in reported]
    expressions += vars(hold).values() if hold else ()
    expressions += (law.strength, law.creep, law.along) if law else ()
    return [e for e in expressions if e is not None]


def _known_symbols(model: Model) -> frozenset[sympy.Symbol]:
    """Parameters, the time, and the coordinates and velocities of bodies and joints."""
    coordinates = [q for body in model.bodies.values() for q in coordinates_of(body)]
    coordinates += [q for joint in model.joints.values() for q in own_coordinates(joint)]
    moving = (symbol for q in coordinates for symbol in (q, q.rate))
    return frozenset((*model.defaults, SPEED, t, *moving))


def _unknown_symbols(
    model: Model, element: el.Constraint | el.Effect, expressions: Iterable[sympy.Basic],
    known: frozenset[sympy.Symbol],
) -> Iterator[str]:  # fmt: skip
    """Symbols that mean nothing in the model."""
    bodies = bodies_of(element)
    of_bodies = (s for b in bodies for q in coordinates_of(b) for s in (q, q.rate))
    known |= {side(element.name), *of_bodies}
    symbols = set().union(*(e.free_symbols for e in expressions)) - known
    if isinstance(element, el.Constraint):
        symbols -= {s for place in statement_of(element).bindings for s in place.free_symbols}
    for symbol in sorted(symbols, key=lambda s: s.name):
        yield _unknown(model, el.label(element), symbol)


def _unknown(model: Model, where: str, symbol: sympy.Symbol) -> str:
    if isinstance(symbol, Given):
        return f"{where}: the placeholder '{symbol}' is not bound; add it to bindings."
    if isinstance(symbol, Coordinate | Velocity):
        owner = symbol.name.rpartition("_")[0]
        if owner in model.bodies:
            return (
                f"{where} uses {symbol.name}, but {model.kind(owner)} '{owner}' has no such "
                f"coordinate; it has {', '.join(q.name for q in model.bodies[owner].coordinates)}."
            )
        return (
            f"{where} uses {symbol.name}, but there is no body '{owner}' in '{model.name}'; "
            f"{nearest(owner, model.bodies)}"
        )
    if symbol.name in model.parameters:
        return (
            f"{where}: the symbol '{symbol}' has the name of a parameter but is another symbol; "
            "use the object that model.parameter(...) returned."
        )
    if symbol.name == "t":
        return f"{where}: the symbol 't' is not the time; use the t of 'from codegen import t'."
    return (
        f"{where}: unknown symbol '{symbol}'; declare it with model.parameter('{symbol}', ...), "
        f"or {nearest(symbol.name, model.parameters)}"
    )


def _body_problems(model: Model, body: Body) -> Iterator[str]:
    """Problems of a body: what one of a modeller's own class answers, its mass and inertia."""
    numbers: tuple[object, ...] = (vars(body).get("mass"), vars(body).get("inertia"))
    plain = all(number is None or isinstance(number, sympy.Expr) for number in numbers)
    if not type(body).__module__.startswith("codegen.") or not plain:
        try:
            check_body(body)
        except ModelError as error:
            yield from error.problems
            return
    yield from _mass_problems(model, body)


def _mass_problems(model: Model, body: Body) -> Iterator[str]:
    for word, unit in (("mass", "kg"), ("inertia", "kg m^2")):
        value = getattr(body, word)
        if value is None:
            continue
        if problem := expression_problem(value):  # of a body that a modeller made by hand
            yield f"{word} of body '{body.name}': {problem}"
            continue
        if unknown := sorted(s.name for s in value.free_symbols if s not in model.defaults):
            yield (
                f"{word} of body '{body.name}': unknown symbol {', '.join(map(repr, unknown))}; "
                "a mass is a number or an expression of parameters."
            )
            continue
        number = value.subs(model.defaults)
        if not (number.is_real and 0 < number < sympy.oo):
            shown = f"{float(number):g}" if number.is_real else str(number)
            yield (
                f"{word} of body '{body.name}' is {shown} {unit}; it must be positive and "
                "finite (leave it out where the scene is kinematic)."
            )


def _collisions(model: Model) -> Iterator[str]:
    """Two things that would have one name in the generated text."""
    owners: dict[str, str] = {"t": "the time"}
    declared = [("body", body.name, coordinates_of(body)) for body in model.bodies.values()]
    declared += [("joint", joint.name, own_coordinates(joint)) for joint in model.joints.values()]
    for kind, owner, coordinates in declared:
        for symbol in (s for q in coordinates for s in (q, q.rate)):
            owners[symbol.name] = f"a coordinate or velocity of {kind} '{owner}'"
    for name in model.parameters:
        if name in owners:
            yield f"parameter '{name}' has the name of {owners[name]}; rename it."
