"""Documents of data, YAML or JSON, read with the lines of their values, and written.

YAML is read by its core schema (version 1.2) from PyYAML's tree of nodes, so that no tag constructs
anything, `1e-8` is a number and `on` a text. JSON is read by Python's own reader. Keys are words,
and a key that stands twice is refused.
"""

import json
import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from os import PathLike, fspath
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError, module_of_extra
from codegen.readers.values import finite_float, shown

ENDINGS = (".yaml", ".yml", ".json")
_MOST_BYTES = 1 << 20  # safety: of a document
_MOST_VALUES = 100_000  # safety: of a document, aliases written out
_DEEPEST = 20  # safety: mappings and lists in one another
_WIDTH = 100  # layout: characters of a line

_TAG = "tag:yaml.org,2002:"
_RESOLVED = (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]+", list("-+0123456789")),
    ("float", r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?", list("-+0123456789.")),
)
"""Tags of plain scalars in YAML's core schema, but for octal, hexadecimal, infinite and nan."""

_SCALARS: dict[str, Callable[[str], Any]] = {
    "str": str,
    "null": lambda _: None,
    "bool": lambda text: ("false", "true").index(text.lower()) == 1,
    "int": int,
    "float": float,
}
Place = tuple[str | int, ...]
"""Keys and indices that lead to a value."""


class Document(NamedTuple):
    """Nested mappings, lists, texts, numbers, True, False and None, with the lines of a file."""

    data: Any
    file: Path | None = None
    lines: Mapping[Place, int] = {}

    def line(self, at: Place) -> int | None:
        """The line of a value, or of what it would lie in; None where lines are not known."""
        return next(
            (self.lines[at[:n]] for n in range(len(at), -1, -1) if at[:n] in self.lines), None
        )

    def place(self, at: Place) -> str:
        """The file and the line of a value, as messages begin."""
        return _place(self.file or "Case", self.line(at))

    def problem(self, at: Place, why: str, line_of: Place | None = None) -> str:
        """A sentence about a value, behind its file, its line and its path in the document."""
        where = self.place(at if line_of is None else line_of)
        path = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in at)
        return f"{where}{', ' * bool(path)}{path.removeprefix('.')}: {why}"


def _place(file: object, line: int | None) -> str:
    return f"{file}" if line is None else f"{file}, line {line}"


def plain(value: Any) -> Any:
    """Data of Python as documents have them: NumPy's arrays and numbers too, and paths as texts.

    All else stays as it is, so that the check of its field can refuse it.
    """
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(part) for part in value]
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, str | int | float | None):
        return value
    number = finite_float(value)
    if number is None:
        return fspath(value) if isinstance(value, PathLike) else value
    return number


def require_ending(path: Path) -> None:
    """Refuse files of other formats."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: a case is a file ending in {', '.join(ENDINGS)}.")


def read_document(path: Path) -> Document:
    """The data of a file; InputError says its line where something is wrong."""
    require_ending(path)
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise InputError(f"{path} has more than {_MOST_BYTES >> 20} MiB, and is no case.")
        text = content.decode("utf-8-sig")
        return _of_json(path, text) if path.suffix.lower() == ".json" else _of_yaml(path, text)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8 ({error.reason}).") from error
    except RecursionError as error:
        raise InputError(f"{path} has lists or mappings that are too deep.") from error


def _of_json(path: Path, text: str) -> Document:
    def mapping(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
        found = dict[str, Any]()
        for name, value in pairs:
            if name in found:
                raise InputError(f"{path}: {shown(name)} stands twice in one mapping; keep one.")
            found[name] = value
        return found

    try:
        return Document(json.loads(text, object_pairs_hook=mapping), path)
    except ValueError as error:  # of a number of thousands of digits it has no line
        where, why = _place(path, getattr(error, "lineno", None)), getattr(error, "msg", error)
        raise InputError(f"{where}: {why}; the file is no JSON.") from error


def _of_yaml(path: Path, text: str) -> Document:
    yaml = _yaml_module(path)
    try:
        tree = yaml.compose(text, _with_core_schema("SafeLoader"))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        why = " ".join(str(error if mark is None else error.problem).split())
        raise _error(path, mark, f"{why}; the file is no YAML.") from error
    if tree is None:
        raise InputError(f"{path}: the file is empty.")
    lines = dict[Place, int]()
    return Document(_value(path, tree, (), lines), path, lines)


def _value(path: Path, node: Any, at: Place, lines: dict[Place, int]) -> Any:
    """The value of a node of PyYAML; what an alias names is written out again, lines are noted."""
    kind, mark = node.tag.removeprefix(_TAG), node.start_mark
    lines.setdefault(at, mark.line + 1)
    if len(lines) > _MOST_VALUES:
        raise _error(path, mark, f"it has more than {_MOST_VALUES} values, aliases written out.")
    if len(at) > _DEEPEST:
        raise _error(path, mark, f"it has more than {_DEEPEST} mappings and lists in one another.")
    if (node.id, kind) == ("mapping", "map"):
        found = dict[str, Any]()
        for key, value in node.value:
            name, mark = key.value, key.start_mark
            if key.tag != f"{_TAG}str":
                raise _error(path, mark, f"the key {shown(name)} is no word; quote it.")
            if name in found:
                raise _error(path, mark, f"{shown(name)} stands twice in one mapping.")
            lines[*at, name] = mark.line + 1  # a value has the line of its key
            found[name] = _value(path, value, (*at, name), lines)
        return found
    if (node.id, kind) == ("sequence", "seq"):
        return [_value(path, part, (*at, k), lines) for k, part in enumerate(node.value)]
    if node.id != "scalar" or kind not in _SCALARS:
        raise _error(path, mark, f"the tag {shown(node.tag)} is none of a case: it has data alone.")
    try:
        return _SCALARS[kind](node.value)
    except ValueError as error:
        raise _error(path, mark, f"{shown(node.value)} is no {kind}.") from error


def _error(path: Path, mark: Any, why: str) -> InputError:
    """The error about something that a document must not have."""
    return InputError(f"{_place(path, mark and mark.line + 1)}: {why}")


def text_of(data: dict[str, Any], path: Path) -> str:
    """The document by the ending of `path`, its keys in their order; it is read with the same bits.

    Texts that YAML's core schema would read as something else are quoted.
    """
    if path.suffix.lower() == ".json":
        return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    dumper = _with_core_schema("SafeDumper")
    written: str = _yaml_module(path).dump(
        data, Dumper=dumper, sort_keys=False, allow_unicode=True, width=_WIDTH
    )
    return written


def _yaml_module(path: object) -> Any:
    """PyYAML; InputError where it is missing."""
    needs = f"{path}: YAML needs the library PyYAML"
    return module_of_extra("yaml", "files", needs, ", or use .json")


@cache
def _with_core_schema(name: str) -> Any:
    """A loader or dumper of PyYAML that takes plain scalars by YAML's core schema."""
    kind = getattr(_yaml_module("YAML"), name)
    own = {"yaml_implicit_resolvers": {}, "ignore_aliases": lambda *_: True}
    made: Any = type(name, (kind,), own)
    for tag, form, first in _RESOLVED:
        made.add_implicit_resolver(_TAG + tag, re.compile(rf"(?:{form})\Z"), first)
    return made
