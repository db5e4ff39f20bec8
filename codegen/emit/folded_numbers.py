"""The numbers of a module that the compiler folded, and what they were folded from."""

from collections.abc import Iterator

from codegen.lower.program import Folded, Op, Program


def folded_numbers(program: Program) -> Iterator[str]:
    """A comment with a line a number, in the order of size; nothing where none was computed."""
    origins = {
        value.literal: value.origin
        for value in program.values
        if value.op is Op.CONST and value.origin is not None
    }
    needed = {
        abs(program.values[number].literal)  # type: ignore[arg-type]
        for kernel in program.kernels
        for number in program.reachable(kernel)
        if program.values[number].op is Op.CONST
    }
    found: dict[float, Folded] = {}
    while needed:
        number = needed.pop()
        origin = origins.get(number)
        if origin is not None and number not in found:
            found[number] = origin
            needed |= {abs(other) for other in origin.numbers}
    found.pop(0.0, None)
    if found:
        yield "# Folded numbers"
    for number in sorted(found):
        origin = found[number]
        yield f"#     {number!r} = {_formula(origin)}{f' ({origin.note})' if origin.note else ''}"


def _formula(origin: Folded) -> str:
    """How a positive number came about, signs worked into it."""
    if origin.sign in ("+", "-"):
        x, y = origin.numbers[0], float(f"{origin.sign}1") * origin.numbers[1]
        first, second = (x, y) if abs(x) >= abs(y) else (y, x)
        return f"{abs(first)!r} {'+' if first * second > 0 else '-'} {abs(second)!r}"
    if origin.sign in ("*", "/"):
        return f" {origin.sign} ".join(repr(abs(number)) for number in origin.numbers)
    return f"{origin.sign}({', '.join(map(repr, origin.numbers))})"
