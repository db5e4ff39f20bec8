"""Streams of a command: results on stdout, messages and progress on stderr."""

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console


@cache
def console(*, stderr: bool = False) -> "Console":
    """The stream of results, or of messages; Rich takes a fifth of a start of the program."""
    from rich.console import Console

    return Console(stderr=stderr, soft_wrap=True, highlight=False)


def escaped(text: object) -> str:
    """Text in which square brackets are no marks of a style."""
    from rich.markup import escape

    return escape(str(text))


@contextmanager
def progress_shown(first: str = "starting") -> Iterator[Callable[[str], None]]:
    """A line in the terminal that tells the stage; the yielded function changes it."""
    with console(stderr=True).status(first, spinner="dots") as status:
        yield lambda message: status.update(escaped(message))


def print_json(content: dict[str, Any]) -> None:
    """Write one JSON object to stdout."""
    sys.stdout.write(json.dumps(content, default=str) + "\n")


def print_rows(rows: list[tuple[str, str]]) -> None:
    """Print titles and texts, a line each."""
    for title, text in rows:
        console().print(f"  {title:<13} {escaped(text)}")


def write_line(text: str) -> None:
    """Write a line to stderr, if that is still there: a terminal may have been closed."""
    with suppress(OSError):
        sys.stderr.write(text + "\n")


def write_error(problem: str) -> None:
    """Write a problem to stderr, its first word in red in a terminal unless NO_COLOR is set."""
    plain = bool(os.environ.get("NO_COLOR")) or not sys.stderr.isatty()
    head = "error:" if plain else "\x1b[1;31merror:\x1b[0m"
    write_line(f"{head} {problem}")
