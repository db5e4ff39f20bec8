"""One kernel → the text of one numba function."""

import builtins
from collections.abc import Iterator

from codegen.emit.argument_docstrings import Arguments
from codegen.emit.line_wrapping import (
    PAGE,
    assigned_text,
    comments,
    note_of,
    quantity,
    wrap_pieces,
    wrap_statement,
)
from codegen.emit.placement import Path, Placement, place
from codegen.emit.readable_formula import formula
from codegen.emit.sincos_function import NAME as SIN_COS
from codegen.emit.table_lookup import lookups
from codegen.lower.operation_count import operations
from codegen.lower.program import LEAVES, Input, Kernel, Lookup, Op, Program

NOTHING, EITHER, BOTH, NEGATION, SUM, PRODUCT, SIGN = range(7)
"""How tightly a piece of text holds together; looser pieces inside tighter ones take brackets."""

BINARY = {
    Op.ADD: ("+", SUM, 1),
    Op.SUB: ("-", SUM, 1),
    Op.MUL: ("*", PRODUCT, 1),
    Op.DIV: ("/", PRODUCT, 1),
    Op.AND: ("and", BOTH, 0),
    Op.OR: ("or", EITHER, 0),
}
ARGUMENTS = "t q v p w a g dq dv nu phi lam out rate gamma low high Q modes values"
WORDS = "math numba and or not if else return in is for def pass del as WEAK_PIVOT OPTIONS"
RESERVED = {*f"{ARGUMENTS} {WORDS} {SIN_COS}".split(), *dir(builtins)}
"""Names that no value may take: those of any kernel's arguments, of the language and the module."""

TITLES = {
    "factorization": "Factorization of M, Φ_q",
    "correction": "Factorization of Φ_q W Φ_qᵀ",
    "masses": "Masses",
    "reduction": "Coordinates by those that are left",
    "": "Sums",
}
NOTE_WIDTH = 60
SHORT = {"factorization": "f", "correction": "c", "reduction": "r", "masses": "m", "": "s"}


class KernelText:
    """Writes one kernel, with the shapes and units of its arguments."""

    def __init__(self, program: Program, kernel: Kernel, arguments: Arguments) -> None:
        self.program, self.kernel, self.arguments = program, kernel, arguments
        self.plan: Placement = place(program, kernel)
        hoisted = program.hoisted(kernel)
        slots = {number: arguments.declared + k for k, number in enumerate(program.constants)}
        self.constants: dict[int, int] = {n: slots[n] for n in self.plan.numbers if n in hoisted}
        self.names: dict[int, str] = {}
        self._lookups = lookups(program)
        self._taken: set[str] = {*RESERVED, *kernel.arguments, *self._lookups.values()}
        self._counts: dict[str, int] = {}
        self._step = -1

    def lines(self) -> list[str]:
        """The function, line by line."""
        kernel = self.kernel
        count = operations(self.program, kernel)
        text = [
            f'@numba.njit("{signature(kernel)}", **OPTIONS)',
            f"def {kernel.name}({', '.join(kernel.arguments)}):",
            f'    """{kernel.summary}',
            "",
            *(f"    {line}" for line in self.arguments.lines(self.program, kernel)),
            f"    {quantity(count, 'operation')}.",
            '    """',
        ]
        before = [*self._loads(), *self._angles()]
        return [*text, *before, *self._block((), 1), *self._stores(), *self._watch()]

    # -- parts -------------------------------------------------------------------------------

    def _loads(self) -> Iterator[str]:
        for number in self.plan.numbers:
            literal = self.program.values[number].literal
            if number in self.constants:
                name = self.names[number] = self._unused(f"p_{self.constants[number]}")
                meaning = formula(self.program, number)
                note = f"  # {meaning}" if len(meaning) <= NOTE_WIDTH else ""
                yield f"    {name} = p[{self.constants[number]}]{note}"
            elif isinstance(literal, Input):
                wanted = "t" if literal.array == "t" else literal.name
                self.names[number] = name = "t" if wanted == "t" else self._unused(wanted)
                if literal.array != "t":
                    yield f"    {name} = {literal.array}[{literal.slot}]"
            elif self.program.values[number].op is Op.MODE:
                # Read before the first branch: numba counts references to an array behind one.
                self.names[number] = name = self._unused(f"mode_{literal}")
                yield f"    {name} = modes[{literal}]"

    def _angles(self) -> Iterator[str]:
        """Sines and cosines of what is given: no element's own, they stand above all headings."""
        for number in self.plan.numbers:
            value = self.program.values[number]
            if value.op not in (Op.SIN, Op.COS) or value.args[0] not in self.names:
                continue
            if self.plan.home[number] == () and self._has_line(number):
                yield from self._line(number, 1)

    def _has_line(self, number: int) -> bool:
        """Whether a value has a line of its own, and not written yet."""
        leaf = self.program.values[number].op in LEAVES or number in self.constants
        return not (leaf or number in self.plan.inlined or number in self.names)

    def _line(self, number: int, depth: int) -> Iterator[str]:
        """The line, or the lines, that compute a value."""
        value, indent = self.program.values[number], "    " * depth
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
            value = self.program.values[number]
            if self.plan.home[number] != path or not self._has_line(number):
                continue
            if depth == 1 and number in self.plan.steps:
                yield from self._titles(self.plan.steps[number])
                serves = None
            elif depth == 1 and value.serves != serves:
                serves = value.serves
                yield f"{indent}# {TITLES.get(serves, serves)}"
            yield from self._line(number, depth)

    def _titles(self, step: int) -> Iterator[str]:
        """A comment on the steps of the solution up to this one."""
        titles = self.kernel.steps[self._step + 1 : step + 1]
        busy = set(self.plan.steps.values())
        kept = (
            title
            for k, title in enumerate(titles, self._step + 1)
            if k in busy or title.startswith(("Eliminate", "Solve"))
        )
        self._step = max(step, self._step)
        yield from comments(tuple(kept))

    def _pair(self, number: int, indent: str) -> Iterator[str]:
        """The line that takes sine and cosine of an angle."""
        both = sorted((number, self.plan.pairs[number]), key=self._is_cosine)
        angle = self._text(self.program.values[number].args[0], NOTHING)
        for one in both:
            self.names[one] = self._name(one)
        sine, cosine = (self.names[one] for one in both)
        yield from wrap_pieces(f"{indent}{sine}, {cosine} = {SIN_COS}(", [angle], ")")

    def _is_cosine(self, number: int) -> bool:
        return self.program.values[number].op is Op.COS

    def _choice(self, number: int, name: str, depth: int) -> Iterator[str]:
        """Lines that set `name` to the value of a choice."""
        value = self.program.values[number]
        path, indent = self.plan.home[number], "    " * depth
        test = self._text(value.args[0], NOTHING)
        (yes_before, yes), (no_before, no) = (
            self._side(branch, (*path, (number, side)), name, depth + 1)
            for side, branch in ((True, value.args[1]), (False, value.args[2]))
        )
        if not yes_before and not no_before and len(yes) == len(no) == 1:
            first = (
                f"({assigned_text(yes)})"
                if self._is_nested_choice(value.args[1])
                else assigned_text(yes)
            )
            short = f"{indent}{name} = {first} if {test} else {assigned_text(no)}"
            if len(short) <= PAGE:
                yield short
                return
        yield f"{indent}if {test}:"
        yield from (*yes_before, *yes)
        if (
            self._is_nested_choice(value.args[2])
            and not no_before
            and no[0].strip().startswith("if ")
        ):
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
        return self.program.values[number].op is Op.SELECT and number in self.plan.inlined

    def _stores(self) -> Iterator[str]:
        stores = [out for out in self.kernel.outputs if out.array != "return"]
        if stores:
            yield "    # Outputs"
        for out in stores:
            text = self._text(out.value, NOTHING)
            yield from wrap_statement(f"    {out.array}[{out.slot}] = ", text, note_of(out))
        for out in self.kernel.outputs:
            if out.array == "return":
                yield from wrap_statement("    return ", self._text(out.value, NOTHING))

    def _watch(self) -> Iterator[str]:
        if not self.kernel.watched:
            return
        for check in self.kernel.checks:
            pivot = self._text(check.pivot, SUM)
            reference = self._text(check.reference, SIGN)
            limit = "WEAK_PIVOT" if check.part == 1.0 else f"{check.part!r} * WEAK_PIVOT"
            yield f"    if not {pivot} > {limit} * {reference}:"
            yield f"        return {1 + check.constraint}"
        yield "    return 0"

    # -- expressions -------------------------------------------------------------------------

    def _text(self, number: int, outer: int) -> str:
        if number in self.names:
            return self.names[number]
        if number in self.plan.inlined or self.program.values[number].op is Op.CONST:
            return self._expression(number, outer)
        raise KeyError(f"value {number} of kernel {self.kernel.name} is used before it is computed")

    def _expression(self, number: int, outer: int = NOTHING) -> str:
        value = self.program.values[number]
        if value.op is Op.CONST:
            text, level = repr(value.literal), SIGN
            level = SUM if text.startswith("-") else SIGN
        elif value.op in (Op.NOT, Op.NEG):
            word, level, inner = (
                ("not ", NEGATION, NEGATION) if value.op is Op.NOT else ("-", SUM, SIGN)
            )
            text = f"{word}{self._text(value.args[0], inner)}"
        elif value.op is Op.SLIDING:
            text, level = f"{self._text(value.args[0], SIGN)} == 2", NEGATION
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
        sums = (Op.ADD, Op.SUB, Op.NEG)
        return number in self.plan.inlined and self.program.values[number].op in sums

    # -- names -------------------------------------------------------------------------------

    def _name(self, number: int) -> str:
        value = self.program.values[number]
        if number in self.plan.names:
            return self._numbered(self.plan.names[number])
        if value.op in (Op.SIN, Op.COS) and value.args[0] in self.names:
            return self._unused(f"{value.op.value}_{self.names[value.args[0]]}")
        stem = SHORT.get(value.serves, value.serves)
        while True:
            self._counts[stem] = self._counts.get(stem, 0) + 1
            name = f"{stem}_{self._counts[stem]}"
            if name not in self._taken:
                return self._unused(name)

    def _numbered(self, name: str) -> str:
        """The name, or with a number behind it: an entry that changes again."""
        count = self._counts[name] = self._counts.get(name, 0) + 1
        return self._unused(name if count == 1 else f"{name}_{count}")

    def _unused(self, name: str) -> str:
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name


def signature(kernel: Kernel) -> str:
    """Numba's signature of a kernel."""
    kinds = {"t": "f8", "modes": "i8[::1]"}
    result = "i8" if kernel.watched else "void"
    if any(out.array == "return" for out in kernel.outputs):
        result = "f8"
    return f"{result}({', '.join(kinds.get(a, 'f8[::1]') for a in kernel.arguments)})"
