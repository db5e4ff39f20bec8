"""How the lines of a generated function fit the page."""

from collections.abc import Iterator, Sequence

from codegen.lower.program import Output

PAGE = 100
"""Characters in a line."""


def tail(lines: list[str]) -> str:
    """What the last of the lines sets its name to."""
    return lines[-1].partition(" = ")[2]


def fitted(head: str, text: str, note: str = "") -> Iterator[str]:
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


def note_of(out: Output) -> str:
    """What a line that stores an output says behind it."""
    return f"  # {out.note}" if out.note else ""
