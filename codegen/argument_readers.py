"""Readers of the arguments of public functions: any object in, a plain Python value out.

A reader returns a plain value (`float`, `str`, `dict`, ...), or raises `MisfitError` with the
sentence on what the argument must be. `reads` makes a function read its arguments so, and reports
all misfits at once. Nothing that a user gives is evaluated, and an object whose own methods fail
is a misfit.
"""

import inspect
import math
import os
from collections.abc import Callable, KeysView, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from codegen.errors import InputError

Reader = Callable[[Any], Any]
Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")
_LONGEST = 255  # safety: characters of a name, which becomes part of a file's
_SHOWN = 60  # layout: characters of a value that a message quotes


class MisfitError(Exception):
    """A reader's refusal; its text says what the argument must be."""


def read_arguments(
    where: str, readers: Mapping[str, Reader], given: Mapping[str, Any],
    error: type[InputError] = InputError,
) -> dict[str, Any]:  # fmt: skip
    """The arguments `given` as plain values, by the reader of each name.

    Raises
    ------
    InputError
        One sentence for each argument that does not fit, beginning with `where`.
    """
    values, problems = {}, []
    for name, value in given.items():
        try:
            values[name] = readers[name](value)
        except MisfitError as misfit:
            problems.append(f"{where}: {name} is {shortened(value)}; {misfit}")
        except InputError:
            raise
        except Exception as failure:
            why = f"{type(failure).__name__}: {failure}"
            problems.append(f"{where}: {name} is {shortened(value)}; reading it fails with {why}")
    if problems:
        raise error(problems)
    return values


def reads(
    **readers: Reader,
) -> Callable[[Callable[Arguments, Answer]], Callable[Arguments, Answer]]:
    """A function whose arguments of these names are read before it is called; see `Reader`."""

    def decorate(function: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
        signature = inspect.signature(function)

        @wraps(function)
        def checked(*positional: Arguments.args, **named: Arguments.kwargs) -> Answer:
            call = signature.bind(*positional, **named)
            given = {name: call.arguments[name] for name in readers if name in call.arguments}
            call.arguments.update(read_arguments(function.__name__, readers, given))
            return function(*call.args, **call.kwargs)

        return checked

    return decorate


def shortened(value: Any) -> str:
    """The value as written in Python, cut short; its type where it cannot be written."""
    try:
        text = repr(value)
    except Exception:
        text = f"an object of type {type(value).__name__} whose repr fails"
    text = text.encode("ascii", "backslashreplace").decode() if not text.isprintable() else text
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."


def real(value: Any) -> float | None:
    """A real number as a float; None for texts, booleans, complex and masked numbers, arrays."""
    kind = getattr(getattr(value, "dtype", None), "kind", "f")
    if isinstance(value, bool | str | bytes | bytearray) or kind not in "iufO":
        return None
    if getattr(value, "shape", ()) not in {(), None} or bool(getattr(value, "mask", False)):
        return None
    try:
        return float.__float__(value) if isinstance(value, float) else float(value)
    except (TypeError, ValueError, OverflowError):
        return None


def number(
    demand: str, *, above: float = -math.inf, below: float = math.inf, closed: bool = False
) -> Reader:
    """A finite real number between `above` and `below`, or equal to one of them if `closed`."""

    def read(value: Any) -> float:
        parsed = real(value)
        if parsed is None or not math.isfinite(parsed):
            raise MisfitError(f"it must be {demand}.")
        if not (above < parsed < below or (closed and parsed in {above, below})):
            raise MisfitError(f"it must be {demand}.")
        return parsed

    return read


def count(least: int, most: int = 2**62) -> Reader:
    """A whole number from `least` to `most`; a float that is whole will do."""

    def read(value: Any) -> int:
        parsed = real(value)
        if parsed is None or not parsed.is_integer() or not least <= parsed <= most:
            raise MisfitError(f"it must be a whole number from {least} to {most:g}.")
        return int(parsed)

    return read


def flag(value: Any) -> bool:
    """True or False."""
    if type(value).__name__ not in {"bool", "bool_"}:
        raise MisfitError("it must be True or False.")
    return bool(value)


def text(demand: str) -> Reader:
    """A text no longer than the name of a file may be."""

    def read(value: Any) -> str:
        if not isinstance(value, str):
            raise MisfitError(f"it must be {demand}, a text.")
        if len(value) > _LONGEST:
            raise MisfitError(f"it has {len(value)} characters; {_LONGEST} are permitted.")
        return str.__str__(value)

    return read


def several(reader: Reader, demand: str) -> Reader:
    """A list, tuple, dictionary's keys or one-dimensional array of what `reader` reads, a tuple."""

    def read(value: Any) -> tuple[Any, ...]:
        listed = isinstance(value, list | tuple | KeysView) or getattr(value, "ndim", 0) == 1
        try:
            return tuple(map(reader, value if listed else (None,)))
        except MisfitError as misfit:
            raise MisfitError(f"it must be {demand}.") from misfit

    return read


def texts(example: str) -> Reader:
    """A sequence of texts, as a tuple."""
    return several(text("a name"), f"a sequence of names, such as {example}")


def values(example: str) -> Reader:
    """A mapping from names to numbers, as a dictionary; what is no number stays as it is."""

    def read(value: Any) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise MisfitError(f"it must be a mapping from names to numbers, such as {example}.")
        entries = dict(value.items())
        for name in entries:
            if not isinstance(name, str):
                raise MisfitError(f"its name {shortened(name)} is no text.")
        plain = {str(name): real(entry) for name, entry in entries.items()}
        return {name: entries[name] if entry is None else entry for name, entry in plain.items()}

    return read


def path(value: Any) -> Path:
    """A path: a text or an `os.PathLike` that the file system can have."""
    try:
        plain = os.fspath(value)
    except TypeError:
        plain = None
    if not isinstance(plain, str) or not plain or "\0" in plain:
        raise MisfitError("it must be the path of a file or folder, as a text or pathlib.Path.")
    try:
        plain.encode()  # a name that cannot be decoded cannot be written into a file
        Path(plain).exists()
    except (OSError, UnicodeError) as error:
        raise MisfitError(f"no file can have that path ({error}).") from error
    return Path(plain)


def instance(room: str, name: str, demand: str) -> Reader:
    """An object of the public class `name`, known by the room that defines it: none is imported."""

    def read(value: Any) -> Any:
        bases = ((base.__module__, base.__name__) for base in type(value).__mro__)
        if not any(base == name and module.startswith(room) for module, base in bases):
            raise MisfitError(f"it must be {demand}.")
        return value

    return read


def either(first: Reader, second: Reader) -> Reader:
    """What `first` reads, else what `second` reads; the second says what the argument must be."""

    def read(value: Any) -> Any:
        try:
            return first(value)
        except MisfitError:
            return second(value)

    return read


def model(value: Any) -> Any:
    """The path of a model file or a model's name, as a text, or a `Model`."""
    if isinstance(value, str | os.PathLike):
        return str(path(value))
    return _MODEL(value)


def function(value: Any) -> Callable[..., Any]:
    """Something that can be called."""
    if not callable(value):
        raise MisfitError("it must be a function.")
    return value  # type: ignore[no-any-return]


def optional(reader: Reader) -> Reader:
    """None, or what `reader` reads."""
    return lambda value: None if value is None else reader(value)


_MODEL = instance(
    "codegen.model", "Model", 'a model: the path of its file, a name such as "pendulum", or a Model'
)
_SCENE = instance("codegen.declare", "Scene", "a scene: its name, or a Scene of the model")
scene = either(text("a name"), _SCENE)
"""The name of a scene, or a `Scene`."""
scenes = either(scene, several(scene, "a scene or a sequence of scenes, by name or as a Scene"))
"""One scene or several."""
