"""Checks of one joint, driver or effect: its text, bodies and symbols, and what it consists of."""

from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy.core.relational import Relational

from codegen.check.space import teeth_problems
from codegen.declare import element as el
from codegen.declare.body import Bodies
from codegen.declare.element_fields import profile_problems
from codegen.declare.returned_values import (
    WORDS,
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
    ResultSeries,
    Side,
    Speed,
    Time,
    Velocity,
    alpha,
    kinds,
    side,
    symbols_in,
)
from codegen.declare.value_reader import compile_problem
from codegen.derive.piecewise_conditions import KINKED, STEPS, is_known_beforehand
from codegen.elements.forces.mass_flow import MassLaw
from codegen.elements.space.transmissions import Teeth
from codegen.errors import ModelError
from codegen.readers.expressions import distinct_nodes, plain_expression
from codegen.readers.values import nearest, shown
from codegen.tables.table_function import Interpolant

if TYPE_CHECKING:
    from codegen.model import Model

Element = el.Constraint | el.Effect
_KEPT = 1000  # measured: expressions whose flaws are remembered; a machine has fewer different ones


def element_problems(
    model: "Model", element: Element, bodies: Bodies, known: frozenset[sympy.Symbol]
) -> Iterator[str]:
    """Problems of one element, as it says them and as what it returns shows."""
    check = _ElementCheck(model, element, known)
    yield from check.words_and_bodies()
    faults = problems_of(element)
    yield from faults
    if not faults:
        numbers = [number for condition in conditions_of(element) for number in condition.numbers]
        if isinstance(element, Teeth):
            yield from teeth_problems(model, element)
        if isinstance(element, el.Constraint):
            yield from check.of_statement()
            yield from check.of_curves()
        else:
            yield from check.of_effect(bodies)
        yield from check.unknown_symbols(numbers)


def effect_problems(
    model: "Model", effect: el.Effect, bodies: Bodies, known: frozenset[sympy.Symbol]
) -> Iterator[str]:
    """Problems of what an effect returns for the bodies of a scene."""
    return _ElementCheck(model, effect, known).of_effect(bodies)


class _ElementCheck:
    """What is wrong with what an element of a model returns; `known` symbols mean something."""

    def __init__(self, model: "Model", element: Element, known: frozenset[sympy.Symbol]) -> None:
        self.model, self.element, self.known = model, element, known
        self.where = el.label(element)

    def words_and_bodies(self) -> Iterator[str]:
        """Check the text of the kind, and whose the bodies are."""
        where, model, bodies = self.where, self.model, self.element.bodies
        kind: object = self.element.kind
        if not isinstance(kind, str) or not WORDS.fullmatch(kind):
            reason = f"its kind {shown(kind)} must be a few words of ASCII letters"
            yield f"element {shown(self.element.name)}: {reason}."
        for body in bodies:
            if body.model is not model.token:
                advice = f"use a body of '{model.name}'."
                yield f"{where}: body '{body.name}' belongs to another model; {advice}"
            elif (
                not body.fixed
                and model.bodies.get(body.name) is not body
                and (body.name not in model.noted)
            ):
                yield f"{where}: body '{body.name}' is not declared in '{model.name}'."
        replaced = replaced_body(self.element)
        if replaced is not None and replaced.fixed:
            yield f"{where}: instead_of is the ground, which always takes part; give a body."
        elif replaced is not None and model.bodies.get(replaced.name) is not replaced:
            yield f"{where}: instead_of is body '{replaced.name}', which is not of this model."
        is_joint = isinstance(self.element, el.Constraint)
        if is_joint and len(bodies) == 2 and bodies[0] is bodies[1]:
            name = bodies[0].name
            yield f"{where} connects body '{name}' with itself; give two different bodies."

    def unknown_symbols(
        self, expressions: Iterable[sympy.Basic], *more: sympy.Symbol
    ) -> Iterator[str]:
        """Symbols in expressions that mean nothing in the model, and are not among `more`."""
        strange = set().union(*map(symbols_in, expressions)) - self.known - {*more}
        own = {s for b in self.element.bodies for q in b.coordinates for s in (q, q.rate)}
        for symbol in sorted(strange - own, key=lambda s: s.name):
            # velocities in constraints are reported as such
            if not (isinstance(self.element, el.Constraint) and isinstance(symbol, Velocity)):
                yield unknown(self.model, self.where, symbol)

    def of_effect(self, bodies: Bodies) -> Iterator[str]:
        """Check what an effect returns."""
        effect, where = self.element, self.where
        potential = potential_of(effect, bodies) or sympy.S.Zero
        for node in sorted(potential.atoms(Interpolant), key=str):
            if node.table.smooth == 0 and kinds(node.at, Coordinate):
                yield (
                    f"{where}: its potential contains table '{node.table.name}' of kind 'linear', "
                    "whose slope, the force, jumps at every point; give it kind='pchip'."
                )
        for speed in kinds(potential, Velocity):
            yield (
                f"{where}: its potential contains the velocity {speed.name}; return a force that "
                "depends on a velocity by forces()."
            )
        answers = optional_terms(effect, bodies)
        sides = (side(effect.name),) if answers.hold else ()
        terms = effect_expressions(effect, bodies)
        along = [f for _, f in answers.pulls]
        along += [m.value for m in measures_of(effect, bodies) or () if m.along is not None]
        yield from self.unknown_symbols(along, SPEED, *sides)
        yield from self.unknown_symbols([e for e in terms if e not in along], *sides)
        yield from all_problems(where, terms, may_switch=True)
        if answers.friction:
            yield from self._of_friction(answers.friction)

    def _of_friction(self, law: el.FrictionLaw) -> Iterator[str]:
        """Check that the joint which rubs has the components of the reaction that press."""
        joint = self.model.joints.get(law.joint)
        if joint is None:
            machine = self.model.name
            yield f"{self.where} rubs in '{law.joint}', which is no joint of '{machine}'; name one."
            return
        try:
            reaction = statement_of(joint).reaction
        except ModelError:  # reported where the joint is checked
            return
        components = ["fx", "fy", "torque"] if reaction else []
        if isinstance(reaction, el.WrenchReaction):
            components = ["fx", "fy", "fz", "tx", "ty", "tz"]
        if isinstance(reaction, el.ConjugateReaction):
            components = [component for component, _ in reaction.components]
        named = (c for load in law.contacts for entry in load for c, _ in entry)
        for component in dict.fromkeys(c for c in named if c not in components):
            yield (
                f"{self.where}: the load '{component}' is no component of the reaction of "
                f"'{law.joint}', which has {', '.join(components) or 'none'}."
            )

    def of_curves(self) -> Iterator[str]:
        """Check the closed curves of a joint for the parameters' defaults."""
        for where, curve, convex in closed_curves(self.element):
            if curve.body not in self.element.bodies:
                yield f"{self.where}: the body of its {where} is none of its bodies."
            shape = curve.at(alpha)
            unknown = [*self.unknown_symbols(shape, alpha)]
            yield from unknown
            if not unknown:
                shape = shape.subs(self.model.defaults)
                problems = profile_problems(shape, closed=True, convex=convex)
                yield from (f"{where}: {problem}" for problem in problems)

    def of_statement(self) -> Iterator[str]:
        """Check the form of a statement, its texts in the generated module, and its expressions."""
        where, statement = self.where, statement_of(self.element)
        expressions: tuple[sympy.Expr, ...] = statement.phi
        reaction = statement.reaction
        if isinstance(reaction, el.JointReaction) and reaction.on.x not in statement.bindings:
            frame = reaction.on.name
            yield (
                f"{where}: its reaction acts on frame {frame}, which its bindings bind to no body; "
                f"add {frame.upper()}.bind(point), or return a ConjugateReaction."
            )
        elif isinstance(reaction, el.JointReaction):
            on, direction = reaction.on, tuple(map(plain_expression, reaction.direction))
            arm = None if reaction.arm is None else tuple(map(plain_expression, reaction.arm))
            size = sympy.Add(*(c**2 for c in direction))
            if len(direction) != 2 or (size.is_number and not abs(float(size) - 1) <= 1e-9):
                yield (
                    f"{where}: the direction of its reaction is {direction}; give two components "
                    "of a unit vector in global axes."
                )
            if arm is not None and len(arm) != 2:
                yield f"{where}: the arm of its reaction is {arm}; give two components, in m."
            expressions = (*expressions, *direction, *((on.phi, *on.s) if arm is None else arm))
        symbols = _bound_symbols(statement, (*expressions, *statement.bindings.values()))
        bodies = {body.name for body in self.element.bodies}
        for q in sorted((s for s in symbols if isinstance(s, Coordinate)), key=str):
            if q.owner in self.model.bodies and q.owner not in bodies:
                advice = ", with which it takes part in a scene; name it there, too."
                if isinstance(self.element, MassLaw):
                    advice = f"; declare '{q.owner}' before '{self.element.body.name}'."
                yield f"{where} uses {q}, but '{q.owner}' is none of its bodies{advice}"
        rows = dict(zip(statement.rows, statement.phi, strict=True))
        for row, own in statement.own:
            if own.owner != self.element.name:
                yield (
                    f"{where}: its own coordinate {own} belongs to '{own.owner}'; bring "
                    f"coordinate('{self.element.name}', '{own.letter}')."
                )
            elif row not in rows or own not in _bound_symbols(statement, [rows[row]]):
                yield (
                    f"{where}: its own coordinate {own} does not occur in the equation '{row}', "
                    "which is to determine it; name the row that does."
                )
        others = [*self.unknown_symbols(symbols), *self._of_equations(statement)]
        others += self._orientations(statement)
        yield from others
        for row, phi in {} if others else rows.items():
            if not any(isinstance(s, Coordinate) for s in _bound_symbols(statement, [phi])):
                yield (
                    f"{where}: its equation '{row}', {shown(phi.xreplace(statement.bindings))} = "
                    "0, has no coordinate of the machine, and no motion meets or violates it; "
                    "leave it out."
                )

    def _orientations(self, statement: el.Statement) -> Iterator[str]:
        """Joints that would turn a particle, or ask for an angle that a body has not."""
        phi = sympy.Tuple(*statement.phi)
        for frame in (el.I, el.J):
            at = statement.bindings.get(frame.x)
            body = next((b for b in self.element.bodies if at == b.position[0]), None)
            if not body or (body.turns and body.angle is not None):
                continue
            if not phi.xreplace(dict.fromkeys(frame.s, sympy.S.Zero)).has(frame.phi):
                continue
            if body.angle is None and phi.xreplace(statement.bindings).has(frame.phi):
                letters = ", ".join(q.letter for q in body.coordinates)
                yield (
                    f"{self.where} asks for the angle of '{body.name}', which is oriented by "
                    f"{letters} and counts none; use joints that ask for points and axes, such as "
                    "revolute, point-on-line or distance, or model.constraint(...)."
                )
            if not body.turns:
                yield (
                    f"{self.where} holds an angle of '{body.name}', which is a particle and has "
                    "none; use a joint that leaves it free to turn, or a body."
                )

    def _of_equations(self, statement: el.Statement) -> Iterator[str]:
        """Check that equations contain coordinates, parameters and the time only."""
        where = self.where
        fixed = {k: v for k, v in statement.bindings.items() if isinstance(k, Given)}
        expressions = (*statement.phi, *fixed.values())
        yield from all_problems(where, expressions, may_switch=False)
        others = [v for k, v in statement.bindings.items() if k not in fixed]
        yield from all_problems(where, others, may_switch=True)
        for expression in expressions:
            for symbol in kinds(expression, Velocity):
                yield (
                    f"{where}: {expression} contains the velocity {symbol}; constraints are "
                    "equations of coordinates, parameters and t."
                )
        for meaning in fixed.values():
            if moving := ", ".join(map(str, kinds(meaning, Time, Coordinate))):
                yield (
                    f"{where}: {meaning} depends on {moving}, but points, axes, lengths and angles "
                    "are fixed: give numbers or expressions of parameters, or write the equations "
                    "with model.constraint(...)."
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


def unknown(model: "Model", where: str, symbol: sympy.Symbol) -> str:
    """The sentence about a symbol that means nothing in a model."""
    if isinstance(symbol, Given):
        return f"{where}: the placeholder '{symbol}' is not bound; add it to bindings."
    if isinstance(symbol, Speed | Side | ResultSeries):
        meaning = "the rate of a scalar, in a force of pulls()"
        if isinstance(symbol, Side):
            meaning = "the side of an effect, in the forces of the one whose hold() says so"
        if isinstance(symbol, ResultSeries):
            meaning = "a series of results, in the outputs of a scene"
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


def all_problems(where: str, expressions: Iterable[sympy.Basic], may_switch: bool) -> list[str]:
    """Parts of expressions without smooth pieces, or unknown to the compiler."""
    parts = [e for e in expressions if not e.is_Symbol]
    return [f"{where}: {flaw}" for e in parts for flaw in _flaws(e, may_switch)]


@lru_cache(_KEPT)
def _flaws(expression: sympy.Basic, may_switch: bool) -> list[str]:
    """What is wrong with an expression; joints of one kind state the same one."""
    problem = compile_problem(expression)
    found = [problem] if problem else []
    for node in distinct_nodes(expression):
        if isinstance(node, sympy.Piecewise):
            symbols = (c for _, c in node.args if c.is_Symbol)
            found += [f"{c} is no condition; compare it with something." for c in symbols]
        elif isinstance(node, sympy.Eq | sympy.Ne):
            found.append(
                f"the condition {node} is an equality, which no motion meets for a time; use an "
                "inequality."
            )
        elif isinstance(node, Relational) and not (may_switch or is_known_beforehand(node)):
            found.append(
                f"the condition {node} stands where nothing may switch; the pieces of constraints "
                "and motions are chosen by the time and parameters alone, those of "
                "model.constraint, of powers, sines and cosines, also by coordinates where values "
                "and slopes agree."
            )
        elif node.func in KINKED and not (may_switch or is_known_beforehand(node)):
            found.append(f"{node} has a kink; constraints are smooth in coordinates.")
        elif node.func in STEPS and not is_known_beforehand(node):
            found.append(f"{node} jumps where coordinates say; only the time and parameters may.")
        elif isinstance(node, Interpolant) and not (may_switch or is_known_beforehand(node.at)):
            table = node.table  # accelerations need its second derivative, and nothing switches
            if table.smooth < 2 or table.held is not None:
                fault, remedy = f"of kind '{table.kind}'", "give it kind='spline'"
                if table.smooth >= 2:
                    fault, remedy = "with beyond='hold'", "give it points further out"
                found.append(
                    f"table '{table.name}' {fault} is taken at {node.at}, where accelerations need "
                    f"continuous second derivatives; {remedy}."
                )
    return found
