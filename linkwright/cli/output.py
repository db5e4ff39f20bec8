"""Streams of a command: results on stdout, messages and progress on stderr."""

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import typer

from codegen.object_display import counted


def bold(text: object) -> str:
    """Text that is bold in a terminal."""
    return typer.style(str(text), bold=True)


def sizes(scene: Any) -> str:
    """``4 coordinates, 3 constraints, 1 degree of freedom``, of a report on a scene."""
    counts = scene.coordinates, scene.constraints, scene.degrees_of_freedom
    return ", ".join(map(counted, counts, ("coordinate", "constraint", "degree of freedom")))


def print_rows(rows: list[tuple[str, str]]) -> None:
    """Print titles and texts, a line each."""
    for title, text in rows:
        typer.echo(f"  {title:<13} {text}")


def print_json(content: dict[str, Any]) -> None:
    """Write one JSON object to stdout."""
    sys.stdout.write(json.dumps(content, default=str) + "\n")


@contextmanager
def progress_shown(first: str = "starting") -> Iterator[Callable[[str], None]]:
    """A line in the terminal that tells the stage; the yielded function changes it."""
    from rich.console import Console  # which takes a fifth of a start of the program
    from rich.markup import escape

    with Console(stderr=True).status(first, spinner="dots") as status:
        yield lambda message: status.update(escape(message))


def write_line(text: str) -> None:
    """Write a line to stderr, if that is still there: a terminal may have been closed."""
    with suppress(OSError):
        sys.stderr.write(text + "\n")


def write_error(problem: str, head: str = "error:") -> None:
    """Write a problem to stderr, its first word in red in a terminal unless NO_COLOR is set."""
    plain = bool(os.environ.get("NO_COLOR")) or not sys.stderr.isatty()
    write_line(f"{head} {problem}" if plain else f"\x1b[1;31m{head}\x1b[0m {problem}")
