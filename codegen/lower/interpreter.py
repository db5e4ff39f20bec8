"""Evaluates a program without compiling it, in any arithmetic: floats, complex numbers, mpmath.

The complex step through this interpreter differentiates the very operations that are compiled,
and the build uses it to look at a mechanism before there is any machine code.
"""

import cmath
import operator
from collections.abc import Callable, Mapping
from functools import partial
from types import ModuleType
from typing import Any

from codegen.lower.program import FUNCTIONS, Input, Kernel, Lookup, Op, Program

ARITHMETIC: dict[Op, Callable[..., Any]] = {
    Op.ADD: operator.add,
    Op.SUB: operator.sub,
    Op.MUL: operator.mul,
    Op.DIV: operator.truediv,
    Op.NEG: operator.neg,
    Op.NOT: operator.not_,
    Op.HELD: lambda mode: mode == 2,
    Op.POW: operator.pow,
    Op.AND: lambda a, b: a and b,
    Op.OR: lambda a, b: a or b,
    Op.SELECT: lambda condition, yes, no: yes if condition else no,
}


def evaluate(
    program: Program,
    name: str,
    arguments: Mapping[str, Any],
    functions: ModuleType = cmath,
) -> dict[str, dict[int, Any]]:
    """Outputs of the kernel `name`: array → slot → number.

    Parameters
    ----------
    arguments
        ``t`` a number, the other inputs sequences. ``p`` may hold the declared parameters only:
        what follows from them is computed here. ``held``, the forces of what is held, is needed
        by modes of 2 alone.
    functions
        Where sin, cos … come from: `cmath`, `math` or an mpmath context.
    """
    (kernel,) = (k for k in program.kernels if k.name == name)
    numbers = _needed(program, kernel)
    known: dict[int, Any] = {}
    for number in numbers:
        value = program.values[number]
        if value.op is Op.CONST:
            known[number] = value.literal
        elif isinstance(value.literal, Input):
            known[number] = _slot(arguments, value.literal)
        elif value.op is Op.MODE:
            known[number] = arguments["modes"][value.literal]
        else:
            operands = [known[a] for a in value.args]
            function = ARITHMETIC.get(value.op)
            if isinstance(value.literal, Lookup):
                function = partial(value.literal.table, order=value.literal.order)
            if function is None:
                assert value.op in FUNCTIONS
                function = getattr(functions, value.op.value)
            known[number] = function(*operands)
    outputs: dict[str, dict[int, Any]] = {}
    for out in kernel.outputs:
        outputs.setdefault(out.array, {})[out.slot] = known[out.value]
    return outputs


def _slot(arguments: Mapping[str, Any], slot: Input) -> Any:
    if slot.array == "held" and slot.array not in arguments:
        return 0.0
    values = arguments[slot.array]
    return values if slot.array == "t" else values[slot.slot]


def _needed(program: Program, kernel: Kernel) -> list[int]:
    whole = Program(program.values, program.kernels, (), program.weak_pivot)
    return list(whole.reachable(kernel))
