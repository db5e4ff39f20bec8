"""Evaluates a kernel of a large machine level by level: the operations of one kind at once.

As `interpreter.evaluate` with floats, in some NumPy calls a level instead of one Python call an
operation. The levels are those of the graph: operands of a value stand on lower ones.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from codegen.lower.program import Input, Kernel, Op, Program

FloatArray = npt.NDArray[np.float64]
Places = npt.NDArray[np.int64]

FUNCTIONS: dict[Op, Callable[..., FloatArray]] = {
    Op.ADD: np.add, Op.SUB: np.subtract, Op.MUL: np.multiply, Op.DIV: np.divide,
    Op.NEG: np.negative, Op.SIN: np.sin, Op.COS: np.cos, Op.SQRT: np.sqrt,
}  # fmt: skip


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
