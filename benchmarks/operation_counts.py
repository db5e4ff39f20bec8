"""What kernels cost: operations, and operations weighted by their time, on one yardstick.

Generated kernels are counted by the compiler's ledger. Hand-written twins are counted from their
source with the ledger's rules: signs, conditions, constants and loads are free, a helper costs what
is in it, and a sine or cosine weighs 20.
"""

import ast
import inspect
import textwrap
from collections import Counter
from collections.abc import Iterator
from typing import Any

from codegen.lower.operation_count import WEIGHTS
from codegen.lower.program import Op

FUNCTION = 20
"""Weight of an elementary function, as in `codegen.lower.operation_count.cost`."""


def operations(function: Any) -> int:
    """Arithmetic operations in the source of a compiled function."""
    return sum(_tally(function).values())


def cost(function: Any) -> int:
    """The same, weighted by their time."""
    weights = {"divide": WEIGHTS[Op.DIV], "sqrt": WEIGHTS[Op.SQRT], "plain": 1}
    return sum(number * weights.get(kind, FUNCTION) for kind, number in _tally(function).items())


def _tally(function: Any) -> Counter[str]:
    """Kind of operation → how many."""
    python = getattr(function, "py_func", function)
    tree = ast.parse(textwrap.dedent(inspect.getsource(python)))
    definition: Any = tree.body[0]
    body = [node for statement in definition.body for node in _computed(statement)]
    counts: Counter[str] = Counter()
    for kind in _kinds(body, python.__globals__):
        counts += kind
    return counts


def _computed(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a statement, without those of places in arrays."""
    yield node
    inner = [node.value] if isinstance(node, ast.Subscript) else ast.iter_child_nodes(node)
    for child in inner:
        yield from _computed(child)


def _kinds(nodes: list[ast.AST], names: dict[str, Any]) -> Iterator[Counter[str]]:
    for node in nodes:
        if isinstance(node, ast.BinOp | ast.AugAssign):
            if not (_logical(node) or _constant(node, names)):
                yield Counter(["divide" if isinstance(node.op, ast.Div) else "plain"])
        elif isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name) and hasattr(names.get(node.func.id), "py_func"):
                yield _tally(names[node.func.id])
            else:
                yield Counter([ast.unparse(node.func).rpartition(".")[2]])


def _logical(node: ast.BinOp | ast.AugAssign) -> bool:
    return isinstance(node.op, ast.BitAnd | ast.BitOr)


def _constant(node: ast.AST, names: dict[str, Any]) -> bool:
    """Whether numba computes an expression as it compiles: numbers and names of the module."""
    inner = list(ast.walk(node))
    if any(isinstance(n, ast.Call | ast.AugAssign | ast.Subscript) for n in inner):
        return False
    return all(n.id in names for n in inner if isinstance(n, ast.Name))
