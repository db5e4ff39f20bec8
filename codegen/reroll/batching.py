"""A kernel's values → batches: expression trees of one kind, one after the other from tables.

For machines that repeat themselves without a period, as trees of bars and nets of particles do.
Every value passes through the workspace, which costs up to twice the time of straight code; the
code does not grow with the machine at all.
"""

from collections.abc import Mapping

import numpy as np

from codegen.lower.program import Input, Kernel, Op, Program, Value
from codegen.reroll.expression_trees import ExpressionTrees, list_schedule
from codegen.reroll.parts import Batches, Operand, Part, RolledKernel, Slots, Store
from codegen.reroll.sequence import NUMBER, TIME, OperationSequence
from codegen.reroll.workspace import Workspace

LARGEST = 500_000  # layout: rows of a table with two columns; beyond 1e6 entries numba caches none


def batch(
    program: Program, kernel: Kernel, constants: Mapping[int, int], base: int
) -> RolledKernel:
    """The kernel in batches.

    Parameters
    ----------
    program, kernel
        The kernel, and the program of its values.
    constants
        Value → slot in ``p``, of those that the kernel reads there instead of computing them.
    base
        The first slot of the workspace in ``p``.
    """
    return _Batching(program, kernel, constants, base).batched()


class _Batching:
    """The trees of a kernel, their schedule, and the workspace."""

    def __init__(
        self, program: Program, kernel: Kernel, constants: Mapping[int, int], base: int
    ) -> None:
        self.kernel, self.values = kernel, program.values
        self.sequence = OperationSequence(program, kernel, constants)
        self.trees = ExpressionTrees(self.sequence, kernel)
        self.workspace = Workspace(self.sequence, kernel, base)
        self.labels = {label.value: label for label in kernel.labels}

    def batched(self) -> RolledKernel:
        """The parts, the checks and what is returned."""
        schedule = list_schedule(self.trees)
        space, numbers = self.workspace, self.sequence.numbers
        space.need_results(self.kernel.outputs)
        roots = [numbers[[self.trees.trees[k].places[-1] for k in run]] for run in schedule]
        space.need(*(number for run in roots for number in run.tolist()))
        space.assign(run.reshape(-1, 1) for run in roots)
        parts: list[Part | Batches] = [*space.copies_of_leaves()]
        parts += [self._batches(runs) for runs in _shares(schedule)]
        parts += space.copies_of_outputs(o for o in self.kernel.outputs if o.array != "return")
        returned = [out for out in self.kernel.outputs if out.array == "return"]
        result = space.first(returned[0].value) if returned else None
        return RolledKernel(tuple(parts), space.watch(), result, space.size)

    def _batches(self, runs: list[list[int]]) -> Batches:
        rows: dict[int, list[int]] = {}  # trees of each kind, in the order of the runs
        table = []
        for run in runs:
            of_kind = rows.setdefault(self.trees.kinds[run[0]], [])
            table.append((len(of_kind), len(of_kind) + len(run)))
            of_kind += run
        number = {kind: k for k, kind in enumerate(rows)}
        kinds = [number[self.trees.kinds[run[0]]] for run in runs]
        parts = tuple(self._part(trees) for trees in rows.values())
        return Batches(parts, np.column_stack([kinds, np.array(table)]))

    def _part(self, trees: list[int]) -> Part:
        """The part that computes trees of one kind, one a row."""
        chosen = [self.trees.trees[k] for k in trees]
        columns = list(zip(*(tree.leaves for tree in chosen), strict=True))
        body, operands = list[Value](), list[Operand]()
        for column in columns:
            one = self.values[column[0]]
            home = self.sequence.home(column[0])
            if home == TIME or (home == NUMBER and len(set(column)) == 1):
                body.append(one)
                continue
            name = one.literal.name if isinstance(one.literal, Input) else self._label(column[0])
            operands.append(self.workspace.operand(column))
            body.append(Value(Op.INPUT, literal=Input("", len(operands) - 1, name)))
        places = np.array([tree.places for tree in chosen])
        numbers: Slots = self.sequence.numbers[places]
        shift = len(columns)
        for number, (_, *row) in zip(
            numbers[0].tolist(), self.trees.shapes[self.trees.kinds[trees[0]]], strict=True
        ):
            value = self.values[number]
            args = tuple(k + shift if k >= 0 else -1 - k for k in row)
            body.append(Value(value.op, args, value.literal, value.serves))
        store = Store("p", self.workspace.slots[numbers[:, -1]], len(body) - 1)
        return Part(len(trees), tuple(body), tuple(operands), (store,))

    def _label(self, number: int) -> str:
        return self.labels[number].name if number in self.labels else ""


def _shares(schedule: list[list[int]]) -> list[list[list[int]]]:
    """The runs in shares, none with more trees than a table may have rows."""
    shares, room = list[list[list[int]]](), 0
    for run in schedule:
        for begin in range(0, len(run), LARGEST):
            piece = run[begin : begin + LARGEST]
            if len(piece) > room:
                shares.append([])
                room = LARGEST
            shares[-1].append(piece)
            room -= len(piece)
    return shares
