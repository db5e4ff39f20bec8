"""A kernel's values → batches: expression trees of one kind, one after the other from tables.

For machines that repeat themselves without a period, as trees of bars and nets of particles do.
Every value passes through the workspace, which costs up to twice the time of straight code; the
code does not grow with the machine at all.

A tree is a value that more than one other takes, or that is stored, with all below it that nothing
else takes. Long sums are cut at each term, so that sums of different lengths are made of the same
trees: whatever a machine looks like, a few dozen kinds are enough.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from codegen.lower.graph import SUMS
from codegen.lower.program import Input, Kernel, Op, Program, Value
from codegen.reroll.parts import WORK, Batches, Operand, Part, RolledKernel, Store, Workspace
from codegen.reroll.sequence import NUMBER, TIME, OperationSequence, Slots

LARGEST = 500_000  # layout: rows of a table with two columns; beyond 1e6 entries numba caches none


class Tree(NamedTuple):
    """An expression: places of its operations, the root last, and the values that it takes."""

    places: tuple[int, ...]
    leaves: tuple[int, ...]


class ExpressionTrees:
    """The trees of a sequence.

    Attributes
    ----------
    trees
        In the order of their roots.
    kinds
        Of each tree, the number of its shape; equal trees have one.
    shapes
        Of each kind, its operations: a code, and for each operand its place in the tree or -1 - its
        place among the leaves.
    tree_of
        Of each place of the sequence, the number of its tree.
    """

    def __init__(self, sequence: OperationSequence, kernel: Kernel) -> None:
        self._sequence = sequence
        rows = sequence.operands.tolist()
        self._operands = [[number for number in row if number >= 0] for row in rows]
        self._place: list[int] = sequence.place.tolist()
        root = self._roots(kernel)
        members: dict[int, list[int]] = {}
        for place, top in enumerate(root):
            members.setdefault(top, []).append(place)
        order = sorted(members)
        number = {top: k for k, top in enumerate(order)}
        self.tree_of = [number[top] for top in root]
        self.trees, self.kinds = list[Tree](), list[int]()
        self.shapes: list[tuple[tuple[int, ...], ...]] = []
        known: dict[object, int] = {}
        for top in order:
            tree, shape = self._shape(members[top])
            sorts = tuple(map(self._sort, tree.leaves))
            if (kind := known.setdefault((shape, sorts), len(known))) == len(self.shapes):
                self.shapes.append(shape)
            self.trees.append(tree)
            self.kinds.append(kind)

    def _roots(self, kernel: Kernel) -> list[int]:
        """Of each place, the place of its tree's root."""
        values, place, numbers = self._sequence.program.values, self._place, self._sequence.numbers
        users: list[set[int]] = [set() for _ in self._operands]
        for user, row in enumerate(self._operands):
            for number in row:
                if place[number] >= 0:
                    users[place[number]].add(user)
        stored = {place[number] for number in kernel.roots}
        is_sum = [values[number].op in SUMS for number in numbers]
        root = list(range(len(users)))
        for k in reversed(root):
            if len(users[k]) == 1 and k not in stored:
                (user,) = users[k]
                if not (is_sum[k] and is_sum[user]):
                    root[k] = root[user]
        return root

    def _shape(self, places: list[int]) -> tuple[Tree, tuple[tuple[int, ...], ...]]:
        within = {place: k for k, place in enumerate(places)}
        leaves: dict[int, int] = {}
        shape = []
        for place in places:
            row = [int(self._sequence.codes[place])]
            for number in self._operands[place]:
                inner = within.get(self._place[number])
                row.append(-1 - leaves.setdefault(number, len(leaves)) if inner is None else inner)
            shape.append(tuple(row))
        return Tree(tuple(places), tuple(leaves)), tuple(shape)

    def _sort(self, number: int) -> tuple[str, bool]:
        """Where a leaf stands, and whether it is a truth value: alike in all trees of a kind."""
        sequence, home = self._sequence, self._sequence.home(number)
        return home if home not in ("", "p") else WORK, sequence.is_logical(number)

    def takes(self, tree: int) -> set[int]:
        """Numbers of the trees whose roots a tree takes."""
        places = (self._place[number] for number in self.trees[tree].leaves)
        return {self.tree_of[place] for place in places if place >= 0}


def list_schedule(trees: ExpressionTrees) -> list[list[int]]:
    """The trees in batches of one kind, each behind all that it takes.

    List scheduling: of the kinds with trees that are ready, the one with the most is next.
    """
    waiting = np.zeros(len(trees.trees), dtype=np.int64).tolist()
    users: list[list[int]] = [[] for _ in waiting]
    for tree in range(len(waiting)):
        for taken in sorted(trees.takes(tree)):
            users[taken].append(tree)
            waiting[tree] += 1
    ready: dict[int, list[int]] = {}
    for tree, count in enumerate(waiting):
        if not count:
            ready.setdefault(trees.kinds[tree], []).append(tree)
    batches = []
    while ready:
        kind = max(ready, key=lambda k: (len(ready[k]), -k))
        batch = ready.pop(kind)
        for tree in batch:  # those of the kind that get ready meanwhile join it
            for user in users[tree]:
                waiting[user] -= 1
                if not waiting[user]:
                    of_kind = trees.kinds[user]
                    (batch if of_kind == kind else ready.setdefault(of_kind, [])).append(user)
        batches.append(batch)
    return batches


class Batching:
    """The trees of a kernel, their schedule, and the workspace.

    `program` is that of its values, `constants` map values that it reads in ``p`` instead of
    computing them to slots there.
    """

    def __init__(self, program: Program, kernel: Kernel, constants: Mapping[int, int]) -> None:
        self.kernel, self.values = kernel, program.values
        self.sequence = OperationSequence(program, kernel, constants)
        self.trees = ExpressionTrees(self.sequence, kernel)
        self.workspace = Workspace(self.sequence, kernel)

    def rolled(self) -> RolledKernel:
        """The kernel in batches."""
        schedule = list_schedule(self.trees)
        space, numbers = self.workspace, self.sequence.numbers
        space.need_results(self.kernel.outputs)
        roots = [numbers[[self.trees.trees[k].places[-1] for k in run]] for run in schedule]
        space.need(*(number for run in roots for number in run.tolist()))
        leaves: dict[int, list[tuple[int, ...]]] = {}  # of the trees of each kind
        for kind, tree in zip(self.trees.kinds, self.trees.trees, strict=True):
            leaves.setdefault(kind, []).append(tree.leaves)
        for column in (column for rows in leaves.values() for column in zip(*rows, strict=True)):
            space.need_column(column)
        space.assign(run.reshape(-1, 1) for run in roots)
        parts: list[Part | Batches] = [*space.copies_of_leaves()]
        parts += [self._batches(runs) for runs in _shares(schedule)]
        parts += space.copies_of_outputs(o for o in self.kernel.outputs if o.array != "return")
        return space.rolled(parts)

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
            operands.append(self.workspace.operand(column))
            name = self.workspace.name(column[0])
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
        store = Store(WORK, self.workspace.slots[numbers[:, -1]], len(body) - 1)
        return Part(len(trees), tuple(body), tuple(operands), (store,))


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
