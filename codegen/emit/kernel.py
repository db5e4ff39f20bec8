"""One kernel → the text of one numba function: its arguments, its docstring, its statements."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from textwrap import wrap

from codegen.emit.line_wrapping import literal, prose, wrap_statement
from codegen.emit.module_functions import lookups
from codegen.emit.statements import NOTHING, SIGN, SUM, Scope, Statements
from codegen.lower.module_tables import Description
from codegen.lower.operation_count import operations
from codegen.lower.program import Folded, Input, Kernel, Lookup, Op, Program
from codegen.object_display import counted

PER_COORDINATE = ("q", "v", "a", "w", "dq", "dv", "dq_in", "dv_in", "da", "Q", "g")
RATES = {"v": "/s", "a": "/s^2", "da": "/s^2", "dv": "/s", "dv_in": "/s", "all_v": "/s"}
"""Arguments that are rates of coordinates: what follows the coordinate's unit."""
AS_COORDINATES = ("q", "dq", "dq_in", "all_q", *RATES)


@dataclass(frozen=True)
class Arguments:
    """Shapes and units of arguments."""

    declared: int  # declared parameters, behind which the constants stand in `p`
    # argument → length; those of outputs follow from a kernel itself where they are missing
    sizes: Mapping[str, int] = field(default_factory=dict)
    units: tuple[str, ...] = ()  # of the coordinates

    @classmethod
    def of(
        cls, description: Description, kept: tuple[int, ...] | None = None, more: int = 0
    ) -> "Arguments":
        """Those of a scene, or of its equations in the coordinates `kept`.

        In ``p`` `more` entries that are no constants stand behind the parameters.
        """
        n = len(description.coordinates if kept is None else kept)
        sizes = dict.fromkeys(PER_COORDINATE, n)
        sizes |= {"lam": len(description.constraints), "modes": len(description.switches)}
        units = tuple(dict.fromkeys(unit for *_, unit in description.coordinates))
        return cls(len(description.parameters) + more, sizes, units)

    def slots(self, program: Program) -> dict[int, int]:
        """Constant → its slot in ``p``."""
        return {number: self.declared + k for k, number in enumerate(program.constants)}

    def lines(self, program: Program, kernel: Kernel) -> Iterator[str]:
        """What a kernel reads, writes and returns; nothing where no sizes are known."""
        if not self.sizes:
            return
        if kernel.name == "constants":
            behind = counted(len(program.constants), "constant")
            yield f"Reads {counted(self.declared, 'parameter')} in p, writes {behind} behind."
            return
        counts: dict[str, int] = {}
        for out in kernel.outputs:
            counts[out.array] = max(counts.get(out.array, 0), out.slot + 1)
        sizes = {**counts, **self.sizes, "p": self.declared + len(program.constants)}
        if kernel.name != "potential_gradient":
            sizes["g"] = counts.get("g", 0)
        texts = {name: self._text(name, sizes) for name in kernel.arguments}
        read = [text for name, text in texts.items() if name not in counts or name == "p"]
        written = [text for name, text in texts.items() if name in counts]
        sentence = f"Reads {', '.join(read)}."
        sentence += f" Writes {', '.join(written)}." if written else ""
        if kernel.watched:
            sentence += " Returns 0, or 1 + the row of CONSTRAINTS whose pivot is weak."
        yield from wrap(sentence, 94, break_long_words=False, break_on_hyphens=False)

    def _text(self, name: str, sizes: Mapping[str, int]) -> str:
        if name == "t":
            return "t in s"
        text = f"{name} ({sizes.get(name, 0)},)"
        if name in AS_COORDINATES and self.units:
            text += f" in {' or '.join(unit + RATES.get(name, '') for unit in self.units)}"
        return text


SIGNS = {Op.ADD: "+", Op.SUB: "-", Op.MUL: "*", Op.DIV: "/"}
LEVEL = {Op.ADD: 1, Op.SUB: 1, Op.NEG: 1, Op.MUL: 2, Op.DIV: 2}


def formula(program: Program, number: int) -> str:
    """The whole expression behind a value, in the modeller's names."""
    value = program.values[number]
    if value.op is Op.CONST:
        return f"{value.literal:g}"
    if isinstance(value.literal, Input):
        return value.literal.name
    if value.op is Op.NEG:
        return f"-{_inside(program, value.args[0], 2)}"
    if value.op in SIGNS:
        level = LEVEL[value.op]
        left = _inside(program, value.args[0], level)
        right = _inside(program, value.args[1], level + (value.op in (Op.SUB, Op.DIV)))
        return f"{left} {SIGNS[value.op]} {right}"
    name = value.literal.table.name if isinstance(value.literal, Lookup) else value.op.value
    return f"{name}({', '.join(formula(program, a) for a in value.args)})"


def _inside(program: Program, number: int, level: int) -> str:
    text = formula(program, number)
    return f"({text})" if LEVEL.get(program.values[number].op, 3) < level else text


def folded_numbers(program: Program) -> Iterator[str]:
    """A comment with a line a number, in the order of size; nothing where none was computed."""
    constants = {k: v for k, v in enumerate(program.values) if v.op is Op.CONST}
    origins = {v.literal: v.origin for v in constants.values() if v.origin is not None}
    needed = {
        abs(constants[number].literal)  # type: ignore[arg-type]
        for kernel in program.kernels
        for number in constants.keys() & program.reachable(kernel)
    }
    folded: dict[float, Folded] = {}
    while needed:
        number = needed.pop()
        if number in origins and number not in folded:
            folded[number] = origins[number]
            needed |= {abs(other) for other in origins[number].numbers}
    folded.pop(0.0, None)
    if folded:
        yield "# Folded numbers"
    for number, origin in sorted(folded.items()):
        note = f" ({prose(origin.note)})" if origin.note else ""
        yield f"#     {literal(number)} = {_origin(origin)}{note}"


def _origin(origin: Folded) -> str:
    """How a positive number came about, signs worked into it."""
    if origin.sign in ("+", "-"):
        x, y = origin.numbers[0], float(f"{origin.sign}1") * origin.numbers[1]
        first, second = (x, y) if abs(x) >= abs(y) else (y, x)
        return f"{literal(abs(first))} {'+' if first * second > 0 else '-'} {literal(abs(second))}"
    if origin.sign in ("*", "/"):
        return f" {origin.sign} ".join(literal(abs(number)) for number in origin.numbers)
    return f"{origin.sign}({', '.join(map(literal, origin.numbers))})"


NOTE_WIDTH = 60


class KernelText(Statements):
    """Writes one kernel, with the shapes and units of its arguments."""

    def __init__(self, program: Program, kernel: Kernel, arguments: Arguments) -> None:
        found = lookups(program)
        super().__init__(program, kernel, Scope([*kernel.arguments, *found.values()]), found)
        self.arguments = arguments
        slots = arguments.slots(program)
        self.constants = {n: slots[n] for n in self.plan.numbers if n in self.plan.hoisted}

    workspace = 0  # slots of an array of its own

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
    yield f"    {counted(operations(program, kernel), 'operation')}."
    yield '    """'


def signature(kernel: Kernel) -> str:
    """Numba's signature of a kernel."""
    kinds = {"t": "f8", "modes": "i8[::1]"}
    result = "i8" if kernel.watched else "void"
    if any(out.array == "return" for out in kernel.outputs):
        result = "f8"
    return f"{result}({', '.join(kinds.get(a, 'f8[::1]') for a in kernel.arguments)})"
