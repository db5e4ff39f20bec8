"""Evaluates a program without compiling it, in any arithmetic: floats, complex numbers, mpmath.

The complex step through this interpreter differentiates the very operations that are compiled,
and the build uses it to look at a mechanism before there is any machine code.
"""

import cmath
import math
import operator
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import ModuleType
from typing import Any

from codegen.lower.program import Input, Lookup, Op, Program


def power(base: Any, exponent: Any) -> Any:
    """base ** exponent; as in machine code, no complex number comes of real ones."""
    real = isinstance(base, int | float) and isinstance(exponent, int | float)
    if real and base < 0 and exponent != math.floor(exponent):
        return math.nan
    if real and base == 0 and exponent < 0:
        return math.inf
    return base**exponent


ARITHMETIC: dict[Op, Callable[..., Any]] = {
    Op.ADD: operator.add,
    Op.SUB: operator.sub,
    Op.MUL: operator.mul,
    Op.DIV: operator.truediv,
    Op.NEG: operator.neg,
    Op.NOT: operator.not_,
    Op.SLIDING: lambda mode: mode == 2,
    Op.FLOOR: lambda a: float(math.floor(a.real)),
    Op.LESS: lambda a, b: a.real < b.real,
    Op.POW: power,
    Op.AND: lambda a, b: a and b,
    Op.OR: lambda a, b: a or b,
    Op.SELECT: lambda condition, yes, no: yes if condition else no,
}
NO_FORCES: Mapping[int, float] = defaultdict(float)


FAILURES = (ZeroDivisionError, OverflowError, ValueError)
"""What Python raises where an operation has no value at its operands."""


def evaluate(
    program: Program, name: str, arguments: Mapping[str, Any], functions: ModuleType = cmath,
    failures: tuple[type[Exception], ...] = (),
) -> dict[str, dict[int, Any]]:  # fmt: skip
    """Outputs of the kernel `name`: array → slot → number.

    Of the arguments ``t`` is a number, the other inputs are sequences. ``p`` may hold the declared
    parameters only: what follows from them is computed here. ``stiction``, the forces of frictions
    that stick, is needed by modes of 2 alone. `functions` brings sin, cos …: `cmath`, `math` or an
    mpmath context. An operation that raises one of `failures` yields NaN.
    """
    (kernel,) = (k for k in program.kernels if k.name == name)
    known: dict[int, Any] = {}
    for number in replace(program, constants=()).reachable(kernel):
        value = program.values[number]
        operands = [known[a] for a in value.args]
        match value.literal:
            case Input(array, slot):
                is_given = array != "stiction" or array in arguments
                values = arguments[array] if is_given else NO_FORCES
                known[number] = values if array == "t" else values[slot]
            case Lookup(table, order):
                known[number] = table(operands[0], order)
            case literal if value.op is Op.CONST:
                known[number] = literal
            case literal if value.op is Op.MODE:
                known[number] = arguments["modes"][literal]
            case _:
                function = ARITHMETIC.get(value.op) or getattr(functions, value.op.value)
                try:
                    known[number] = function(*operands)
                except failures:
                    known[number] = math.nan
    outputs: dict[str, dict[int, Any]] = {}
    for out in kernel.outputs:
        outputs.setdefault(out.array, {})[out.slot] = known[out.value]
    return outputs
