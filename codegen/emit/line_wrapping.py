"""How the lines of a generated module fit the page: statements, comments, Python literals."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from codegen.errors import GeneratedFileError

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
PAGE = 100  # characters in a line


def wrap_statement(head: str, text: str, note: str = "") -> Iterator[str]:
    """A statement on one line; where the page is too narrow, its note above, brackets around."""
    indent = head[: len(head) - len(head.lstrip())]
    if len(head) + len(text) + len(note) > PAGE and note:
        yield f"{indent}{note.strip()}"
        note = ""
    if len(head) + len(text) <= PAGE:
        yield f"{head}{text}{note}"
    else:
        yield from (f"{head}(", f"{indent}    {text}", f"{indent})")


def comments(titles: Sequence[str]) -> Iterator[str]:
    """Comments inside a function; titles that begin with the same word share a line."""
    line = ""
    for title in titles:
        verb = title.partition(" ")[0]
        joined = f"{line}; {title.removeprefix(verb).strip()}"
        if line.startswith(f"    # {verb} ") and len(joined) <= PAGE:
            line = joined
        else:
            yield from [line] if line else []
            line = f"    # {title}"
    yield from [line] if line else []


def wrap_pieces(head: str, pieces: Sequence[str], end: str) -> Iterator[str]:
    """Pieces between `head` and `end` on one line; else on lines of their own."""
    line = f"{head}{' '.join(pieces)}{end}"
    if len(line) <= PAGE:
        yield line
        return
    indent = head[: len(head) - len(head.lstrip())]
    yield from (head, *filled(pieces, f"{indent}    "), f"{indent}{end}")


def filled(pieces: Iterable[str], indent: str) -> list[str]:
    """Lines of pieces, none of which is broken."""
    lines: list[str] = []
    for piece in pieces:
        if lines and len(lines[-1]) + 1 + len(piece) <= PAGE:
            lines[-1] += f" {piece}"
        else:
            lines.append(f"{indent}{piece}")
    return lines


def items(text: str) -> list[str]:
    """The items of a list, each with the comma behind it."""
    return text.replace(", ", ",\n").split("\n")


# -- literals laid out as a formatter would ----------------------------------------------------


def assignment(name: str, value: Any) -> list[str]:
    """``NAME = literal``, on one line if it fits, else one element a line."""
    is_long = isinstance(value, tuple | list) and len(value) > PAGE
    if not is_long and len(line := f"{name} = {literal(value)}") <= PAGE:
        return [line]
    if all(isinstance(item, int) for item in value):
        rows = filled((f"{item}," for item in value), "    ")
        return [f"{name} = (", "    # fmt: off", *rows, "    # fmt: on", ")"]
    return [f"{name} = (", *(line for item in value for line in _row(item)), ")"]


def literal(value: Any) -> str:
    """A number, text, or tuple of them, as it stands in the text; nothing else can be written."""
    if isinstance(value, str):
        return f'"{_escaped(value)}"'
    if isinstance(value, bool) or value is None:
        return str(value)
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float) and math.isfinite(value):
        return float.__repr__(value)
    if isinstance(value, tuple | list):
        inside = ", ".join(literal(item) for item in value)
        return f"({inside},)" if len(value) == 1 else f"({inside})"
    raise GeneratedFileError(
        f"a value of type {type(value).__name__} stands where a generated module holds numbers, "
        "names and text; nothing else is written."
    )


def _escaped(text: str) -> str:
    """The characters of a text between quotes, those that do not print by their numbers."""
    if text.isprintable() and '"' not in text and "\\" not in text:
        return text
    marks = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    return "".join(marks.get(c) or (c if c.isprintable() else ascii(c)[1:-1]) for c in text)


def identifier(name: str) -> str:
    """A name in the text."""
    if not IDENTIFIER.fullmatch(name):
        raise GeneratedFileError(f"{literal(name)} cannot be a name in a generated module.")
    return name


def prose(text: str) -> str:
    """Text of a comment or a docstring: one line, that ends neither of them."""
    plain = text.replace("\\", "/").replace('"""', "'" * 3)
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in plain)


def checked(lines: Sequence[str]) -> str:
    """The text of lines, each of which is one."""
    if broken := [line for line in lines if not line.isprintable()]:
        raise GeneratedFileError(
            f"{literal(broken[0])} cannot be a line of a generated module; use plain names."
        )
    return "\n".join(lines) + "\n"


def _row(item: Any, depth: int = 1) -> list[str]:
    indent = "    " * depth
    line = f"{indent}{literal(item)},"
    if len(line) <= PAGE or not isinstance(item, tuple | list):
        return [line]
    inside = (row for part in item for row in _row(part, depth + 1))
    return [f"{indent}(", *inside, f"{indent}),"]
