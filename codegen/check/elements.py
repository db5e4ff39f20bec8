"""Checks of one joint, driver or effect: its text, bodies and symbols, and what it consists of."""

from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import sympy
from sympy.core.relational import Relational

from codegen.declare import element as el
from codegen.declare.body import Body
from codegen.declare.element_conditions import profile_problems
from codegen.declare.expression_rules import compile_problem
from codegen.declare.returned_kinds import WORDS
from codegen.declare.returned_values import (
    closed_curves,
    conditions_of,
    effect_expressions,
    measures_of,
    optional_terms,
    potential_of,
    problems_of,
    replaced_body,
    statement_of,
)
from codegen.declare.symbols import (
    SPEED,
    Coordinate,
    Given,
    Side,
    Speed,
    Time,
    Velocity,
    alpha,
    kinds,
    side,
    symbols_in,
)
from codegen.derive.piecewise_conditions import KINKED, STEPS, is_known_beforehand
from codegen.errors import ModelError
from codegen.model import Model
from codegen.readers.expressions import distinct_nodes, plain_expression
from codegen.readers.values import nearest, shown
from codegen.tables.table_function import Interpolant

_KEPT = 1000  # measured: expressions whose flaws are known; a machine has fewer different ones


def element_problems(
    model: Model, element: el.Constraint | el.Effect, bodies: tuple[Body, ...],
    known: frozenset[sympy.Symbol],
) -> Iterator[str]:  # fmt: skip
    """Problems of one element, as it says them and as what it returns shows."""
    yield from _words_and_bodies(model, element)
    faults = problems_of(element)
    yield from faults
    if faults:
        return
    asked = [number for condition in conditions_of(element) for number in condition.numbers]
    if isinstance(element, el.Constraint):
        yield from _unknown_symbols(model, element, asked, known)
        yield from _statement_problems(model, element, known)
        yield from _curve_problems(model, element, known)
    else:
        yield from effect_problems(model, element, bodies, known)
        yield from _unknown_symbols(model, element, asked, known)


def effect_problems(
    model: Model, effect: el.Effect, bodies: tuple[Body, ...], known: frozenset[sympy.Symbol]
) -> Iterator[str]:
    """Problems of what an effect returns for the bodies of a scene."""
    potential = potential_of(effect, bodies) or sympy.S.Zero
    for node in sorted(potential.atoms(Interpolant), key=str):
        if node.table.smooth == 0 and kinds(node.at, Coordinate):
            yield (
                f"{el.label(effect)}: its potential contains table '{node.table.name}' of kind "
                "'linear', whose slope, the force, jumps at every point; give it kind='pchip'."
            )
    for speed in kinds(potential, Velocity):
        yield (
            f"{el.label(effect)}: its potential contains the velocity {speed.name}; return a "
            "force that depends on a velocity by forces()."
        )
    answers = optional_terms(effect, bodies)
    if answers.hold:
        known |= {side(effect.name)}
    terms = effect_expressions(effect, bodies)
    along = [f for _, f in answers.pulls]
    along += [m.value for m in measures_of(effect, bodies) or () if m.along is not None]
    yield from _unknown_symbols(model, effect, along, known | {SPEED})
    yield from _unknown_symbols(model, effect, [e for e in terms if e not in along], known)
    yield from all_problems(el.label(effect), terms, may_switch=True)
    if law := answers.friction:
        yield from _law_problems(model, effect, law)


def _law_problems(model: Model, effect: el.Effect, law: el.FrictionLaw) -> Iterator[str]:
    """Check that the joint which rubs has the components of the reaction that press."""
    where, joint = el.label(effect), model.joints.get(law.joint)
    if joint is None:
        yield f"{where} rubs in '{law.joint}', which is no joint of '{model.name}'; name one."
        return
    try:
        reaction = statement_of(joint).reaction
    except ModelError:  # reported where the joint is checked
        return
    components = ["fx", "fy", "torque"] if reaction else []
    if isinstance(reaction, el.ConjugateReaction):
        components = [component for component, _ in reaction.components]
    named = (c for load in law.contacts for entry in load for c, _ in entry)
    for component in dict.fromkeys(c for c in named if c not in components):
        yield (
            f"{where}: the load '{component}' is no component of the reaction of '{law.joint}', "
            f"which has {', '.join(components) or 'none'}."
        )


def _curve_problems(
    model: Model, constraint: el.Constraint, known: frozenset[sympy.Symbol]
) -> Iterator[str]:
    """Check the closed curves of a joint for the parameters' defaults."""
    for where, curve, convex in closed_curves(constraint):
        if curve.body not in constraint.bodies:
            yield f"{el.label(constraint)}: the body of its {where} is none of its bodies."
        shape = curve.at(alpha)
        unknown = [*_unknown_symbols(model, constraint, shape, known | {alpha})]
        yield from unknown
        if not unknown:
            shape = shape.subs(model.defaults)
            problems = profile_problems(shape, closed=True, convex=convex)
            yield from (f"{where}: {problem}" for problem in problems)


def _words_and_bodies(model: Model, element: el.Element) -> Iterator[str]:
    """Check the text of an element's kind, and whose its bodies are."""
    where, bodies = el.label(element), element.bodies
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
    replaced = replaced_body(element)
    if replaced is not None and replaced.fixed:
        yield f"{where}: instead_of is the ground, which always takes part; give a body."
    elif replaced is not None and model.bodies.get(replaced.name) is not replaced:
        yield f"{where}: instead_of is body '{replaced.name}', which is not of this model."
    if isinstance(element, el.Constraint) and len(bodies) == 2 and bodies[0] is bodies[1]:
        yield f"{where} connects body '{bodies[0].name}' with itself; give two different bodies."


def _statement_problems(
    model: Model, constraint: el.Constraint, known: frozenset[sympy.Symbol]
) -> Iterator[str]:
    """Check the form of a statement, its texts in the generated module, and its expressions."""
    where, statement = el.label(constraint), statement_of(constraint)
    expressions: tuple[sympy.Expr, ...] = statement.phi
    reaction = statement.reaction
    if isinstance(reaction, el.JointReaction) and reaction.on.x not in statement.bindings:
        frame = reaction.on.name
        yield (
            f"{where}: its reaction acts on frame {frame}, which its bindings bind to no body; add "
            f"{frame.upper()}.bind(point), or return a ConjugateReaction."
        )
    elif isinstance(reaction, el.JointReaction):
        on, direction = reaction.on, tuple(map(plain_expression, reaction.direction))
        arm = None if reaction.arm is None else tuple(map(plain_expression, reaction.arm))
        size = sympy.Add(*(c**2 for c in direction))
        if len(direction) != 2 or (size.is_number and not abs(float(size) - 1) <= 1e-9):
            yield (
                f"{where}: the direction of its reaction is {direction}; give two components of a "
                "unit vector in global axes."
            )
        if arm is not None and len(arm) != 2:
            yield f"{where}: the arm of its reaction is {arm}; give two components, in m."
        expressions = (*expressions, *direction, *((on.phi, *on.s) if arm is None else arm))
    symbols = _bound_symbols(statement, (*expressions, *statement.bindings.values()))
    bodies = {body.name for body in constraint.bodies}
    for q in sorted((s for s in symbols if isinstance(s, Coordinate)), key=str):
        if q.owner in model.bodies and q.owner not in bodies:
            yield (
                f"{where} uses {q}, but '{q.owner}' is none of its bodies, with which it takes "
                "part in a scene; name it there, too."
            )
    yield from _own_coordinates(constraint, statement)
    others = [*_unknown_symbols(model, constraint, symbols, known), *_equation_problems(constraint)]
    others += _orientations(constraint)
    yield from others or _constant_equations(where, statement)


def _own_coordinates(constraint: el.Constraint, statement: el.Statement) -> Iterator[str]:
    """Coordinates that are not the joint's own, or that their row does not determine."""
    where = el.label(constraint)
    for row, own in statement.own:
        if own.owner != constraint.name:
            yield (
                f"{where}: its own coordinate {own} belongs to '{own.owner}'; bring "
                f"coordinate('{constraint.name}', '{own.letter}')."
            )
        elif own not in _bound_symbols(
            statement,
            [e for e, name in zip(statement.phi, statement.rows, strict=True) if name == row],
        ):
            yield (
                f"{where}: its own coordinate {own} does not occur in the equation '{row}', which "
                "is to determine it; name the row that does."
            )


def _bound_symbols(statement: el.Statement, expressions: Iterable[sympy.Basic]) -> set[Any]:
    """The symbols of expressions whose placeholders are bound."""
    symbols: set[Any] = set().union(*map(symbols_in, expressions))
    meanings: set[Any] = set()
    for place, value in statement.bindings.items():
        if places := symbols_in(place) & symbols:
            symbols -= places
            meanings |= symbols_in(value)
    return symbols | meanings


def _constant_equations(where: str, statement: el.Statement) -> Iterator[str]:
    """Equations without coordinates."""
    for row, phi in zip(statement.rows, statement.phi, strict=True):
        if not any(isinstance(s, Coordinate) for s in _bound_symbols(statement, [phi])):
            yield (
                f"{where}: its equation '{row}', {shown(phi.xreplace(statement.bindings))} = 0, "
                "has no coordinate of the machine, and no motion meets or violates it; leave it "
                "out."
            )


def _orientations(constraint: el.Constraint) -> Iterator[str]:
    """Joints that would turn a particle, or ask for an angle that a body has not."""
    statement = statement_of(constraint)
    for frame in (el.I, el.J):
        at = statement.bindings.get(frame.x)
        body = next((b for b in constraint.bodies if at == b.position[0]), None)
        if not body or (body.turns and body.angle is not None):
            continue
        phi = sympy.Tuple(*statement.phi)
        if not phi.xreplace(dict.fromkeys(frame.s, sympy.S.Zero)).has(frame.phi):
            continue
        if body.angle is None and phi.xreplace(statement.bindings).has(frame.phi):
            letters = ", ".join(q.letter for q in body.coordinates)
            yield (
                f"{el.label(constraint)} asks for the angle of '{body.name}', which "
                f"is oriented by {letters} and counts none; use joints that ask for points and "
                "axes, such as revolute, point-on-line or distance, or model.constraint(...)."
            )
        if not body.turns:
            yield (
                f"{el.label(constraint)} holds an angle of '{body.name}', which is "
                "a particle and has none; use a joint that leaves it free to turn, or a body."
            )


def _unknown_symbols(
    model: Model, element: el.Constraint | el.Effect, expressions: Iterable[sympy.Basic],
    known: frozenset[sympy.Symbol],
) -> Iterator[str]:  # fmt: skip
    """Symbols in expressions that mean nothing in the model."""
    strange = set().union(*map(symbols_in, expressions)) - known
    own = {s for b in element.bodies for q in b.coordinates for s in (q, q.rate)}
    for symbol in sorted(strange - own, key=lambda s: s.name):
        # velocities in constraints are reported as such
        if not (isinstance(element, el.Constraint) and isinstance(symbol, Velocity)):
            yield unknown(model, el.label(element), symbol)


def unknown(model: Model, where: str, symbol: sympy.Symbol) -> str:
    """The sentence about a symbol that means nothing in a model."""
    if isinstance(symbol, Given):
        return f"{where}: the placeholder '{symbol}' is not bound; add it to bindings."
    if isinstance(symbol, Speed | Side):
        meaning = "the rate of a scalar, in a force of pulls()"
        if isinstance(symbol, Side):
            meaning = "the side of an effect, in the forces of the one whose hold() says so"
        return f"{where}: the symbol '{symbol}' stands for {meaning}; nothing else may have it."
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


def _equation_problems(constraint: el.Constraint) -> Iterator[str]:
    """Problems of a constraint: its equations contain coordinates, parameters and time only."""
    where, statement = el.label(constraint), statement_of(constraint)
    fixed = {k: v for k, v in statement.bindings.items() if isinstance(k, Given)}
    expressions = (*statement.phi, *fixed.values())
    yield from all_problems(where, expressions, may_switch=False)
    others = [v for k, v in statement.bindings.items() if k not in fixed]
    yield from all_problems(where, others, may_switch=True)
    for expression in expressions:
        for symbol in kinds(expression, Velocity):
            yield (
                f"{where}: {expression} contains the velocity {symbol}; constraints are equations "
                "of coordinates, parameters and t."
            )
    for meaning in fixed.values():
        moving = [str(s) for s in kinds(meaning, Time, Coordinate)]
        if moving:
            yield (
                f"{where}: {meaning} depends on {', '.join(moving)}, but points, axes, lengths and "
                "angles are fixed: give numbers or expressions of parameters, or write the "
                "equations with model.constraint(...)."
            )


def all_problems(where: str, expressions: Iterable[sympy.Basic], may_switch: bool) -> list[str]:
    """Parts of expressions without smooth pieces, or unknown to the compiler."""
    parts = [e for e in expressions if not e.is_Symbol]
    return [f"{where}: {flaw}" for e in parts for flaw in _flaws(e, may_switch)]


@lru_cache(_KEPT)
def _flaws(expression: sympy.Basic, may_switch: bool) -> tuple[str, ...]:
    """What is wrong with an expression; joints of one kind state the same one."""
    return tuple(_find_flaws(expression, may_switch))


def _find_flaws(expression: sympy.Basic, may_switch: bool) -> Iterator[str]:
    if problem := compile_problem(expression):
        yield problem
    for node in distinct_nodes(expression):
        if isinstance(node, sympy.Piecewise):
            for _, condition in node.args:
                if condition.is_Symbol:
                    yield f"{condition} is no condition; compare it with something."
        elif isinstance(node, Relational):
            yield from _condition_problems(node, may_switch)
        elif node.func in KINKED and not (may_switch or is_known_beforehand(node)):
            yield f"{node} has a kink; constraints are smooth in coordinates."
        elif node.func in STEPS and not is_known_beforehand(node):
            yield f"{node} jumps where coordinates say; only the time and parameters may."
        elif isinstance(node, Interpolant) and not may_switch:
            yield from _table_problems(node)


def _table_problems(node: Interpolant) -> Iterator[str]:
    """What a table lacks where accelerations need its second derivative, and nothing switches."""
    table = node.table
    if is_known_beforehand(node.at) or (table.smooth >= 2 and table.held is None):
        return
    if table.smooth < 2:
        fault, remedy = f"of kind '{table.kind}'", "give it kind='spline'"
    else:
        fault, remedy = "with beyond='hold'", "give it points further out"
    yield (
        f"table '{table.name}' {fault} is taken at {node.at}, where accelerations need "
        f"continuous second derivatives; {remedy}."
    )


def _condition_problems(node: Relational, may_switch: bool) -> Iterable[str]:
    if isinstance(node, sympy.Eq | sympy.Ne):
        yield (
            f"the condition {node} is an equality, which no motion meets for a time; "
            "use an inequality."
        )
    elif not (may_switch or is_known_beforehand(node)):
        yield (
            f"the condition {node} stands where nothing may switch; the pieces of "
            "constraints and motions are chosen by the time and parameters alone."
        )
