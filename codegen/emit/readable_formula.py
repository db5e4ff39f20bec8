"""Values written out as formulas, for people: expressions, and the origins of folded numbers."""

from collections.abc import Iterator

from codegen.emit.line_wrapping import literal, prose
from codegen.lower.program import Folded, Input, Lookup, Op, Program

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
