"""Checks that expressions of a declaration can be compiled."""

from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.functions.elementary.piecewise import ExprCondPair

from codegen.declare.element import Constraint, label
from codegen.declare.returned_values import statement_of
from codegen.declare.symbols import Coordinate, Given, Time, Velocity, kinds
from codegen.derive.piecewise_conditions import KINKED, STEPS, is_known_beforehand
from codegen.lower.sympy_translation import FUNCTIONS
from codegen.readers.expressions import number_problem, unreal_part
from codegen.tables.table_function import Interpolant

KNOWN = ", ".join(sorted({f.__name__ for f in (*FUNCTIONS, *KINKED, *STEPS)}))
ARITHMETIC = (sympy.Symbol, sympy.Number, sympy.NumberSymbol, sympy.Add, sympy.Mul, sympy.Pow)
FINITE = "; give finite real numbers."
UNDEFINED = f"nan{FINITE}"
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
    if found := unreal_part(expression):
        start = "the value" if found[0] == expression else expression
        yield f"{start} {found[1]}{FINITE}"
    elif problem := number_problem(expression):
        yield problem
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, sympy.Piecewise | ExprCondPair):
            stack += [a for a in node.args if a not in (sympy.true, sympy.false)]
            if isinstance(node, sympy.Piecewise):
                yield from _piecewise_problems(node)
        elif isinstance(node, Relational):
            yield from _condition_problems(node, may_switch)
            stack += node.args
        elif isinstance(node, sympy.And | sympy.Or | sympy.Not | sympy.ITE):
            stack += node.args
        elif node.func in KINKED and not (may_switch or is_known_beforehand(node)):
            yield f"{node} has a kink; constraints are smooth in coordinates."
        elif node.func in STEPS and not is_known_beforehand(node):
            yield f"{node} jumps where coordinates say; only the time and parameters may."
        elif isinstance(node, Interpolant):
            if not may_switch:
                yield from _table_problems(node)
            stack.append(node.at)
        elif node.func in (*FUNCTIONS, *KINKED, *STEPS) or isinstance(node, ARITHMETIC):
            stack += node.args
        elif not node.is_number:
            yield f"{node} cannot be compiled; known are {KNOWN}, powers and Piecewise."


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


def _piecewise_problems(node: sympy.Piecewise) -> Iterable[str]:
    for _, condition in node.args:
        if condition.is_Symbol:
            yield f"{condition} is no condition; compare it with something."
    if node.args[-1].cond != sympy.true:
        yield (
            f"{node} says nothing where none of its conditions holds; end it with (value, True)."
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
