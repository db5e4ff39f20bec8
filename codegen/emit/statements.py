"""The values of a kernel → the statements that compute them, with branches for choices.

A value that only one side of a choice needs is computed on that side. A value with one user becomes
part of that user's line while the line stays short. Values of a solution have the names of what the
factorization labels; one without a label belongs to the first step that needs it.
"""

import builtins
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from itertools import takewhile

from codegen.emit.line_wrapping import (
    PAGE,
    comments,
    identifier,
    literal,
    prose,
    wrap_pieces,
    wrap_statement,
)
from codegen.emit.module_functions import SIN_COS
from codegen.lower.graph import SUMS
from codegen.lower.program import LEAVES, LOGICAL, Input, Kernel, Lookup, Op, Program

BESIDE_ELEMENTS = {
    "factorization": "Factorization of M, Φ_q",
    "correction": "Factorization of Φ_q W Φ_qᵀ",
    "masses": "Masses",
    "reduction": "Coordinates by those that are left",
    "": "Sums",
}
"""The heading of values that serve no element; the others are called after their element."""

PREFIXES = {"factorization": "f", "correction": "c", "masses": "m", "reduction": "r", "": "s"}
"""The beginning of the names of values that serve no element, such as ``f_1``."""

LONGEST = 36  # characters of a name; values with longer ones are numbered


def names_of_solution(program: Program, kernel: Kernel, numbers: tuple[int, ...]) -> dict[int, str]:
    """Value → its name, among the `numbers` that a kernel needs and that bear no element's name."""
    values = program.values
    named = [(label.value, label.name) for label in kernel.labels]
    negative = [(k, name) for k, name in named if values[k].op is Op.NEG]
    named += [(values[k].args[0], f"minus_{name}") for k, name in negative]  # signs are outside
    names = {number: name for number, name in reversed(named) if _has_label(program, number)}
    return {k: names[k] for k in numbers if k in names and len(names[k]) <= LONGEST}


def _has_label(program: Program, number: int) -> bool:
    value = program.values[number]
    named = value.op in LEAVES or value.op in (Op.SIN, Op.COS)
    return not named and value.serves in BESIDE_ELEMENTS


def order_by_steps(
    program: Program, kernel: Kernel, hoisted: frozenset[int]
) -> tuple[tuple[int, ...], dict[int, int]]:
    """The values that a kernel needs, step by step, and the step of each value of a solution.

    Values are numbered as they were first asked for, perhaps by another kernel or by an order of
    elimination that was given up; a reader wants those of one step together.
    """
    numbers = program.reachable(kernel)
    if not kernel.steps:
        return numbers, {}
    last = len(kernel.steps) - 1
    own: dict[int, int] = {}
    for label in kernel.labels:
        value = program.values[label.value]
        own.setdefault(label.value, label.step)
        if value.op is Op.NEG:
            own.setdefault(value.args[0], label.step)
    found: dict[int, int] = {}
    for number in reversed(numbers):
        found[number] = min(own.get(number, last), found.get(number, last))
        if number not in hoisted:
            for a in program.values[number].args:
                found[a] = min(found.get(a, last), found[number])
    steps = {number: step for number, step in found.items() if _has_label(program, number)}
    place: dict[int, int] = {}
    for number in numbers:
        args = () if number in hoisted else program.values[number].args
        place[number] = steps.get(number, max((place[a] for a in args), default=-1))
    return tuple(sorted(numbers, key=lambda number: (place[number], number))), steps


Path = tuple[tuple[int, bool], ...]  # the choices, outermost first, inside which something stands
WIDTH = 80  # characters of an expression, from which on its longest operand has a line of its own
NOTHING, EITHER, BOTH, NEGATION, SUM, PRODUCT, SIGN = range(7)
"""How tightly a piece of text holds together; looser pieces inside tighter ones take brackets."""
UNARY = {Op.NOT: ("not ", NEGATION, NEGATION), Op.NEG: ("-", SUM, SIGN)}
BINARY = {
    Op.ADD: ("+", SUM, 1),
    Op.SUB: ("-", SUM, 1),
    Op.MUL: ("*", PRODUCT, 1),
    Op.DIV: ("/", PRODUCT, 1),
    Op.AND: ("and", BOTH, 0),
    Op.OR: ("or", EITHER, 0),
    Op.LESS: ("<", NEGATION, 1),
}
ARGUMENTS = "t q v p w a g dq dv nu phi lam out rate gamma low high Q modes values"
WORDS = "math numba and or not if else return in is for def pass del as WEAK_PIVOT OPTIONS"
RESERVED = {*f"{ARGUMENTS} {WORDS} {SIN_COS}".split(), *dir(builtins)}
"""Names that no value may take: those of any kernel's arguments, of the language and the module."""


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


class Scope:
    """The names of a function: each is taken once."""

    def __init__(self, arguments: Iterable[str]) -> None:
        self._taken = {*RESERVED, *arguments}
        self.counts: dict[str, int] = {}

    def unused(self, name: str) -> str:
        """The name, with a mark behind it where it is taken."""
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return identifier(name)

    def counted(self, stem: str) -> str:
        """The stem with the next number that makes it a name of its own."""
        while True:
            self.counts[stem] = self.counts.get(stem, 0) + 1
            if (name := f"{stem}_{self.counts[stem]}") not in self._taken:
                return self.unused(name)


class Statements:
    """Writes the values of one kernel, `depth` levels inside a function.

    What the kernel reads has its name in `names` before the first line is written.
    """

    def __init__(
        self, program: Program, kernel: Kernel, scope: Scope, lookups: Mapping[Lookup, str],
        depth: int = 1,
    ) -> None:  # fmt: skip
        self.program, self.kernel, self.scope, self.depth = program, kernel, scope, depth
        self.plan, self.values = Placement(program, kernel), program.values
        self.constants: Mapping[int, int] = {}  # values that are read from `p` → their slots there
        self.names: dict[int, str] = {}
        self._lookups = lookups
        self._step = -1

    def statements(self) -> Iterator[str]:
        """All lines that compute values."""
        yield from self._angles()
        yield from self._block((), self.depth)

    def _angles(self) -> Iterator[str]:
        """Sines and cosines of what is given: no element's own, they stand above all headings."""
        for number in self.plan.numbers:
            value, outside = self.values[number], self.plan.home[number] == ()
            given = value.op in (Op.SIN, Op.COS) and value.args[0] in self.names
            if given and outside and self._has_line(number):
                yield from self._line(number, self.depth)

    def _has_line(self, number: int) -> bool:
        """Whether a value has a line of its own, and not written yet."""
        leaf = self.values[number].op in LEAVES or number in self.constants
        return not (leaf or number in self.plan.inlined or number in self.names)

    def _line(self, number: int, depth: int) -> Iterator[str]:
        """The line, or the lines, that compute a value."""
        value, indent = self.values[number], "    " * depth
        if number in self.plan.pairs:
            yield from self._pair(number, indent)
        elif value.op is Op.SELECT:
            self.names[number] = self._name(number)
            yield from self._choice(number, self.names[number], depth)
        else:
            text = self._expression(number)
            self.names[number] = self._name(number)
            yield from wrap_statement(f"{indent}{self.names[number]} = ", text)

    def _block(self, path: Path, depth: int) -> Iterator[str]:
        serves = None
        indent = "    " * depth
        for number in self.plan.numbers:
            value = self.values[number]
            if self.plan.home[number] != path or not self._has_line(number):
                continue
            if depth == self.depth and number in self.plan.steps:
                yield from self._titles(self.plan.steps[number])
                serves = None
            elif depth == self.depth and value.serves != serves:
                serves = value.serves
                yield f"{indent}# {prose(BESIDE_ELEMENTS.get(serves, serves))}"
            yield from self._line(number, depth)

    def _titles(self, step: int) -> Iterator[str]:
        """A comment on the steps of the solution up to this one."""
        busy = set(self.plan.steps.values())
        titles = enumerate(self.kernel.steps[: step + 1])
        new = ((k, title) for k, title in titles if k > self._step)
        always = ("Eliminate", "Solve")
        yield from comments(
            [prose(title) for k, title in new if k in busy or title.startswith(always)]
        )
        self._step = max(step, self._step)

    def _pair(self, number: int, indent: str) -> Iterator[str]:
        """The line that takes sine and cosine of an angle."""
        both = sorted((number, self.plan.pairs[number]), key=lambda k: self.values[k].op is Op.COS)
        angle = self._text(self.values[number].args[0], NOTHING)
        for one in both:
            self.names[one] = self._name(one)
        sine, cosine = (self.names[one] for one in both)
        yield from wrap_pieces(f"{indent}{sine}, {cosine} = {SIN_COS}(", [angle], ")")

    def _choice(self, number: int, name: str, depth: int) -> Iterator[str]:
        """Lines that set `name` to the value of a choice."""
        condition, first, last = self.values[number].args
        path, indent = self.plan.home[number], "    " * depth
        test = self._text(condition, NOTHING)
        (yes_before, yes), (no_before, no) = (
            self._side(branch, (*path, (number, side)), name, depth + 1)
            for side, branch in ((True, first), (False, last))
        )
        if not yes_before and not no_before and len(yes) == len(no) == 1:
            one, other = (line.partition(" = ")[2] for line in (*yes, *no))
            one = f"({one})" if self._is_nested_choice(first) else one
            short = f"{indent}{name} = {one} if {test} else {other}"
            if len(short) <= PAGE:
                yield short
                return
        yield f"{indent}if {test}:"
        yield from (*yes_before, *yes)
        if self._is_nested_choice(last) and not no_before and no[0].strip().startswith("if "):
            yield f"{indent}el{no[0].strip()}"
            yield from (line.removeprefix("    ") for line in no[1:])
        else:
            yield f"{indent}else:"
            yield from (*no_before, *no)

    def _side(self, number: int, path: Path, name: str, depth: int) -> tuple[list[str], list[str]]:
        """One side of a choice: the lines that it needs first, and those that set `name`."""
        before = list(self._block(path, depth))
        if self._is_nested_choice(number):
            return before, list(self._choice(number, name, depth))
        text = self._text(number, NOTHING)
        return before, list(wrap_statement(f"{'    ' * depth}{name} = ", text))

    def _is_nested_choice(self, number: int) -> bool:
        """Whether a side of a choice is a further choice, with the same name to set."""
        return self.values[number].op is Op.SELECT and number in self.plan.inlined

    def _text(self, number: int, outer: int) -> str:
        if number in self.names:
            return self.names[number]
        if number in self.plan.inlined or self.values[number].op is Op.CONST:
            return self._expression(number, outer)
        raise KeyError(f"value {number} of kernel {self.kernel.name} is used before it is computed")

    def _expression(self, number: int, outer: int = NOTHING) -> str:
        value = self.values[number]
        if value.op is Op.CONST:
            text = literal(value.literal)
            level = SUM if text.startswith("-") else SIGN
        elif value.op is Op.NOT and (
            value.args[0] not in self.names and self.values[value.args[0]].op is Op.SLIDING
        ):
            mode = self.values[value.args[0]].args[0]
            text, level = f"{self._text(mode, SIGN)} != 2", NEGATION
        elif value.op in UNARY:
            word, level, inner = UNARY[value.op]
            text = f"{word}{self._text(value.args[0], inner)}"
        elif value.op is Op.SLIDING:
            text, level = f"{self._text(value.args[0], SIGN)} == 2", NEGATION
        elif value.op is Op.FLOOR:  # of the type of its argument, unlike math.floor
            text, level = f"{self._text(value.args[0], PRODUCT)} // 1.0", PRODUCT
        elif value.op in BINARY:
            sign, level, tighter = BINARY[value.op]
            a, b = value.args
            if value.op is Op.ADD and self._is_sum(b) and not self._is_sum(a):
                a, b = b, a  # the same sum without brackets
            text = f"{self._text(a, level)} {sign} {self._text(b, level + tighter)}"
        else:
            arguments = ", ".join(self._text(a, NOTHING) for a in value.args)
            function = f"math.{value.op.value}"
            if isinstance(value.literal, Lookup):
                function = self._lookups[value.literal]
            text, level = f"{function}({arguments})", SIGN
        return f"({text})" if level < outer else text

    def _is_sum(self, number: int) -> bool:
        return number in self.plan.inlined and self.values[number].op in SUMS

    def _name(self, number: int) -> str:
        value, counts = self.values[number], self.scope.counts
        if number in self.plan.names:  # with a number behind it: an entry that changes again
            name = self.plan.names[number]
            counts[name] = counts.get(name, 0) + 1
            return self.scope.unused(name if counts[name] == 1 else f"{name}_{counts[name]}")
        if value.op in (Op.SIN, Op.COS) and value.args[0] in self.names:
            return self.scope.unused(f"{value.op.value}_{self.names[value.args[0]]}")
        return self.scope.counted(PREFIXES.get(value.serves, value.serves))
