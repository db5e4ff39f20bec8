"""Checks that expressions of a declaration can be compiled."""

from collections.abc import Iterable, Iterator
from functools import lru_cache

import sympy
from sympy.core.relational import Relational

from codegen.declare.element import Constraint, label
from codegen.declare.expression_rules import compile_problem
from codegen.declare.returned_values import statement_of
from codegen.declare.symbols import Coordinate, Given, Time, Velocity, kinds
from codegen.derive.piecewise_conditions import KINKED, STEPS, is_known_beforehand
from codegen.readers.expressions import distinct_nodes
from codegen.tables.table_function import Interpolant

UNDEFINED = "nan; give finite real numbers."
KEPT = 1000  # measured: expressions whose flaws are known; a machine has fewer different ones


def constraint_problems(constraint: Constraint) -> Iterator[str]:
    """Problems of a constraint: its equations contain coordinates, parameters and time only."""
    where, statement = label(constraint), statement_of(constraint)
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
    """Problems of expressions; an undefined number only where nothing else explains it."""
    problems = [p for e in expressions for p in expression_problems(where, e, may_switch)]
    explained = [problem for problem in problems if not problem.endswith(UNDEFINED)]
    return explained or problems


def expression_problems(where: str, expression: sympy.Basic, may_switch: bool) -> Iterator[str]:
    """Parts of an expression without smooth pieces, or unknown to the compiler."""
    if not expression.is_Symbol:
        yield from (f"{where}: {flaw}" for flaw in _flaws(expression, may_switch))


@lru_cache(KEPT)
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
