"""Readers of the arguments of public functions: any object in, a plain Python value out.

A reader returns a plain value (`float`, `str`, `dict`, ...), or raises `KindError` with the
sentence on what the argument must be. `reads` makes a function read its arguments so, and reports
all misfits at once. Nothing that a user gives is evaluated.
"""

import inspect
import math
import os
import sys
import warnings
from collections.abc import Callable, KeysView, Mapping
from contextlib import suppress
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from codegen.errors import InputError
from codegen.readers.calls import checked_call, failure, note_user_error
from codegen.readers.quantities import finite_in_unit
from codegen.readers.values import KindError, finite_float, is_flag, shown

Reader = Callable[[Any], Any]
Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")
_LONGEST = 255  # safety: characters of a name, which becomes part of a file's
_SHOWN = 60  # layout: characters of a value that a message quotes


def read_arguments(
    where: str, readers: Mapping[str, Reader], given: Mapping[str, Any],
    error: type[InputError] = InputError,
) -> dict[str, Any]:  # fmt: skip
    """The arguments `given` as plain values, by the reader of each name.

    Raises InputError: one sentence for each argument that does not fit, beginning with `where`.
    """
    values, problems = {}, []
    for name, value in given.items():
        try:
            values[name] = readers[name](value)
        except KindError as misfit:
            problems.append(f"{where}: {name} is {shown(value, _SHOWN)}; {misfit}")
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

        method = "self" in signature.parameters  # its class names it
        return checked_call(checked, None if method else f"{function.__name__}()")

    return decorate


def number(
    demand: str, *, above: float = -math.inf, below: float = math.inf, closed: bool = False,
    unit: str = "",
) -> Reader:  # fmt: skip
    """A finite real number between `above` and `below`, or equal to one of them if `closed`.

    Of one with a `unit` a quantity or its text will do, such as ``"20 ms"``.
    """

    def read(value: Any) -> float:
        parsed = finite_in_unit(value, unit) if unit else finite_float(value)
        if parsed is None or not (above < parsed < below or (closed and parsed in {above, below})):
            raise KindError(f"it must be {demand}.")
        return parsed

    return read


def count(least: int, most: int = 2**62) -> Reader:
    """A whole number from `least` to `most`; a float that is whole will do."""

    def read(value: Any) -> int:
        parsed = finite_float(value)
        if parsed is None or not parsed.is_integer() or not least <= parsed <= most:
            raise KindError(f"it must be a whole number from {least} to {most:g}.")
        return int(parsed)

    return read


def flag(value: Any) -> bool:
    """True or False."""
    if not is_flag(value):
        raise KindError("it must be True or False.")
    return bool(value)


def text(demand: str) -> Reader:
    """A text no longer than the name of a file may be."""

    def read(value: Any) -> str:
        if not isinstance(value, str):
            raise KindError(f"it must be {demand}, a text.")
        if len(value) > _LONGEST:
            raise KindError(f"it has {len(value)} characters; {_LONGEST} are permitted.")
        return str(value)  # also of numpy's texts

    return read


def word(*words: str | int) -> Reader:
    """One of a few words, or of a few whole numbers."""

    def read(value: Any) -> Any:
        plain: Any = value if isinstance(value, str) else finite_float(value)
        if plain not in words:
            raise KindError(f"it must be one of {', '.join(map(repr, words))}.")
        return words[words.index(plain)]

    return read


def _part(demand: str, reader: Reader, part: Any, what: str, *at: Any) -> Any:
    """A part as it is read; a misfit says what the whole must be, which part it is, and why."""
    try:
        return reader(part)
    except KindError as misfit:
        must, which = f"it must be {demand}", " ".join([what, *(shown(k, _SHOWN) for k in at)])
        why = str(misfit).removeprefix(must).lstrip(".; ")
        if why.startswith(("entry ", "a key ")):
            raise KindError(f"{must}; {which}, {why}") from misfit
        end = f"; {why}" if why else "."
        raise KindError(f"{must}; {which} is {shown(part)}{end}") from misfit


def several(reader: Reader, demand: str, least: int = 0) -> Reader:
    """A list, tuple, dictionary's keys or one-dimensional array of what `reader` reads, a tuple."""

    def read(value: Any) -> tuple[Any, ...]:
        listed = isinstance(value, list | tuple | KeysView) or getattr(value, "ndim", 0) == 1
        if not listed or len(value) < least:
            raise KindError(f"it must be {demand}.")
        return tuple(_part(demand, reader, part, "entry", k) for k, part in enumerate(value))

    return read


def row(demand: str, *readers: Reader) -> Reader:
    """A list or tuple with one entry for each of the readers, as a tuple."""

    def read(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple) or len(value) != len(readers):
            raise KindError(f"it must be {demand}.")
        pairs = enumerate(zip(readers, value, strict=True))
        return tuple(_part(demand, reader, part, "entry", k) for k, (reader, part) in pairs)

    return read


def mapping(demand: str, key: Reader, entry: Reader) -> Reader:
    """A mapping whose keys and values are read, as a dictionary."""

    def read(value: Any) -> dict[Any, Any]:
        if not isinstance(value, Mapping):
            raise KindError(f"it must be {demand}.")
        return {
            _part(demand, key, k, "a key"): _part(demand, entry, v, "entry", k)
            for k, v in value.items()
        }

    return read


def texts(example: str) -> Reader:
    """A sequence of texts, as a tuple."""
    return several(text("a name"), f"a sequence of names, such as {example}")


def values(example: str) -> Reader:
    """A mapping from names to numbers, as a dictionary; what is no finite number stays as it is."""

    def read(value: Any) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise KindError(f"it must be a mapping from names to numbers, such as {example}.")
        plain = {_name(key): (entry, finite_float(entry)) for key, entry in value.items()}
        return {key: entry if x is None else x for key, (entry, x) in plain.items()}

    return read


def _name(key: Any) -> str:
    """A name, or that of a coordinate, a velocity, a state or a parameter of a declaration."""
    if isinstance(key, str):
        return str(key)
    symbols = sys.modules.get("codegen.declare.symbols")  # not loaded: no key is of it
    if symbols is not None and isinstance(key, symbols.Coordinate | symbols.Velocity):
        return str(symbols.dotted(key))
    if symbols is not None and isinstance(key, symbols.Parameter):
        return str(key.name)
    raise KindError(f"its name {shown(key, _SHOWN)} is no text.")


def functions(example: str) -> Reader:
    """A mapping from names to functions, as a dictionary."""
    demand = f"a mapping from names to functions, such as {example}"
    return mapping(demand, text("a name"), function)


NOT_TEXT = (
    f"it is no text in {sys.getfilesystemencoding()}, in which Python reads names of files here; "
    "rename it, or set the environment variable PYTHONUTF8=1"
)


def path(value: Any) -> Path:
    """A path: a text or an `os.PathLike` that the file system can have."""
    try:
        plain = os.fspath(value)
    except TypeError:
        plain = None
    if not isinstance(plain, str) or not plain or "\0" in plain:
        raise KindError("it must be the path of a file or folder, as a text or pathlib.Path.")
    try:
        plain.encode()  # a name that cannot be decoded cannot be written into a file
        Path(plain).exists()
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or NOT_TEXT
        raise KindError(f"no file can have that path ({why}).") from error
    return Path(plain)


def instance(room: str, name: str, demand: str) -> Reader:
    """An object of the public class `name`, known by the room that defines it: none is imported."""

    def read(value: Any) -> Any:
        bases = ((base.__module__, base.__name__) for base in type(value).__mro__)
        if not any(base == name and module.startswith(room) for module, base in bases):
            raise KindError(f"it must be {demand}.")
        return value

    return read


def one_of(demand: str, *classes: type[Any]) -> Reader:
    """An object of one of the classes."""

    def read(value: Any) -> Any:
        if not isinstance(value, classes):
            raise KindError(f"it must be {demand}.")
        return value

    return read


def either(first: Reader, second: Reader) -> Reader:
    """What `first` reads, else what `second` reads; the second says what the argument must be."""

    def read(value: Any) -> Any:
        try:
            return first(value)
        except KindError:
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
        raise KindError("it must be a function.")
    return value  # type: ignore[no-any-return]


def reporter(value: Any) -> Callable[[str], None]:
    """A function that is called with a line of text; what it raises says whose it is."""
    given = function(value)
    with suppress(ValueError):  # of a function that has no signature
        try:
            inspect.signature(given).bind("")
        except TypeError as mismatch:
            raise KindError(f"it is called with one text ({mismatch}).") from mismatch

    def report(line: str) -> None:
        with note_user_error("the function given as progress="):
            given(line)

    return report


def study_reporter(value: Any) -> Callable[[str], None]:
    """As `reporter`; the first exception of its own ends the reports and not the study."""
    report, failed = reporter(value), False

    def report_until_failure(line: str) -> None:
        nonlocal failed
        if failed:
            return
        try:
            report(line)
        except Exception as error:
            failed = True
            what = f"{failure(error)}. The study goes on, and reports no more."
            warnings.warn(f"The function given as progress= raised {what}", stacklevel=2)

    return report_until_failure


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
