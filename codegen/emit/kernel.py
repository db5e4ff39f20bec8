"""One kernel → the text of one numba function."""

from collections.abc import Iterator

from codegen.emit.kernel_docstrings import Arguments, formula
from codegen.emit.line_wrapping import literal, prose, quantity, wrap_statement
from codegen.emit.module_functions import lookups
from codegen.emit.statements import NOTHING, SIGN, SUM, Scope, Statements
from codegen.lower.operation_count import operations
from codegen.lower.program import Input, Kernel, Op, Program

NOTE_WIDTH = 60


class KernelText(Statements):
    """Writes one kernel, with the shapes and units of its arguments."""

    def __init__(self, program: Program, kernel: Kernel, arguments: Arguments) -> None:
        found = lookups(program)
        super().__init__(program, kernel, Scope([*kernel.arguments, *found.values()]), found)
        self.arguments = arguments
        slots = arguments.slots(program)
        self.constants = {n: slots[n] for n in self.plan.numbers if n in self.plan.hoisted}

    workspace = 0  # slots behind the constants in ``p`` that it writes

    @property
    def has_pairs(self) -> bool:
        """Whether it takes sine and cosine together."""
        return bool(self.plan.pairs)

    def table_lines(self) -> list[str]:
        """The tables that the function reads: none."""
        return []

    def lines(self) -> list[str]:
        """The function, line by line."""
        return [
            *heading(self.program, self.kernel, self.arguments),
            *self._loads(),
            *self.statements(),
            *self._stores(),
            *self._watch(),
        ]

    def _loads(self) -> Iterator[str]:
        for number in self.plan.numbers:
            note, literal = "", self.values[number].literal
            if number in self.constants:
                name, source = f"p_{self.constants[number]}", f"p[{self.constants[number]}]"
                meaning = formula(self.program, number)
                note = f"  # {prose(meaning)}" if len(meaning) <= NOTE_WIDTH else ""
            elif isinstance(literal, Input):
                name, source = literal.name, f"{literal.array}[{literal.slot}]"
            elif self.values[number].op is Op.MODE:
                # Read before the first branch: numba counts references to an array behind one.
                name, source = f"mode_{literal}", f"modes[{literal}]"
            else:
                continue
            if isinstance(literal, Input) and literal.array == "t":
                self.names[number] = "t"
            else:
                self.names[number] = name = self.scope.unused(name)
                yield f"    {name} = {source}{note}"

    def _stores(self) -> Iterator[str]:
        outputs = sorted(self.kernel.outputs, key=lambda out: out.array == "return")
        if outputs and outputs[0].array != "return":
            yield "    # Outputs"
        for out in outputs:
            head = f"    {out.array}[{out.slot}] = " if out.array != "return" else "    return "
            note = f"  # {prose(out.note)}" if out.note else ""
            yield from wrap_statement(head, self._text(out.value, NOTHING), note)

    def _watch(self) -> Iterator[str]:
        if not self.kernel.watched:
            return
        for check in self.kernel.checks:
            pivot = self._text(check.pivot, SUM)
            reference = self._text(check.reference, SIGN)
            limit = "WEAK_PIVOT" if check.part == 1.0 else f"{literal(check.part)} * WEAK_PIVOT"
            yield f"    if not {pivot} > {limit} * {reference}:"
            yield f"        return {1 + check.constraint}"
        yield "    return 0"


def heading(program: Program, kernel: Kernel, arguments: Arguments) -> Iterator[str]:
    """The lines of a function before its first statement."""
    yield f'@numba.njit("{signature(kernel)}", **OPTIONS)'
    yield f"def {kernel.name}({', '.join(kernel.arguments)}):"
    yield f'    """{prose(kernel.summary)}'
    yield ""
    yield from (f"    {prose(line)}" for line in arguments.lines(program, kernel))
    yield f"    {quantity(operations(program, kernel), 'operation')}."
    yield '    """'


def signature(kernel: Kernel) -> str:
    """Numba's signature of a kernel."""
    kinds = {"t": "f8", "modes": "i8[::1]"}
    result = "i8" if kernel.watched else "void"
    if any(out.array == "return" for out in kernel.outputs):
        result = "f8"
    return f"{result}({', '.join(kinds.get(a, 'f8[::1]') for a in kernel.arguments)})"
