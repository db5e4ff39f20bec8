"""Where each value of a kernel is computed: in which branch, on which line.

A value that only one side of a choice needs is computed on that side. A value with one user
becomes part of that user's line while the line stays short.
"""

from collections import defaultdict
from itertools import takewhile

from codegen.emit.solution_step_order_and_names import (
    BESIDE_ELEMENTS,
    names_of_solution,
    order_by_steps,
)
from codegen.lower.program import LEAVES, LOGICAL, Input, Kernel, Op, Program

Path = tuple[tuple[int, bool], ...]  # the choices, outermost first, inside which something stands
WIDTH = 80  # characters of an expression, from which on its longest operand has a line of its own


class Placement:
    """The place of every value that a kernel needs; values read from ``p`` are leaves."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self.program, self.kernel = program, kernel
        self.hoisted = program.hoisted(kernel)
        # values needed, in order, those of a solution step by step, and the steps that compute them
        self.numbers, self.steps = order_by_steps(program, kernel, self.hoisted)
        self.names = names_of_solution(program, kernel, self.numbers)  # of values of a solution
        # None stands for an output or a check, which are outside all branches.
        self._uses: dict[int, list[int | None]] = defaultdict(list)
        for root in kernel.roots:
            self._uses[root].append(None)
        for number in self.numbers:
            for a in () if number in self.hoisted else program.values[number].args:
                self._uses[a].append(number)
        self.home = self._homes()  # value → the branch that it stands in
        # sine of an angle → its cosine, and the other way round, in one branch
        self.pairs = {} if kernel.name == "constants" else self._pairs()
        # values inside their only user; a choice inside another is its branch
        self.inlined = self._inlined()

    def _pairs(self) -> dict[int, int]:
        pairs: dict[int, int] = {}
        first: dict[tuple[int, Path], int] = {}
        for number in self.numbers:
            value = self.program.values[number]
            if value.op in (Op.SIN, Op.COS) and number not in self.hoisted:
                other = first.setdefault((value.args[0], self.home[number]), number)
                if other != number:
                    pairs[other], pairs[number] = number, other
        return pairs

    def _homes(self) -> dict[int, Path]:
        home: dict[int, Path] = {}
        for number in reversed(self.numbers):
            paths: list[Path] = []
            for user in set(self._uses[number]):
                if user is None:
                    paths.append(())
                elif self.program.values[user].op is Op.SELECT:
                    condition, yes, no = self.program.values[user].args
                    sides = ((condition, ()), (yes, ((user, True),)), (no, ((user, False),)))
                    paths += [home[user] + side for a, side in sides if a == number]
                else:
                    paths.append(home[user])
            levels = zip(*paths, strict=False)
            shared = takewhile(lambda choices: len(set(choices)) == 1, levels)
            home[number] = tuple(first for first, *_ in shared)
        return home

    def _name_width(self, number: int) -> int:
        """About how long the name of a value is, or a number's digits."""
        value = self.program.values[number]
        if number in self.names:
            return len(self.names[number]) + 2
        if isinstance(value.literal, Input):
            return len(value.literal.name)
        if value.op is Op.CONST:
            return len(str(value.literal))
        if number in self.hoisted:
            return 6
        if value.op in (Op.SIN, Op.COS):
            return self._name_width(value.args[0]) + 4
        return 6 if value.serves in BESIDE_ELEMENTS else len(value.serves) + 4

    def _inlined(self) -> frozenset[int]:
        program, home = self.program, self.home
        watched = {v for check in self.kernel.checks for v in (check.pivot, check.reference)}
        inlined: set[int] = set()
        width: dict[int, int] = {}
        for number in self.numbers:
            value, users = program.values[number], self._uses[number]
            if number in self.hoisted or value.op in LEAVES:
                width[number] = self._name_width(number)
                continue
            # A choice has lines of its own for each side.
            inside = [] if value.op is Op.SELECT else [a for a in value.args if a in inlined]
            shown = {a: width[a] if a in inlined else self._name_width(a) for a in value.args}
            while inside and sum(shown[a] + 5 for a in value.args) > WIDTH:
                longest = max(inside, key=lambda a: (shown[a], a))
                inside.remove(longest)
                inlined.discard(longest)
                shown[longest] = self._name_width(longest)
            width[number] = sum(shown[a] + 5 for a in value.args)
            sign = value.op is Op.NEG and program.values[value.args[0]].op in LEAVES
            fits = value.op in LOGICAL or sign
            if not fits and len(users) == 1 and number not in watched and number not in self.pairs:
                user = users[0]
                if user is not None and program.values[user].op is Op.SELECT:
                    fits = home[number] != home[user]  # the last line of one of its sides
                else:
                    same = user is None or home[user] == home[number]
                    fits = same and value.op is not Op.SELECT
            if fits:
                inlined.add(number)
        return frozenset(inlined)
