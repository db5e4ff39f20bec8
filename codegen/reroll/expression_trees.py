"""The operations of a kernel as expression trees, and the trees of one shape as a kind.

A tree is a value that more than one other takes, or that is stored, with all below it that nothing
else takes. Long sums are cut at each term, so that sums of different lengths are made of the same
trees: whatever a machine looks like, a few dozen kinds are enough.
"""

from typing import NamedTuple

import numpy as np

from codegen.lower.graph import SUMS
from codegen.lower.program import Kernel
from codegen.reroll.sequence import OperationSequence


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
        sequence = self._sequence
        return sequence.home(number) or "p", sequence.is_logical(number)

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
