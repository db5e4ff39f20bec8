"""Options, refusals and output streams that the commands of the runtime share."""

import json
import os
import sys
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from codegen.errors import InputError, LinkwrightError
from runtime.cli.case_of_command import read_case, values_of_case

if TYPE_CHECKING:
    from runtime.machine_facade import Machine


def option(text: str, *names: str, **limits: Any) -> Any:
    """An option of a command, with its help."""
    return typer.Option(*names, help=text, **limits)


Model = Annotated[
    str,
    typer.Argument(
        help="Path of a model file, or a name: models/NAME.py. Or a case, .yaml or .json, whose "
        "values hold where no option gives another one.",
        callback=read_case,
        is_eager=True,
    ),
]
Scene = Annotated[str | None, option("Scene of the model; the first unless given.")]
Values = Annotated[
    list[str] | None, option("NAME=VALUE: a parameter, in its declared unit.", "--set")
]
Guess = Annotated[
    list[str] | None,
    option("NAME=VALUE: where the search for a start begins, in SI units; no name that is fixed.",
           "--guess"),
]  # fmt: skip
Generated = Annotated[
    Path | None, option("Folder of the generated modules, as --out of build names it.")
]
Start = Annotated[
    list[str] | None, option("NAME=VALUE: a start value that is kept, in SI units.", "--start")
]
Json = Annotated[bool, option("Print one JSON object on stdout.", "--json")]
TEnd = Annotated[float, option("Last instant in s.", "--t-end")]
OptionalTEnd = Annotated[float | None, option("Last instant in s.", "--t-end")]
TStart = Annotated[
    float, option("First instant in s; the start values belong to t = 0.", "--t-start")
]
MotionStart = Annotated[
    float, option("First instant in s; the start values belong to it.", "--t-start")
]


def start_values(
    parameters: list[str] | None, guess: list[str] | None, start: list[str] | None = None,
    machine: "Machine | None" = None,
) -> dict[str, Any]:  # fmt: skip
    """The arguments `parameters`, `guess` and `start` of an analysis, the last where given.

    They are those of the options --set, --guess and --start, over those of a case, which may bring
    conditions and instants besides.
    """
    values: dict[str, dict[str, float]] = {"parameters": {}, "guess": {}}
    values |= {"start": {}} if start else {}
    options = [("parameters", "--set", text) for text in parameters or ()]
    options += [("guess", "--guess", text) for text in guess or ()]
    options += [("start", "--start", text) for text in start or ()]
    problems = []
    for argument, option, text in options:
        name, _, value = text.partition("=")
        name = name.strip()
        if name in values[argument]:
            problems.append(f"{option} {name} is given twice; give one value.")
        try:
            values[argument][name] = float(value)  # "" where there is no =
        except ValueError:
            problems.append(f"{option} {text}: write NAME=VALUE with a number.")
    if problems:
        raise InputError(problems)
    of_case = values_of_case(machine)
    return of_case | {name: of_case.get(name, {}) | given for name, given in values.items()}


def show_warnings_as_notes() -> None:
    """Have a warning shown as one line, without the place in the source that it comes from."""
    warnings.formatwarning = lambda message, *_, **__: f"note: {message}\n"


@contextmanager
def exit_on_error(as_json: bool) -> Iterator[None]:
    """End the process with status 2 for wrong input, with 1 for an analysis that failed."""
    try:
        yield
    except InputError as error:
        refuse(error.problems, 2, as_json)
    except (LinkwrightError, OSError) as error:
        refuse((str(error),), 1, as_json)
    except EOFError as error:  # of which the command line would say "Aborted." alone
        reading = [frame.f_locals for frame, _ in traceback.walk_tb(error.__traceback__)]
        names = [str(names["fullname"]) for names in reading if "fullname" in names]
        damaged = f"the byte code of {names[-1]} is damaged" if names else "a file ends too early"
        advice = "Delete the folders __pycache__ of that package, or install it anew."
        refuse((f"{damaged} ({error}). {advice if names else ''}".strip(),), 1, as_json)


def error_head() -> str:
    """The word that begins an error, red in a terminal unless NO_COLOR is set."""
    plain = bool(os.environ.get("NO_COLOR")) or not sys.stderr.isatty()
    return "error:" if plain else "\x1b[1;31merror:\x1b[0m"


def refuse(problems: tuple[str, ...], status: int, as_json: bool) -> NoReturn:
    """Write the problems and end the process."""
    for problem in problems:
        write_line(f"{error_head()} {problem}")
    if as_json:
        print_json({"ok": False, "status": status, "problems": list(problems)})
    raise typer.Exit(status)


def write_line(text: str) -> None:
    """Write a line to stderr, if that is still there: a terminal may have been closed."""
    with suppress(OSError):
        sys.stderr.write(text + "\n")


def print_json(content: dict[str, Any]) -> None:
    """Write one JSON object to stdout."""
    sys.stdout.write(json.dumps(content) + "\n")
