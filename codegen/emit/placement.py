"""Where each value of a kernel is computed: in which branch, on which line.

A value that only one side of a choice needs is computed on that side. A value with one user
becomes part of that user's line while the line stays short.
"""

from collections import defaultdict
from dataclasses import dataclass

from codegen.emit.solution_steps import BESIDE_ELEMENTS, in_steps, labelled
from codegen.lower.program import LEAVES, LOGICAL, Input, Kernel, Op, Program

Path = tuple[tuple[int, bool], ...]
"""The choices, outermost first, inside which something stands."""

WIDTH = 80
"""Characters of an expression, from which on its longest operand has a line of its own."""


@dataclass(frozen=True)
class Placement:
    """The plan of one kernel.

    Attributes
    ----------
    numbers
        Values needed, in order, those of a solution step by step; constants of ``p`` are leaves.
    home
        Value → the branch that it stands in.
    inlined
        Values written inside their only user; a choice inside another is a branch of it.
    pairs
        Sine of an angle → its cosine, and the other way round, where both stand in one branch.
    names, steps
        Of the values of a solution: the names that they have, and the steps that compute them.
    """

    numbers: tuple[int, ...]
    home: dict[int, Path]
    inlined: frozenset[int]
    pairs: dict[int, int]
    names: dict[int, str]
    steps: dict[int, int]


def place(program: Program, kernel: Kernel) -> Placement:
    """Decide the place of every value that `kernel` needs."""
    hoisted = set(program.constants) if kernel.name != "constants" else set()
    numbers, step_of = in_steps(program, kernel, hoisted)
    uses = _uses(program, kernel, numbers, hoisted)
    home = _homes(program, numbers, hoisted, uses)
    pairs = {} if kernel.name == "constants" else _pairs(program, numbers, hoisted, home)
    names = labelled(program, kernel, numbers)
    inlined = _inlined(program, kernel, numbers, hoisted, home, pairs, names)
    return Placement(numbers, home, inlined, pairs, names, step_of)


def _pairs(
    program: Program, numbers: tuple[int, ...], hoisted: set[int], home: dict[int, Path]
) -> dict[int, int]:
    """Sines and cosines of the same angle in the same branch."""
    found: dict[int, int] = {}
    first: dict[tuple[int, Path], int] = {}
    for number in numbers:
        value = program.values[number]
        if value.op in (Op.SIN, Op.COS) and number not in hoisted:
            other = first.setdefault((value.args[0], home[number]), number)
            if other != number:
                found[other], found[number] = number, other
    return found


def _operands(program: Program, number: int, hoisted: set[int]) -> tuple[int, ...]:
    return () if number in hoisted else program.values[number].args


def _uses(
    program: Program, kernel: Kernel, numbers: tuple[int, ...], hoisted: set[int]
) -> dict[int, list[int | None]]:
    """Value → its users; None stands for an output or a check, which are outside all branches."""
    uses: dict[int, list[int | None]] = defaultdict(list)
    for out in kernel.outputs:
        uses[out.value].append(None)
    for check in kernel.checks:
        uses[check.pivot].append(None)
        uses[check.reference].append(None)
    for number in numbers:
        for a in _operands(program, number, hoisted):
            uses[a].append(number)
    return uses


def _homes(
    program: Program,
    numbers: tuple[int, ...],
    hoisted: set[int],
    uses: dict[int, list[int | None]],
) -> dict[int, Path]:
    home: dict[int, Path] = {}
    for number in reversed(numbers):
        paths: list[Path] = []
        for user in set(uses[number]):
            if user is None:
                paths.append(())
            elif program.values[user].op is Op.SELECT:
                condition, yes, no = program.values[user].args
                sides = ((condition, ()), (yes, ((user, True),)), (no, ((user, False),)))
                paths += [home[user] + side for a, side in sides if a == number]
            else:
                paths.append(home[user])
        home[number] = _common(paths)
    return home


def _common(paths: list[Path]) -> Path:
    first = min(paths, key=len)
    for depth, choice in enumerate(first):
        if any(path[depth] != choice for path in paths):
            return first[:depth]
    return first


def _name_width(program: Program, number: int, hoisted: set[int], names: dict[int, str]) -> int:
    """About how long the name of a value is, or a number's digits."""
    value = program.values[number]
    if number in names:
        return len(names[number]) + 2
    if isinstance(value.literal, Input):
        return len(value.literal.name)
    if value.op is Op.CONST:
        return len(str(value.literal))
    if number not in hoisted and value.op in (Op.SIN, Op.COS):
        return _name_width(program, value.args[0], hoisted, names) + 4
    return 6 if number in hoisted or value.serves in BESIDE_ELEMENTS else len(value.serves) + 4


def _inlined(
    program: Program,
    kernel: Kernel,
    numbers: tuple[int, ...],
    hoisted: set[int],
    home: dict[int, Path],
    pairs: dict[int, int],
    names: dict[int, str],
) -> frozenset[int]:
    uses = _uses(program, kernel, numbers, hoisted)
    watched = {v for check in kernel.checks for v in (check.pivot, check.reference)}
    inlined: set[int] = set()
    width: dict[int, int] = {}
    for number in numbers:
        value = program.values[number]
        if number in hoisted or value.op in LEAVES:
            width[number] = _name_width(program, number, hoisted, names)
            continue
        # A choice has lines of its own for each side.
        inside = [] if value.op is Op.SELECT else [a for a in value.args if a in inlined]
        widths = {a: _name_width(program, a, hoisted, names) for a in value.args}
        shown = {a: width[a] if a in inlined else widths[a] for a in value.args}
        while inside and sum(shown[a] + 5 for a in value.args) > WIDTH:
            longest = max(inside, key=lambda a: (shown[a], a))
            inside.remove(longest)
            inlined.discard(longest)
            shown[longest] = widths[longest]
        width[number] = sum(shown[a] + 5 for a in value.args)
        users = uses[number]
        sign = value.op is Op.NEG and program.values[value.args[0]].op in LEAVES
        if value.op in LOGICAL or sign:
            inlined.add(number)
        elif len(users) == 1 and number not in watched and number not in pairs:
            user = users[0]
            if user is not None and program.values[user].op is Op.SELECT:
                if home[number] != home[user]:  # the last line of one of its sides
                    inlined.add(number)
            elif value.op is not Op.SELECT and (user is None or home[user] == home[number]):
                inlined.add(number)
    return frozenset(inlined)
