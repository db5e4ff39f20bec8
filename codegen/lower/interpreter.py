"""Evaluates a program without compiling it, in any arithmetic: floats, complex numbers, mpmath.

The complex step through this interpreter differentiates the very operations that are compiled,
and the build uses it to look at a mechanism before there is any machine code. A kernel of a large
machine is evaluated level by level, the operations of one kind at once: as by `evaluate` with
floats, in some NumPy calls a level instead of one Python call an operation. The levels are those of
the graph: operands of a value stand on lower ones.
"""

import cmath
import math
import operator
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.lower.program import Input, Kernel, Lookup, Op, Program

NO_FORCES: Mapping[int, float] = defaultdict(float)
FAILURES = (ZeroDivisionError, OverflowError, ValueError)
"""What Python raises where an operation has no value at its operands."""
FloatArray = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]
FUNCTIONS: dict[Op, Callable[..., FloatArray]] = {
    Op.ADD: np.add, Op.SUB: np.subtract, Op.MUL: np.multiply, Op.DIV: np.divide,
    Op.NEG: np.negative, Op.SIN: np.sin, Op.COS: np.cos, Op.SQRT: np.sqrt,
}  # fmt: skip


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


class LevelEvaluation:
    """The values of one kernel, which `suits` if it has these functions only.

    Attributes
    ----------
    suits
        Whether all operations are among `FUNCTIONS`.
    calls
        Calls of NumPy an evaluation, besides those that collect inputs and outputs.
    """

    def __init__(self, program: Program, kernel: Kernel) -> None:
        numbers = [*replace(program, constants=()).reachable(kernel)]
        self.place = {number: at for at, number in enumerate(numbers)}
        values = [program.values[number] for number in numbers]
        level: list[int] = []
        operations: defaultdict[tuple[int, Op], list[int]] = defaultdict(list)
        inputs: defaultdict[str, list[tuple[int, int]]] = defaultdict(list)
        self.known = np.zeros(len(numbers))
        self.suits = True
        for at, value in enumerate(values):
            operands = [self.place[a] for a in value.args]
            level.append(1 + max((level[a] for a in operands), default=-1))
            if isinstance(value.literal, Input):
                inputs[value.literal.array].append((at, value.literal.slot))
            elif value.op is Op.CONST:
                self.known[at] = float(value.literal)  # type: ignore[arg-type]
            elif value.op in FUNCTIONS and value.literal is None:
                operations[level[at], value.op].append(at)
            else:
                self.suits = False
        self.suits = self.suits and inputs.keys() <= {"t", "q", "p"}
        self.inputs = {array: np.array(rows, np.int64).T for array, rows in inputs.items()}
        self.steps: list[tuple[Op, Places, list[Places]]] = []
        for (_, op), places in sorted(operations.items(), key=lambda item: item[0][0]):
            rows = np.array([[self.place[a] for a in values[at].args] for at in places], np.int64)
            self.steps.append((op, np.array(places, np.int64), [*rows.T]))
        self.calls = len(self.steps)
        outputs = sorted(kernel.outputs, key=lambda out: out.slot)
        self.outputs = np.array([self.place[out.value] for out in outputs], np.int64)

    def __call__(self, t: float, q: FloatArray, p: FloatArray) -> FloatArray:
        """The kernel's outputs by slots; not finite where an operation has no value."""
        known = self.known.copy()
        for array, (places, slots) in self.inputs.items():
            known[places] = t if array == "t" else (q if array == "q" else p)[slots]
        with np.errstate(all="ignore"):
            for op, places, operands in self.steps:
                known[places] = FUNCTIONS[op](*(known[of] for of in operands))
        return known[self.outputs]
