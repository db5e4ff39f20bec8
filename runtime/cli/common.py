"""What commands of the runtime share: texts read from options, refusals, the two streams."""

import json
import sys
from typing import Any, NoReturn

import typer

from codegen.errors import InputError


def refuse(problems: tuple[str, ...], status: int, as_json: bool) -> NoReturn:
    """Say what is wrong and end."""
    for problem in problems:
        say(f"error: {problem}")
    if as_json:
        print_json({"ok": False, "status": status, "problems": list(problems)})
    raise typer.Exit(status)


def pairs(given: list[str] | None, option: str) -> dict[str, float]:
    """NAME=VALUE texts as a mapping."""
    pairs, problems = {}, []
    for text in given or []:
        name, equals, value = text.partition("=")
        try:
            pairs[name.strip()] = float(value)
        except ValueError:
            equals = ""
        if not equals:
            problems.append(f"{option} {text}: write NAME=VALUE with a number.")
    if problems:
        raise InputError(problems)
    return pairs


def say(text: str) -> None:
    """Write a line to stderr."""
    sys.stderr.write(text + "\n")


def print_json(content: dict[str, Any]) -> None:
    """Write one JSON object to stdout."""
    sys.stdout.write(json.dumps(content) + "\n")
