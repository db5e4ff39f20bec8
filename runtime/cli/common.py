"""Options, refusals and output streams that the commands of the runtime share."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any, NoReturn

import typer

from codegen.errors import InputError, LinkwrightError

Model = Annotated[str, typer.Argument(help="Path of a model file, or a name: models/NAME.py.")]
Scene = Annotated[str | None, typer.Option(help="Scene of the model; the first unless given.")]
Parameters = Annotated[
    list[str] | None, typer.Option("--set", help="NAME=VALUE: a parameter, in its declared unit.")
]
Guess = Annotated[
    list[str] | None, typer.Option("--guess", help="NAME=VALUE: a start value, in SI units.")
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]
TEnd = Annotated[float, typer.Option("--t-end", help="Last instant in s.")]
OptionalTEnd = Annotated[float | None, typer.Option("--t-end", help="Last instant in s.")]
TStart = Annotated[
    float, typer.Option("--t-start", help="First instant in s; the start values belong to t = 0.")
]
MotionStart = Annotated[
    float, typer.Option("--t-start", help="First instant in s; the start values belong to it.")
]


def start_values(parameters: list[str] | None, guess: list[str] | None) -> dict[str, Any]:
    """The arguments `parameters` and `guess` of an analysis, from the options --set and --guess."""
    values: dict[str, dict[str, float]] = {"parameters": {}, "guess": {}}
    options = [("parameters", "--set", text) for text in parameters or ()]
    options += [("guess", "--guess", text) for text in guess or ()]
    problems = []
    for argument, option, text in options:
        name, _, value = text.partition("=")
        try:
            values[argument][name.strip()] = float(value)  # "" where there is no =
        except ValueError:
            problems.append(f"{option} {text}: write NAME=VALUE with a number.")
    if problems:
        raise InputError(problems)
    return values


@contextmanager
def exit_on_error(as_json: bool) -> Iterator[None]:
    """End the process with status 2 for wrong input, with 1 for an analysis that failed."""
    try:
        yield
    except InputError as error:
        refuse(error.problems, 2, as_json)
    except (LinkwrightError, OSError) as error:
        refuse((str(error),), 1, as_json)


def refuse(problems: tuple[str, ...], status: int, as_json: bool) -> NoReturn:
    """Write the problems and end the process."""
    for problem in problems:
        write_line(f"error: {problem}")
    if as_json:
        print_json({"ok": False, "status": status, "problems": list(problems)})
    raise typer.Exit(status)


def write_line(text: str) -> None:
    """Write a line to stderr."""
    sys.stderr.write(text + "\n")


def print_json(content: dict[str, Any]) -> None:
    """Write one JSON object to stdout."""
    sys.stdout.write(json.dumps(content) + "\n")
