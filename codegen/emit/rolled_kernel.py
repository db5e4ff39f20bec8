"""One kernel in parts → the text of one numba function with loops, and its tables of indices."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from codegen.emit.kernel import Arguments, heading
from codegen.emit.line_wrapping import filled, literal, prose, wrap_statement
from codegen.emit.module_functions import lookups
from codegen.emit.statements import NOTHING, PREFIXES, Scope, Statements
from codegen.lower.program import LOGICAL, Input, Kernel, Lookup, Output, Program
from codegen.reroll.parts import WORK, Batches, Carried, Entries, Numbers, Part, RolledKernel, Watch
from codegen.reroll.sequence import Slots

COUNTER, RUN = "k", "run"
Text = Callable[[], str]
"""A piece of text that is known once all columns of the tables are."""
Assignment = tuple[str, Text]
"""A name and what it is set to."""


class Table:
    """Columns of numbers, one row a turn, that stand row by row in one array of the module."""

    def __init__(self, name: str, dtype: str) -> None:
        self.name, self.dtype, self.columns = name, dtype, list[tuple[float, ...]]()

    def place(self, column: Slots | Numbers) -> int:
        """The column's place in a row."""
        entry = tuple(column.tolist())
        if entry not in self.columns:
            self.columns.append(entry)
        return self.columns.index(entry)

    def entry(self, place: int, counter: str = COUNTER) -> str:
        """The entry of a turn; valid once all columns are there."""
        width = len(self.columns)
        row = counter if width == 1 else f"{width} * {counter}"
        return f"{self.name}[{row} + {place}]" if place else f"{self.name}[{row}]"

    def lines(self) -> list[str]:
        """The assignment; nothing of a table without columns."""
        if not self.columns:
            return []
        entries = [literal(x) for row in zip(*self.columns, strict=True) for x in row]
        rows = filled((f"{entry}," for entry in entries), "        ")
        head = [f"{self.name} = np.array(", "    (", "        # fmt: off"]
        return [*head, *rows, "        # fmt: on", "    ),", f"    dtype=np.{self.dtype},", ")"]


class RolledKernelText:
    """Writes a kernel in parts."""

    def __init__(
        self, program: Program, kernel: Kernel, rolled: RolledKernel, arguments: Arguments
    ) -> None:
        self.program, self.kernel, self.rolled = program, kernel, rolled
        self.arguments, self._lookups = arguments, lookups(program)
        self.tables: list[Table] = []
        self.workspace = rolled.workspace  # slots of an array of its own
        self.has_pairs = False  # whether it takes sine and cosine together
        scope = Scope([*kernel.arguments, *self._lookups.values(), COUNTER, RUN, WORK])
        self._body = [
            line
            for part in rolled.parts
            for line in (
                self._batches(part, scope) if isinstance(part, Batches) else self._part(part, scope)
            )
        ]
        self._body += self._watch(rolled.watch)
        self._body += self._result(rolled.result)

    def lines(self) -> list[str]:
        """The function, line by line."""
        room = [f"    {WORK} = np.empty({self.workspace})"] if self.workspace else []
        return [*heading(self.program, self.kernel, self.arguments), *room, *self._body]

    def table_lines(self) -> list[str]:
        """The tables that the function reads."""
        return [line for table in self.tables for line in table.lines()]

    def _table(self, dtype: str) -> Table:
        self.tables.append(Table(f"{self.kernel.name.upper()}_{len(self.tables) + 1}", dtype))
        return self.tables[-1]

    def _part(self, part: Part, scope: Scope) -> Iterator[str]:
        is_loop = part.count > 1
        text = self._part_text(part, scope, 2 if is_loop else 1)
        yield from text.before("    ")
        if is_loop:
            one, last = part.span
            yield f"    # {prose(f'From {one} to {last}') if one and last else 'Copies'}"
            yield f"    for {COUNTER} in range({part.count}):"
        yield from text.turn()

    def _batches(self, batches: Batches, scope: Scope) -> Iterator[str]:
        table = self._table("uint32")
        kind, first, end = (table.place(column) for column in batches.runs.T)
        yield f"    for {RUN} in range({len(batches.runs)}):"
        for number, part in enumerate(batches.kinds):
            text = self._part_text(part, scope, 4)
            branch = f"{'elif' if number else 'if'} {table.entry(kind, RUN)} == {number}:"
            yield f"        {branch}"
            yield from text.before(" " * 12)
            rows = f"{table.entry(first, RUN)}, {table.entry(end, RUN)}"
            yield f"            for {COUNTER} in range({rows}):"
            yield from text.turn()

    def _part_text(self, part: Part, scope: Scope, depth: int) -> "PartText":
        text = PartText(part, self.kernel, scope, self._lookups, self._table, depth)
        self.has_pairs |= bool(text.plan.pairs)
        return text

    def _watch(self, watch: Watch | None) -> Iterator[str]:
        if watch is None:
            return
        if len(watch.parts):
            table, parts = self._table("uint32"), self._table("float64")
            at = [table.place(x) for x in (watch.pivots, watch.references, watch.constraints)]
            pivot, reference, constraint = (table.entry(k) for k in at)
            share = column_text(watch.parts, parts)
            limit = "WEAK_PIVOT" if share == "1.0" else f"{share} * WEAK_PIVOT"
            yield f"    for {COUNTER} in range({len(watch.parts)}):"
            yield f"        if not {WORK}[{pivot}] > {limit} * {WORK}[{reference}]:"
            yield f"            return {constraint}"
        yield "    return 0"

    def _result(self, result: Entries | float | None) -> Iterator[str]:
        if result is not None:
            yield f"    return {first_text(result)}"


class PartText(Statements):
    """Writes one part of a kernel, `depth` levels inside the function."""

    def __init__(
        self, part: Part, kernel: Kernel, scope: Scope, names: Mapping[Lookup, str],
        table: Callable[[str], Table], depth: int,
    ) -> None:  # fmt: skip
        self.part = part
        self._kept = [(k, o) for k, o in enumerate(part.operands) if isinstance(o, Carried)]
        roots = [store.value for store in part.stores] + [o.value for _, o in self._kept]
        outputs = tuple(Output("", k, value) for k, value in enumerate(roots))
        own = Kernel(kernel.name, "", (), outputs, labels=part.labels)
        program = Program(part.body, (own,), (), 0.0)
        super().__init__(program, own, scope, names, depth)
        self._places: dict[int, int] = {}  # operand → its place in the body
        self._indices = table("uint32")
        self._numbers = table("float64")
        self._once, self._each = list[Assignment](), list[Assignment]()
        self._name_operands()
        self._slots = [self._index(store.slots) for store in part.stores]

    def _name_operands(self) -> None:
        for number, value in enumerate(self.part.body):
            if not isinstance(value.literal, Input):
                continue
            if value.literal.array == "t":
                self.names[number] = "t"
                continue
            operand = self.part.operands[value.literal.slot]
            self._places[value.literal.slot] = number
            name = self.names[number] = self._called(number, value.literal.name)
            fixed = isinstance(operand, Carried) or is_fixed(operand)
            (self._once if fixed else self._each).append((name, self._operand(operand)))

    def before(self, indent: str) -> Iterator[str]:
        """The operands that are read before the first turn."""
        yield from (f"{indent}{name} = {text()}" for name, text in self._once)

    def turn(self) -> Iterator[str]:
        """A turn, line by line."""
        indent = "    " * self.depth
        yield from (f"{indent}{name} = {text()}" for name, text in self._each)
        yield from self.statements()
        for store, slot in zip(self.part.stores, self._slots, strict=True):
            text = self._text(store.value, NOTHING)
            if self.values[store.value].op in LOGICAL:
                text = f"1.0 if {text} else 0.0"
            yield from wrap_statement(f"{indent}{store.array}[{slot()}] = ", text)
        if self._kept:
            left = ", ".join(self.names[self._places[k]] for k, _ in self._kept)
            right = ", ".join(self._text(o.value, NOTHING) for _, o in self._kept)
            yield from wrap_statement(f"{indent}{left} = ", right)

    def _called(self, number: int, name: str) -> str:
        if name:
            return self.scope.unused(name)
        user = next((v for v in self.values if number in v.args), None)
        serves = user.serves if user else ""
        return self.scope.counted(f"{PREFIXES.get(serves, serves)}_in")

    def _index(self, slots: Slots) -> Text:
        """The slot of a turn: a number, a straight line in the counter, or an entry of a table."""
        if is_straight(slots):
            return lambda: straight_line(slots)
        place = self._indices.place(slots)
        return lambda: self._indices.entry(place)

    def _operand(self, operand: Entries | Numbers | Carried) -> Text:
        if isinstance(operand, Carried):
            return lambda: first_text(operand.first)
        if isinstance(operand, Entries):
            if operand.array == "t":
                return lambda: "t"
            index, ending = self._index(operand.slots), " != 0.0" if operand.logical else ""
            return lambda: f"{operand.array}[{index()}]{ending}"
        if is_fixed(operand):
            return lambda: literal(float(operand[0]))
        place = self._numbers.place(operand)
        return lambda: self._numbers.entry(place)


def is_fixed(operand: Entries | Numbers) -> bool:
    """Whether an operand is the same in all turns."""
    column = operand.slots if isinstance(operand, Entries) else operand
    return bool((column == column[0]).all())


def is_straight(slots: Slots) -> bool:
    """Whether slots are a straight line in the number of the turn."""
    steps = np.diff(slots)
    return bool((steps == steps[:1]).all())


def straight_line(slots: Slots) -> str:
    """Slots on a straight line, as an expression in the counter."""
    first = int(slots[0])
    step = int(slots[1]) - first if len(slots) > 1 else 0
    if step == 0:
        return str(first)
    line = COUNTER if step == 1 else f"{step} * {COUNTER}"
    if step < 0:
        return f"{first} - {COUNTER}" if step == -1 else f"{first} - {-step} * {COUNTER}"
    return f"{line} + {first}" if first else line


def column_text(column: Numbers, table: Table) -> str:
    """A column of numbers: one number, or an entry of a table."""
    return literal(float(column[0])) if is_fixed(column) else table.entry(table.place(column))


def first_text(first: Entries | float) -> str:
    """A value that is read once."""
    if not isinstance(first, Entries):
        return literal(first)
    return "t" if first.array == "t" else f"{first.array}[{int(first.slots[0])}]"
